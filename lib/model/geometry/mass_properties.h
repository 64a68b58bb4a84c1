/* Mass properties of a body of uniform density from its surface. */
#ifndef KM_MODEL_GEOMETRY_MASS_PROPERTIES_H
#define KM_MODEL_GEOMETRY_MASS_PROPERTIES_H

#include "model/geometry/mesh.h"
#include "model/geometry/solids.h"

typedef struct km_mass_properties {
  double volume;     /* length³, positive */
  km_vec3 center;    /* length */
  double inertia[6]; /* length⁵: Ixx Iyy Izz Ixy Iyz Izx for density 1, the matrix's own entries, about the centre */
  bool inside_out;   /* the faces looked inwards; they were turned round */
} km_mass_properties;

/* What keeps a surface from enclosing a volume. */
typedef struct km_mesh_faults {
  int open_edges;  /* sides of an odd number of triangles */
  int mixed_edges; /* sides whose triangles don't face the same way */
} km_mesh_faults;

/* KM_MEMORY only. Cost: n log n. */
km_status km_mesh_check(const km_mesh *mesh, km_mesh_faults *out, km_error *error);

/* Exact for the polyhedron: ∫ 1, x, x xᵀ dV over the signed tetrahedra between the triangles and a point inside
 * the mesh's box (divergence theorem; B. Mirtich, Fast and accurate computation of polyhedral mass properties,
 * 1996; D. Eberly, Polyhedral mass properties, 2002). Precondition: the mesh has no faults. KM_MODEL if it
 * encloses no volume. Cost: linear. */
km_status km_mass_properties_of(const km_mesh *mesh, km_mass_properties *out, km_error *error);

/* The same of a surface that may have faults, as a mass of density 1. KM_MODEL, with the surface's name: it isn't closed, its
 * faces look opposite ways, or it encloses no volume; KM_MEMORY. */
km_status km_mesh_weigh(const km_mesh *mesh, const char *name, km_mass *out, km_error *error);

/* The principal moments of an inertia (Ixx Iyy Izz Ixy Iyz Izx) and their unit axes, in no order; each moment to 1e-15 of the
 * largest. Jacobi's method. */
void km_principal_axes(const double inertia[6], double moments[3], km_vec3 axes[3]);
/* The inertia with these. */
void km_inertia_about(const double moments[3], const km_vec3 axes[3], double inertia[6]);
/* The principal moments of an inertia (Ixx Iyy Izz Ixy Iyz Izx), rising; each to 1e-15 of the largest. Jacobi's method.
 */
void km_principal_moments(const double inertia[6], double moments[3]);

#endif
