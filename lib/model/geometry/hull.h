/* Convex hulls of points. */
#ifndef KM_MODEL_GEOMETRY_HULL_H
#define KM_MODEL_GEOMETRY_HULL_H

#include "model/geometry/mesh.h"

/* The convex hull of a mesh's vertices; its triangles look outwards, and its vertices are those of the mesh to a part in
 * 10⁹ of its greatest size. Quickhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, The Quickhull algorithm for convex hulls,
 * 1996) over whole numbers, so that no sign is a matter of rounding. The caller frees `*out`. KM_MODEL: all vertices lie
 * in a plane; KM_MEMORY. Cost: about n log n. */
km_status km_mesh_hull(const km_mesh *mesh, km_mesh **out, km_error *error);

#endif
