#include "report/advantage_record.h"

#include "topology/mechanism.h"

km_value *km_advantage_record(const km_mechanism *m, const km_state *s, const km_handle *input, const km_handle *output,
                              const km_advantage *a, const char *name, km_arena *arena) {
  km_value *record = km_record_head(m->model, "kma", name, arena);
  const char *unit = km_advantage_unit(m->model, input, output);
  km_value_string(arena, record, "input", input->name);
  km_value_string(arena, record, "output", output->name);
  km_value_number(arena, record, "mechanical_advantage", a->value);
  km_value_number(arena, record, "velocity_ratio", a->velocity_ratio);
  km_value_string(arena, record, "state", km_advantage_state_name(a->state));
  km_value_string(arena, record, "method", km_advantage_method_name(a->method));
  if (unit[0])
    km_value_string(arena, record, "unit", unit);
  else
    km_value_add(arena, record, "unit", KM_NULL);
  km_held_record(m, record, arena);
  km_configuration_record(m, s, record, arena);
  return arena->failed ? NULL : record;
}

void km_advantage_words(const km_mechanism *m, const km_handle *input, const km_handle *output, const km_advantage *a,
                        km_text *out) {
  const char *unit = km_advantage_unit(m->model, input, output);
  switch (a->state) {
  case KM_ADVANTAGE_FINITE:
    km_text_format(out, "mechanical advantage %.9g%s%s", a->value, unit[0] ? " " : "", unit);
    break;
  case KM_ADVANTAGE_ZERO:
    km_text_format(out, "mechanical advantage 0: %s stands while %s moves (a toggle)", input->name, output->name);
    break;
  case KM_ADVANTAGE_INFINITE:
    km_text_format(out, "mechanical advantage infinite: %s stands while %s moves (a toggle)", output->name,
                   input->name);
    break;
  default:
    km_text_format(out, "mechanical advantage undefined: neither %s nor %s moves", input->name, output->name);
  }
}

void km_advantage_print(const km_mechanism *m, const km_handle *input, const km_handle *output, const km_advantage *a,
                        const char *name, km_text *out) {
  const char *unit = km_advantage_unit(m->model, output, input);
  km_text_format(out, "%s: %s over %s\n  ", name, input->name, output->name);
  km_advantage_words(m, input, output, a, out);
  km_text_add(out, "\n");
  if (a->state == KM_ADVANTAGE_FINITE)
    km_text_format(out, "  velocity ratio %.9g%s%s: %s moves so far while %s moves by 1\n", a->velocity_ratio,
                   unit[0] ? " " : "", unit, output->name, input->name);
  km_text_add(out, a->method == KM_ADVANTAGE_SINGLE_FREEDOM
                       ? "  one freedom: both move in the only way there is\n"
                       : "  several freedoms: the others move least (--hold keeps joints)\n");
  int held = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->held[c])
      km_text_format(out, "%s %s", held++ ? "," : "  held:", m->model->coordinates[c].label);
  km_text_add(out, held ? "\n" : "");
}
