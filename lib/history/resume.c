/* Continues a run from the last row of its table (docs/theory.md 11.7).
 *
 *   state of a run = (t; q; q̇; internal states of force modules; energies and works so far)
 *
 * A table has one column for each of these numbers, so that a run in two parts equals one run to its tolerance. */
#include "history/history_table.h"

#include "base/arguments.h"
#include "base/table.h"
#include "base/text.h"
#include "forces/motion_forces.h"
#include "kmech/inspect.h"
#include "kmech/report.h"

/* Last row of a table of rows over time; `name` of the file, for messages. */
typedef struct last_row {
  const km_mechanism *m;
  const km_table *table;
  const char *name;
  const double *cells;
  km_error *error;
} last_row;

/* Reads a cell by its column. `is_needed`: a column that is missing is an error, otherwise `*out` stays. */
static km_status read_cell(const last_row *r, const char *column, const char *unit, bool is_needed, double *out) {
  int found = km_csv_find(r->table, column);
  if (found < 0 && !is_needed)
    return KM_OK;
  if (found < 0 || !isfinite(r->cells[found]))
    return km_fail(r->error, KM_USAGE, "%s: its last row has no %s; expected the table of a run of this model", r->name,
                   column);
  const char *own = km_table_unit(r->table, (size_t)found);
  if (*own && strcmp(own, unit) != 0)
    return km_fail(r->error, KM_USAGE, "%s: column %s is in %s; expected %s, the model's unit", r->name, column, own,
                   unit);
  *out = r->cells[found];
  return KM_OK;
}

/* Reads the cell of column PREFIX + label. */
static km_status read_coordinate(const last_row *r, const char *prefix, int c, const char *per, double *out) {
  const km_model *model = r->m->model;
  km_text column = {0}, unit = {0};
  km_text_format(&column, "%s%s", prefix, model->coordinates[c].label);
  km_text_format(&unit, "%s%s%s", km_model_coordinate_unit(model, c), *per ? "/" : "", per);
  km_status status = column.failed || unit.failed ? km_fail(r->error, KM_MEMORY, "out of memory for a column")
                                                  : read_cell(r, column.data, unit.data, true, out);
  km_text_free(&column);
  km_text_free(&unit);
  return status;
}

static km_status read_configuration(const last_row *r, km_state *s) {
  const km_mechanism *m = r->m;
  double *q = KM_NEW(double, (size_t)m->coordinate_count + 1);
  km_status status = q ? KM_OK : km_fail(r->error, KM_MEMORY, "out of memory for a configuration");
  for (int c = 0; c < m->coordinate_count && !status; ++c) {
    double rate;
    status = read_coordinate(r, "q.", c, "", &q[c]);
    if (!status)
      status = read_coordinate(r, "v.", c, m->model->units.time->suffix, &rate);
    if (!status && !m->held[c])
      status = km_state_set_rate(m, s, c, rate, r->error);
  }
  if (!status)
    status = km_state_set_coordinates(m, s, q, r->error);
  km_free(q);
  return status;
}

/* Reads energies and works; those that the table doesn't have begin at 0. */
static km_status read_works(const last_row *r, km_run_memory *out) {
  const km_model *model = r->m->model;
  km_text unit = {0}, column = {0};
  km_torque_unit(model, &unit);
  const char *energy = unit.failed ? "" : unit.data;
  km_status status = read_cell(r, "energy_potential", energy, false, &out->potential);
  if (!status)
    status = read_cell(r, "energy_dissipated", energy, false, &out->dissipated);
  if (!status)
    status = read_cell(r, "motor_work", energy, false, &out->motor_work);
  for (int i = 0; i < model->module_count && !status; ++i) {
    column.size = 0;
    km_text_format(&column, "module.%s.work", model->modules[i].name);
    status = column.failed ? km_fail(r->error, KM_MEMORY, "out of memory for a column")
                           : read_cell(r, column.data, energy, false, &out->module_works[i]);
  }
  km_text_free(&column);
  km_text_free(&unit);
  return status;
}

static km_status read_internal_states(const last_row *r, km_run_memory *out) {
  const km_model *model = r->m->model;
  km_status status = KM_OK;
  km_text column = {0}, unit = {0};
  for (int i = 0; i < km_model_internal_count(model) && !status; ++i) {
    column.size = unit.size = 0;
    km_internal_column(model, i, &column, &unit);
    status = column.failed || unit.failed
                 ? km_fail(r->error, KM_MEMORY, "out of memory for a column")
                 : read_cell(r, column.data, unit.data ? unit.data : "", true, &out->internal[i]);
  }
  km_text_free(&column);
  km_text_free(&unit);
  return status;
}

static km_run_memory *create_memory(const km_model *model) {
  km_run_memory *out = KM_NEW(km_run_memory, 1);
  if (!out)
    return NULL;
  out->internal = KM_NEW(double, (size_t)km_model_internal_count(model) + 1);
  out->module_works = KM_NEW(double, (size_t)model->module_count + 1);
  if (out->internal && out->module_works)
    return out;
  km_run_memory_free(out);
  return NULL;
}

km_status km_history_resume(const km_mechanism *m, const km_table *table, const char *name, km_state *state,
                            double *time, km_run_memory **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(table != NULL && name != NULL && time != NULL, "table, its name or time", error);
  if (!status)
    status = km_check_state(m, state, error);
  if (status)
    return status;
  size_t rows = km_table_rows(table);
  if (rows == 0 || km_csv_find(table, "t") < 0)
    return km_fail(error, KM_USAGE, "%s: it has no row with a time; expected the table of a run", name);
  const last_row r = {m, table, name, km_table_row(table, rows - 1), error};
  *out = create_memory(m->model);
  if (!*out)
    return km_fail(error, KM_MEMORY, "out of memory for the continuation");
  status = read_cell(&r, "t", m->model->units.time->suffix, true, time);
  if (!status)
    status = read_configuration(&r, state);
  if (!status)
    status = read_works(&r, *out);
  if (!status)
    status = read_internal_states(&r, *out);
  if (status) {
    km_run_memory_free(*out);
    *out = NULL;
  }
  return status;
}

void km_run_memory_free(km_run_memory *memory) {
  if (!memory)
    return;
  km_free(memory->internal);
  km_free(memory->module_works);
  km_free(memory);
}
