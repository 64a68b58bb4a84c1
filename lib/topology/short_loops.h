/* Short cycle basis of large substructures (docs/theory.md 2.2). Private to topology/. */
#ifndef KM_TOPOLOGY_SHORT_LOOPS_H
#define KM_TOPOLOGY_SHORT_LOOPS_H

#include "topology/spanning_tree.h"

/* Substructures with up to this number of loops keep the fundamental cycles of the spanning tree. */
enum { KM_MAX_TREE_LOOPS = 50 };

/* Replaces every loop of a large substructure by the shortest cycle of its chord, tree joints and chords of shorter
 * loops, if it is shorter than the fundamental cycle. With that order the matrix of loops by chords is triangular, so
 * the loops stay a cycle basis. Requires loops, tree and substructures of the topology. Cost: one breadth-first search
 * about each chord, as wide as its loop is long. False when out of memory. */
bool km_find_short_loops(const km_graph *graph, km_arena *scratch, km_topology *topology);

#endif
