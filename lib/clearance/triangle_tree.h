/* Tree of boxes around the triangles of a mesh, for distances of points. */
#ifndef KM_CLEARANCE_TRIANGLE_TREE_H
#define KM_CLEARANCE_TRIANGLE_TREE_H

#include "base/memory.h"
#include "model/geometry/mesh.h"

typedef struct km_triangle_tree km_triangle_tree;

/* Builds the tree in the arena. The mesh must outlive it. NULL without memory or triangles. Cost: n log² n. */
const km_triangle_tree *km_triangle_tree_create(const km_mesh *mesh, km_arena *arena);
/* Triangle nearest to a point, the first of equal ones in the order of the tree, and its distance. Cost: about
 * log n. */
int km_triangle_tree_nearest(const km_triangle_tree *tree, km_vec3 point, double *distance);
/* Distance of a point from one triangle. */
double km_triangle_distance(const km_mesh *mesh, int triangle, km_vec3 point);

#endif
