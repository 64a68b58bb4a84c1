/* Texts of findings about a configuration. */
#include "diagnosis/finding_texts.h"

#include "topology/mechanism.h"

#include <math.h>

/* Appends a vector with four digits; entries at rounding level are 0. */
static void add_vector(const double v[3], double size, km_text *out) {
  for (int k = 0; k < 3; ++k) {
    double value = fabs(v[k]) < 1e-9 * size ? 0.0 : v[k];
    km_text_format(out, "%s%.4g", k ? ", " : "(", value);
  }
  km_text_add(out, ")");
}

void km_redundancy_statement(const km_mechanism *m, const km_redundancy *r, km_text *out) {
  const km_topology *t = &m->topology;
  const char *length = m->model->units.length->suffix;
  double size = m->substructures[r->substructure].size;
  km_text_format(out, "loop %d (joints", r->loop + 1);
  for (int i = t->member_start[r->loop]; i < t->member_start[r->loop + 1]; ++i)
    km_text_format(out, " %s", m->model->joints[t->member[i].joint].label);
  km_text_add(out, ")");
  if (r->loops > 1)
    km_text_format(out, ", together with %d other loop%s,", r->loops - 1, r->loops > 2 ? "s" : "");
  bool screw = !r->rotation && fabs(r->pitch) > 1e-6 * size;
  km_text_add(out, r->rotation ? " constrains the rotation about "
                   : screw     ? " constrains the screw along "
                               : " constrains the translation along ");
  add_vector(r->direction, 1.0, out);
  if (!r->rotation) {
    km_text_add(out, " through ");
    add_vector(r->point, size, out);
    km_text_format(out, " %s", length);
  }
  if (screw)
    km_text_format(out, " of pitch %.4g %s/rad", r->pitch, length);
  km_text_add(out, " more often than needed");
  if (!r->persistent)
    km_text_add(out, ", at this pose only");
}

void km_passive_freedom_statement(const km_mechanism *m, const km_passive_freedom *passive, km_text *out) {
  km_text_add(out, passive->body_count > 1 ? "bodies" : "body");
  for (int i = 0; i < passive->body_count; ++i)
    km_text_format(out, " %s", m->model->bodies[passive->bodies[i]].name);
  km_text_format(out, " can move in place while everything else stands (%d idle freedom%s)", passive->freedoms,
                 passive->freedoms == 1 ? "" : "s");
}

int km_redundancies_out_of_plane(const km_redundancies *redundancies, int substructure) {
  int count = 0;
  for (int i = 0; i < redundancies->count; ++i)
    count += redundancies->items[i].out_of_plane &&
             (substructure < 0 || redundancies->items[i].substructure == substructure);
  return count;
}
