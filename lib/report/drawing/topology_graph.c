/* A mechanism's topology as a graph in the DOT language. */
#include "kmech/report.h"
#include "report/canvas/palette.h"
#include "report/drawing/graph_layout.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

static const char held_colour[] = "#808080";

/* Joints beyond which graphviz is given the places: its own layout takes times that grow faster than their number. */
enum { MANY_JOINTS = 300 };

/* Text inside a quoted string that graphviz shows as a label: it undoes backslashes and XML's entities there.
 * Control characters, which XML can't hold, become their pictures. */
static void add_label(const char *text, km_text *out) {
  for (const char *c = text; *c; ++c) {
    unsigned char byte = (unsigned char)*c;
    if (byte == '"' || byte == '\\')
      km_text_format(out, "\\%c", byte);
    else if (byte == '&')
      km_text_add(out, "&amp;");
    else if (byte == '\n')
      km_text_add(out, "\\n");
    else if (byte < 0x20)
      km_text_format(out, "\xE2\x90%c", 0x80 + byte);
    else if (strncmp(c, "\xEF\xBF\xBE", 3) == 0 || strncmp(c, "\xEF\xBF\xBF", 3) == 0)
      km_text_bytes(out, "\xEF\xBF\xBD", 3), c += 2; /* no characters of XML either */
    else
      km_text_bytes(out, c, 1);
  }
}

static void add_colour(const km_mechanism *m, int joint, km_text *out) {
  km_colour c = km_palette_colour(m->topology.substructure_of_joint[joint]);
  km_text_format(out, "#%02x%02x%02x", (unsigned)lround(255.0 * c.red), (unsigned)lround(255.0 * c.green),
                 (unsigned)lround(255.0 * c.blue));
}

/* Rigid, or all of its coordinates are held. */
static bool is_stiff(const km_mechanism *m, int joint) {
  int first = m->model->joints[joint].first_coordinate;
  for (int k = 0; k < km_model_freedom(m->model, joint); ++k)
    if (!m->held[first + k])
      return false;
  return true;
}

static void add_couplings(const km_model *model, int joint, km_text *out) {
  for (int i = 0; i < model->coupling_count; ++i) {
    const km_model_coupling *coupling = &model->couplings[i];
    bool named = false;
    for (int k = 0; k < coupling->count && !named; ++k) {
      named = model->coordinates[coupling->coordinates[k]].joint == joint;
      if (named) {
        km_text_add(out, " \\n = ");
        add_label(coupling->name, out);
      }
    }
  }
}

/* Label, type, and the number of the substructure if colours don't suffice. The blanks separate the text from the
 * line. */
static void add_joint(const km_mechanism *m, int joint, km_text *out) {
  const km_model_joint *def = &m->model->joints[joint];
  const char *word = km_joint_kind_of(def->type)->word;
  int substructure = m->topology.substructure_of_joint[joint];
  bool stiff = is_stiff(m, joint);
  km_text_add(out, "label=\" ");
  add_label(def->label, out);
  km_text_format(out, " \\n %s%s", word, stiff && def->type != KM_RIGID ? " held" : "");
  if (substructure >= 0 && m->topology.substructure_count > 1)
    km_text_format(out, " #%d", substructure + 1);
  add_couplings(m->model, joint, out);
  km_text_add(out, " \" color=\"");
  if (stiff)
    km_text_add(out, held_colour);
  else
    add_colour(m, joint, out);
  km_text_add(out, stiff ? "\" penwidth=3" : "\"");
}

static void add_bodies(const km_mechanism *m, const km_graph_places *places, km_text *out) {
  const km_topology *t = &m->topology;
  for (int i = 0; i < t->body_count; ++i) {
    int body = t->order[i];
    bool opens = i == 0 || t->level[body] != t->level[t->order[i - 1]];
    bool closes = i + 1 == t->body_count || t->level[t->order[i + 1]] != t->level[body];
    km_text_add(out, opens ? "  {rank=same;\n" : "");
    km_text_format(out, "    b%d [label=\"", body);
    add_label(m->model->bodies[body].name, out);
    km_text_add(out, body == 0 ? "\" shape=box style=\"filled,diagonals\" fillcolor=\"#d0d0d0\"" : "\"");
    if (places)
      km_graph_place_node(places->body[body], t->level[body], out);
    km_text_add(out, "];\n");
    km_text_add(out, closes ? "  }\n" : "");
  }
}

