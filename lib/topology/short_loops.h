/* Shorter loops than the tree's for large substructures. Private to topology/. */
#ifndef KM_TOPOLOGY_SHORT_LOOPS_H
#define KM_TOPOLOGY_SHORT_LOOPS_H

#include "topology/spanning_tree.h"

/* Substructures of up to so many loops keep the loops that the tree gives. */
enum { KM_MAX_TREE_LOOPS = 50 };

/* Joints at each body in file order: the items of body b are item[start[b]] … item[start[b + 1] - 1]. */
typedef struct km_incidence {
  int *start, *item;
} km_incidence;

/* Gives every loop of a large substructure the shortest cycle of its chord, tree joints and chords of loops that were
 * shorter, where that is shorter than the tree's. By that order the matrix of loops by chords stays triangular, so the
 * loops stay a cycle basis. The topology's loops, tree and substructures are known. Time: a search about each chord as
 * wide as its loop is long. False when out of memory. */
bool km_find_short_loops(const km_graph *graph, const km_incidence *at, km_arena *scratch, km_topology *topology);

#endif
