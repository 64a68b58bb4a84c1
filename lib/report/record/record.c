/* The beginning of every record, and the parts that several have. */
#include "report/record/record.h"

#include "kmech/version.h"
#include "topology/mechanism.h"

void km_record_model(const km_model *model, km_value *record, km_arena *arena) {
  km_value_string(arena, record, "model_sha256", model->sha256);
  km_value *units = km_value_add(arena, record, "units", KM_OBJECT);
  const km_unit *const given[KM_QUANTITIES] = {model->units.angle, model->units.length, model->units.mass,
                                               model->units.time, model->units.force};
  for (int q = 0; q < KM_QUANTITIES; ++q)
    km_value_string(arena, units, km_quantity_name((km_quantity)q), given[q]->word);
}

km_value *km_record_head(const km_mechanism *m, const char *tool, const char *name, km_arena *arena) {
  if (!m || !tool || !name || !arena)
    return NULL;
  km_value *record = km_value_add(arena, NULL, NULL, KM_OBJECT);
  km_value_string(arena, record, "kmech", KM_VERSION);
  km_value_string(arena, record, "tool", tool);
  km_value_string(arena, record, "model", name);
  km_record_model(m->model, record, arena);
  km_value_number(arena, record, "characteristic_length", m->length);
  km_value_string(arena, record, "characteristic_length_source", km_length_source_name(m->length_source));
  return record;
}

void km_table_record(const km_table *table, km_value *record, km_arena *arena) {
  if (!table || !record || !arena)
    return;
  km_value *columns = km_value_add(arena, record, "columns", KM_LIST);
  for (size_t c = 0; c < km_table_columns(table) && !arena->failed; ++c) {
    km_value *column = km_value_add(arena, columns, NULL, KM_OBJECT);
    km_value_string(arena, column, "name", km_table_name(table, c));
    const char *unit = km_table_unit(table, c);
    if (unit[0])
      km_value_string(arena, column, "unit", unit);
    else
      km_value_add(arena, column, "unit", KM_NULL);
  }
  km_value *rows = km_value_add(arena, record, "rows", KM_LIST);
  for (size_t r = 0; r < km_table_rows(table) && !arena->failed; ++r)
    km_value_numbers(arena, rows, NULL, km_table_row(table, r), km_table_columns(table));
}

void km_sweep_record(const km_sweep *sweep, const char *stopped_by, km_value *record, km_arena *arena) {
  km_value *branches = km_value_add(arena, record, "branch_points", KM_LIST);
  for (size_t i = 0; i < sweep->branch_count && !arena->failed; ++i) {
    km_value *branch = km_value_add(arena, branches, NULL, KM_OBJECT);
    km_value_number(arena, branch, "s", sweep->branches[i].s);
    km_value_number(arena, branch, "mobility", sweep->branches[i].mobility);
    if (sweep->branches[i].branches > 0) {
      km_value_number(arena, branch, "branches", sweep->branches[i].branches);
    } else {
      km_value_add(arena, branch, "branches", KM_NULL);
      km_value_string(arena, branch, "reason", "the motions that meet weren't found");
    }
  }
  if (sweep->cycle > 0.0)
    km_value_number(arena, record, "cycle", sweep->cycle);
  else
    km_value_add(arena, record, "cycle", KM_NULL);
  km_value_number(arena, record, "idle_mobility", sweep->passive);
  km_value_boolean(arena, record, "complete", !sweep->start.stop && !sweep->end.stop);
  if (stopped_by[0])
    km_value_string(arena, record, "stopped_by", stopped_by);
  else
    km_value_add(arena, record, "stopped_by", KM_NULL);
}

void km_held_record(const km_mechanism *m, km_value *record, km_arena *arena) {
  km_value *held = km_value_add(arena, record, "held_joints", KM_LIST);
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->held[c])
      km_value_string(arena, held, NULL, m->model->coordinates[c].label);
}

void km_configuration_record(const km_mechanism *m, const km_state *s, km_value *record, km_arena *arena) {
  km_value *configuration = km_value_add(arena, record, "configuration", KM_OBJECT);
  for (int c = 0; c < m->coordinate_count; ++c)
    km_value_number(arena, configuration, m->model->coordinates[c].label, km_state_coordinate(s, c));
}