/* Written away from the inertial frame, so that the ranks follow the tree; dir=back turns an arrow round. */
static void add_arcs(const km_mechanism *m, const km_graph_places *places, km_text *out) {
  const km_topology *t = &m->topology;
  for (int i = 1; i < t->body_count; ++i) {
    int body = t->order[i], parent = t->parent[body], joint = t->arc[body];
    km_text_format(out, "  b%d -> b%d [", parent, body);
    add_joint(m, joint, out);
    if (places)
      km_graph_place_arc(places->body[parent], places->body[body], t->level[body],
                         km_graph_width(m->model->joints[joint].label), t->is_reversed[joint], out);
    km_text_add(out, t->is_reversed[joint] ? " dir=back];\n" : "];\n");
  }
}

static void add_loop(const km_mechanism *m, int loop, const km_graph_places *places, km_text *out) {
  int joint = m->topology.chord[loop];
  const km_model_joint *def = &m->model->joints[joint];
  int tail = m->model->frames[def->frame[0]].body, head = m->model->frames[def->frame[1]].body;
  km_text_format(out, "  v%d [label=\"", loop);
  add_label(m->model->bodies[head].name, out);
  km_text_format(out, "\xE2\x80\xB2\\nloop %d\" shape=box style=\"rounded,dotted\" fontsize=9 height=0.3", loop + 1);
  if (places)
    km_graph_place_node(places->loop[loop], places->level[loop], out);
  km_text_add(out, "];\n");
  km_text_format(out, "  b%d -> v%d [", tail, loop);
  add_joint(m, joint, out);
  if (places)
    km_graph_place_arc(places->body[tail], places->loop[loop], places->level[loop], km_graph_width(def->label), false,
                       out);
  km_text_add(out, is_stiff(m, joint) ? " style=\"dashed,bold\"];\n" : " style=dashed];\n");
  km_text_format(out, "  v%d -> b%d [style=dotted dir=none constraint=false color=\"", loop, head);
  add_colour(m, joint, out);
  km_text_add(out, "\"");
  if (places)
    km_graph_place_line(places->loop[loop], places->level[loop], places->body[head], m->topology.level[head], out);
  km_text_add(out, "];\n");
}

static void add_count(int count, const char *one, const char *many, km_text *out) {
  km_text_format(out, "%d %s", count, count == 1 ? one : many);
}

static void add_title(const km_mechanism *m, const char *title, km_text *out) {
  const km_topology *t = &m->topology;
  km_text_add(out, "  graph [label=\"");
  add_label(title, out);
  km_text_add(out, ": ");
  add_count(t->body_count - 1, "body, ", "bodies, ", out);
  add_count(t->joint_count, "joint, ", "joints, ", out);
  add_count(t->loop_count, "loop, ", "loops, ", out);
  add_count(t->substructure_count, "substructure\"];\n", "substructures\"];\n", out);
}

/* All of it; `places` NULL: graphviz finds them. */
static void add_graph(const km_mechanism *m, const km_graph_places *places, const char *title, km_text *out) {
  km_text_add(out, "digraph mechanism {\n"
                   "  graph [fontname=\"DejaVu Sans\" fontsize=11 nodesep=0.35 ranksep=0.6 labelloc=t];\n"
                   "  node [fontname=\"DejaVu Sans\" fontsize=11 shape=ellipse margin=\"0.08,0.04\"];\n"
                   "  edge [fontname=\"DejaVu Sans\" fontsize=10 penwidth=1.5];\n");
  if (places)
    km_text_add(out, "  graph [layout=nop2];\n");
  add_title(m, title, out);
  add_bodies(m, places, out);
  add_arcs(m, places, out);
  for (int l = 0; l < m->topology.loop_count; ++l)
    add_loop(m, l, places, out);
  km_text_add(out, "}\n");
}

void km_graph_write(const km_mechanism *mechanism, const char *title, km_text *out) {
  if (!mechanism || !title || !out)
    return;
  if (mechanism->topology.joint_count <= MANY_JOINTS) {
    add_graph(mechanism, NULL, title, out);
    return;
  }
  km_graph_places places;
  if (km_graph_places_find(mechanism, &places))
    add_graph(mechanism, &places, title, out);
  else
    out->failed = true;
  km_graph_places_free(&places);
}
