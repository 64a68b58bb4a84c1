/* Record and table of kspace modes. */
#include "kspace/kspace.h"
#include "kspace/modes_answer.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>

static void add_mode(const kspace_modes_answer *a, int i, km_value *list, km_arena *arena) {
  const km_mode_evidence *e = &a->modes.evidence[i];
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_value *mode = km_value_add(arena, list, NULL, KM_OBJECT);
  if (a->circuits.count > 0)
    km_value_number(arena, mode, "circuit", a->circuits.circuit[i]);
  km_value *configuration = km_value_add(arena, mode, "configuration", KM_OBJECT);
  for (int c = 0; c < coordinates; ++c)
    km_value_number(arena, configuration, km_model_coordinate_label(a->pose->model, c),
                    a->modes.coordinates[i * coordinates + c]);
  km_value_number(arena, mode, "residual", e->residual);
  km_value_boolean(arena, mode, "certified", e->is_certified);
  km_value_number(arena, mode, "kantorovich", e->kantorovich);
  km_value_number(arena, mode, "error_bound", e->error_bound);
  km_value_number(arena, mode, "radius", e->radius);
  km_value_number(arena, mode, "mobility", e->mobility);
  km_value *numbers = km_value_add(arena, mode, "mobility_numbers", KM_OBJECT);
  for (int c = 0; c < coordinates; ++c)
    km_value_number(arena, numbers, km_model_coordinate_label(a->pose->model, c),
                    a->modes.mobility_numbers[i * coordinates + c]);
  if (a->has_leverage) {
    km_value_number(arena, mode, "mechanical_advantage",
                    a->advantage[i].state == KM_ADVANTAGE_INFINITE ? nan("") : a->advantage[i].value);
    km_value_string(arena, mode, "mechanical_advantage_state", km_advantage_state_name(a->advantage[i].state));
  }
  km_value_boolean(arena, mode, "singular", e->is_singular);
  km_value_boolean(arena, mode, "moves", e->moves);
  km_value_boolean(arena, mode, "within_limits", e->is_within_limits);
}

const km_value *kspace_modes_record(const kspace_modes_answer *a, km_arena *arena) {
  const km_all_modes *m = &a->modes;
  km_value *record = km_record_head(a->pose->mechanism, "kspace", a->o->model, arena);
  km_value *held = km_value_add(arena, record, "held", KM_OBJECT);
  for (int i = 0; i < a->locked_count; ++i)
    km_value_number(arena, held, km_model_coordinate_label(a->pose->model, a->locked[i]),
                    km_state_coordinate(a->pose->state, a->locked[i]));
  kspace_record_completeness(m->gap, record, arena);
  km_value_number(arena, record, "complex_solutions", m->complex_solutions);
  km_value_number(arena, record, "section_points", m->section_points);
  km_value_number(arena, record, "trace_difference", m->trace_difference);
  km_value_number(arena, record, "estimate", m->estimate);
  km_value_number(arena, record, "samples", m->samples);
  km_value_number(arena, record, "found_once", m->found_once);
  km_value_number(arena, record, "infinite", m->infinite);
  km_value_number(arena, record, "singular", m->singular);
  km_value_number(arena, record, "outside_limits", m->outside);
  if (a->circuits.count > 0)
    km_value_number(arena, record, "circuits", a->circuits.count);
  if (a->circuits.gap)
    km_value_string(arena, record, "circuits_reason", km_circuit_gap_name(a->circuits.gap));
  if (a->has_leverage) {
    km_value_string(arena, record, "input", a->input.name);
    km_value_string(arena, record, "output", a->output.name);
  }
  km_value *list = km_value_add(arena, record, "modes", KM_LIST);
  for (int i = 0; i < m->count && !arena->failed; ++i)
    add_mode(a, i, list, arena);
  return record;
}

/* ---- CSV. */

kt_exit kspace_add_table(const kspace_modes_answer *a, km_text *out) {
  const km_all_modes *m = &a->modes;
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_table *table = km_table_create();
  km_text name = {0};
  bool is_ok = table && km_table_add_column(table, "mode", "") >= 0;
  for (int c = 0; is_ok && c < 2 * coordinates; ++c) {
    bool is_number = c >= coordinates;
    name.size = 0;
    km_text_format(&name, "%s.%s", is_number ? "m" : "q", km_model_coordinate_label(a->pose->model, c % coordinates));
    is_ok = !name.failed &&
            km_table_add_column(table, name.data, is_number ? "" : km_model_coordinate_unit(a->pose->model, c)) >= 0;
  }
  static const char *const figures[] = {"dof",      "certified", "kantorovich", "error_bound",   "radius",
                                        "residual", "singular",  "moves",       "within_limits", "circuit"};
  for (size_t k = 0; is_ok && k < sizeof figures / sizeof *figures; ++k)
    is_ok = km_table_add_column(table, figures[k], "") >= 0;
  name.size = 0;
  if (is_ok && a->has_leverage) {
    km_text_format(&name, "ma.%s/%s", a->input.name, a->output.name);
    is_ok = !name.failed &&
            km_table_add_column(table, name.data, km_advantage_unit(a->pose->model, &a->input, &a->output)) >= 0;
  }
  for (int i = 0; is_ok && i < m->count; ++i) {
    const km_mode_evidence *e = &m->evidence[i];
    double *row = km_table_add_row(table);
    is_ok = row != NULL;
    if (!is_ok)
      break;
    *row++ = i + 1;
    for (int c = 0; c < coordinates; ++c)
      *row++ = m->coordinates[i * coordinates + c];
    for (int c = 0; c < coordinates; ++c)
      *row++ = m->mobility_numbers[i * coordinates + c];
    const double rest[] = {e->mobility,         e->is_certified,
                           e->kantorovich,      e->error_bound,
                           e->radius,           e->residual,
                           e->is_singular,      e->moves,
                           e->is_within_limits, a->circuits.count > 0 ? a->circuits.circuit[i] : nan("")};
    for (size_t k = 0; k < sizeof rest / sizeof *rest; ++k)
      *row++ = rest[k];
    if (a->has_leverage)
      *row = a->advantage[i].value;
  }
  size_t size = is_ok ? km_table_csv(table, NULL, 0) : 0;
  char *bytes = is_ok && size > 0 ? KM_NEW(char, size + 1) : NULL;
  is_ok = bytes && km_table_csv(table, bytes, size + 1) == size;
  if (is_ok)
    km_text_add(out, bytes);
  is_ok = is_ok && !out->failed;
  km_free(bytes);
  km_text_free(&name);
  km_table_free(table);
  return is_ok ? KT_DONE : KT_NO_MEMORY;
}
