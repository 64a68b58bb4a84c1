/* The graph behind a mechanism in the DOT language, for graphviz. */
#ifndef KM_REPORT_DRAWING_GRAPH_H
#define KM_REPORT_DRAWING_GRAPH_H

#include "base/text.h"
#include "topology/mechanism.h"

/* Bodies by level of the spanning tree, its joints solid, chords dashed. A chord ends at its virtual body, the
 * copy of the body that its loop was cut from. Arrows run from the user's parent to the user's child, colours
 * tell the substructures. `title` is the caption's beginning. */
void km_graph_write(const km_mechanism *mechanism, const char *title, km_text *out);

#endif
