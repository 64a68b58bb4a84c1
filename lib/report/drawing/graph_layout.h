/* Places of a large graph: a tidy tree, in time linear in its bodies and joints. graphviz' own layout of thousands of joints
 * takes from seconds to minutes. */
#ifndef KM_REPORT_DRAWING_GRAPH_LAYOUT_H
#define KM_REPORT_DRAWING_GRAPH_LAYOUT_H

#include "base/text.h"
#include "topology/mechanism.h"

/* In points, as graphviz counts, y upwards. A node stands over the middle of what hangs on it, and nothing else stands there. */
typedef struct km_graph_places {
  km_arena arena;
  double pitch;        /* of the columns that a node without children takes one of */
  double *body, *loop; /* x of every body, and of every loop's virtual body */
  int *level;          /* [loop] of the virtual body; bodies have those of the topology */
} km_graph_places;

/* False when out of memory. Free in any case. */
bool km_graph_places_find(const km_mechanism *mechanism, km_graph_places *out);
void km_graph_places_free(km_graph_places *places);

/* Attributes of a node at x. */
void km_graph_place_node(double x, int level, km_text *out);
/* Of an arc to a node of that level from one on which it hangs, with its label of `width` letters beside the lower end; `back`: the
 * arrow points to the upper one. */
void km_graph_place_arc(double from, double to, int level, int width, bool back, km_text *out);
/* Of the line from a virtual body to its body. */
void km_graph_place_line(double from, int level, double to, int to_level, km_text *out);

/* How many characters a label has. */
int km_graph_width(const char *label);

#endif
