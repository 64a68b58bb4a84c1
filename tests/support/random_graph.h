/* A linkage of any number of loops that are joined at random, as text: drawn as those of support/lattices.h. */
#ifndef KM_TESTS_RANDOM_GRAPH_H
#define KM_TESTS_RANDOM_GRAPH_H

#include "base/text.h"

/* A tree of links that stand in a square, the first one hinged to the ground, and n joints more between them: with
 * three joints on a link at most, two between no pair of them, and seven for two loops. Links that are joined are at
 * most `reach` apart in rows and in columns; so far as the square is wide they make a graph that no small cut parts.
 * Mobility n / 2 at least. */
void write_random_graph(km_text *out, int n, int reach);

#endif
