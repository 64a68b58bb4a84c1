/* Mass properties of a body of uniform density from its surface. */
#ifndef KM_MODEL_GEOMETRY_MASS_PROPERTIES_H
#define KM_MODEL_GEOMETRY_MASS_PROPERTIES_H

#include "model/geometry/mesh.h"
#include "model/geometry/solids.h"

typedef struct km_mass_properties {
  double volume;     /* length³, positive */
  km_vec3 center;    /* length */
  double inertia[6]; /* length⁵: Ixx Iyy Izz Ixy Iyz Izx for density 1 about the centre of mass, entries of the
                      * matrix */
  bool inside_out;   /* the faces were oriented inwards and have been reversed */
} km_mass_properties;

/* Faults of a surface that prevent it from enclosing a volume. */
typedef struct km_mesh_faults {
  int open_edges;  /* edges with an odd number of triangles */
  int mixed_edges; /* edges whose triangles have inconsistent orientation */
} km_mesh_faults;

/* Finds the faults of a surface. KM_MEMORY. Cost: n log n. */
km_status km_mesh_check(const km_mesh *mesh, km_mesh_faults *out, km_error *error);

/* Computes mass properties, exact for the polyhedron: ∫ 1, x, x xᵀ dV over signed tetrahedra between the triangles
 * and a point in the mesh's bounding box (divergence theorem; B. Mirtich, Fast and accurate computation of
 * polyhedral mass properties, 1996; D. Eberly, Polyhedral mass properties, 2002). Precondition: the mesh has no
 * faults. KM_MODEL if the volume is 0. Cost: linear. */
km_status km_mass_properties_of(const km_mesh *mesh, km_mass_properties *out, km_error *error);

/* Mass properties, for density 1, of a surface that may have faults. KM_MODEL, with the surface's name: it isn't
 * closed, its orientation is inconsistent, or its volume is 0; KM_MEMORY. */
km_status km_mesh_weigh(const km_mesh *mesh, const char *name, km_mass *out, km_error *error);

/* Principal moments of an inertia (Ixx Iyy Izz Ixy Iyz Izx) and their unit axes, unordered, to 1e-15 of the largest
 * moment, by Jacobi's method. */
void km_principal_axes(const double inertia[6], double moments[3], km_vec3 axes[3]);
/* The inertia with given principal moments and axes. */
void km_inertia_about(const double moments[3], const km_vec3 axes[3], double inertia[6]);
/* Principal moments of an inertia (Ixx Iyy Izz Ixy Iyz Izx) in ascending order, to 1e-15 of the largest, by Jacobi's
 * method. */
void km_principal_moments(const double inertia[6], double moments[3]);

#endif
