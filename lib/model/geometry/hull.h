/* Convex hulls of points. */
#ifndef KM_MODEL_GEOMETRY_HULL_H
#define KM_MODEL_GEOMETRY_HULL_H

#include "model/geometry/mesh.h"

/* Computes the convex hull of a mesh's vertices, with outward triangles. Its vertices are rounded to 1e-9 of the
 * mesh's size. Quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, The Quickhull algorithm for convex hulls, 1996)
 * in integers, so that rounding decides no sign. The caller frees `*out`. KM_MODEL: all vertices are coplanar;
 * KM_MEMORY. Cost: about n log n. */
km_status km_mesh_hull(const km_mesh *mesh, km_mesh **out, km_error *error);

#endif
