/* Places of a large graph: a tidy tree, in time linear in its bodies and joints. graphviz' own layout of thousands
 * of joints takes from seconds to minutes. */
#ifndef KM_REPORT_DRAWING_GRAPH_LAYOUT_H
#define KM_REPORT_DRAWING_GRAPH_LAYOUT_H

#include "base/text.h"
#include "topology/mechanism.h"

/* Positions in points, y upwards, as in graphviz. A node is above the middle of its subtree. */
typedef struct km_graph_places {
  km_arena arena;
  double pitch;        /* width of the column of a leaf */
  double *body, *loop; /* x of every body, and of every loop's virtual body */
  int *level;          /* [loop] of the virtual body; bodies have those of the topology */
} km_graph_places;

/* False when out of memory. Free in any case. */
bool km_graph_places_find(const km_mechanism *mechanism, km_graph_places *out);
void km_graph_places_free(km_graph_places *places);

/* Attributes of a node at x. */
void km_graph_place_node(double x, int level, km_text *out);
/* Position of an arc from a parent to a node of a level, with its label of `width` letters at the lower end; `back`:
 * the arrow points to the parent. */
void km_graph_place_arc(double from, double to, int level, int width, bool back, km_text *out);
/* Position of the line from a virtual body to its body. */
void km_graph_place_line(double from, int level, double to, int to_level, km_text *out);

/* Number of characters of a label. */
int km_graph_width(const char *label);

#endif
