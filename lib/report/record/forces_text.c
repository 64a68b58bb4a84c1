/* Text about gravity, loads and forces, and about friction that reactions omit. */
#include "kmech/report.h"

#include "report/record/record.h"
#include "topology/mechanism.h"

void km_gravity_words(const km_model *m, const double gravity[3], km_text *out) {
  if (!m || !out)
    return;
  const km_units *u = &m->units;
  km_vec3 g = gravity ? km_vec3_from_array(gravity) : m->gravity;
  if (km_vec3_norm(g) == 0.0)
    km_text_add(out, "no gravity");
  else
    km_text_format(out, "gravity (%g, %g, %g) %s/%s²", g.x, g.y, g.z, u->length->suffix, u->time->suffix);
}

void km_meshing_words(const km_model *m, km_text *out) {
  int count = 0, first = -1;
  if (!m || !out)
    return;
  for (int i = 0; i < m->coupling_count; ++i)
    if (m->couplings[i].count > 1) {
      first = first < 0 ? i : first;
      count++;
    }
  if (count == 0)
    return;
  km_text_format(out, "the reactions leave out meshing forces: coupling %s", m->couplings[first].name);
  if (count > 1)
    km_text_format(out, " (and %d more)", count - 1);
  km_text_add(
      out, " acts along the coordinates of its joints alone, so that no bearing carries what teeth, racks or belts put "
           "on it, and the value about or along a coupled axis is the coupling's");
}

void km_reactions_note_record(const km_model *m, km_value *record, km_arena *arena) {
  km_text words = {0};
  km_meshing_words(m, &words);
  if (words.size || words.failed)
    km_value_words(arena, record, "reactions_note", &words);
}
