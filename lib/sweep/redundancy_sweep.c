/* Redundant constraints along a sweep: persistent ones at the row of least mobility, additional ones at rows and
 * branch points with more mobility (theory 7.3). */
#include "kmech/sweep.h"

#include "base/arguments.h"
#include "kinematics/state.h"
#include "sweep/events/sample_window.h"

#include <math.h>
#include <stdlib.h>

/* The column of mobilities of a table. */
typedef struct mobilities {
  const double *first;
  size_t rows, width;
} mobilities;

static mobilities mobilities_of(const km_table *table) {
  return (mobilities){km_table_row(table, 0) + km_table_find(table, "dof"), km_table_rows(table),
                      km_table_columns(table)};
}

static int mobility_at(const mobilities *m, size_t row) {
  return (int)m->first[row * m->width];
}

/* Returns the first row of least mobility; *above: number of rows with more. */
static size_t find_least_mobility(const mobilities *m, size_t *above) {
  size_t best = 0;
  double least = m->first[0];
  *above = 0;
  for (size_t r = 1; r < m->rows; ++r) {
    double mobility = m->first[r * m->width];
    if (mobility < least) {
      least = mobility;
      best = r;
      *above = r; /* all rows before it */
    }
    *above += mobility > least;
  }
  return best;
}

/* Creates a state at a row of the table and closes it again: cells in other units are rounded. */
static km_status create_state_at(const km_mechanism *m, const km_table *table, size_t row, km_state **state,
                                 km_error *error) {
  const double *cells = km_table_row(table, row) + 2; /* after step and s */
  double *q = KM_NEW(double, (size_t)m->coordinate_count);
  km_status status = q ? km_state_create(m, state, error) : km_fail(error, KM_MEMORY, "out of memory for a pose");
  for (int c = 0; c < m->coordinate_count && !status; ++c)
    q[c] = cells[c] * km_model_coordinate_factor(m->model, c);
  if (!status) {
    km_state_set(m, *state, q);
    status = km_assemble(m, *state, NULL, error);
  }
  km_free(q);
  return status;
}

static int compare_positions(const void *a, const void *b) {
  double x = ((const km_extra_redundancy *)a)->s, y = ((const km_extra_redundancy *)b)->s;
  return (x > y) - (x < y);
}

static bool is_same_position(double a, double b) {
  return fabs(a - b) <= km_same_position * (1.0 + fabs(a));
}

/* Lists rows and branch points with more mobility, each position once. */
static km_status list_additional(const km_sweep *sweep, const mobilities *m, int least, size_t above,
                                 km_sweep_redundancies *out, km_error *error) {
  size_t count = 0;
  if (above + sweep->branch_count == 0)
    return KM_OK;
  out->extra = KM_NEW(km_extra_redundancy, above + sweep->branch_count);
  if (!out->extra)
    return km_fail(error, KM_MEMORY, "out of memory for the redundant constraints");
  int s = km_table_find(sweep->table, "s");
  for (size_t r = 0; r < m->rows && count < above; ++r)
    if (mobility_at(m, r) > least)
      out->extra[count++] = (km_extra_redundancy){km_table_row(sweep->table, r)[s], mobility_at(m, r) - least};
  for (size_t i = 0; i < sweep->branch_count; ++i)
    if (sweep->branches[i].mobility > sweep->freedom)
      out->extra[count++] = (km_extra_redundancy){sweep->branches[i].s, sweep->branches[i].mobility - sweep->freedom};
  qsort(out->extra, count, sizeof *out->extra, compare_positions);
  for (size_t i = 0; i < count; ++i)
    if (out->extra_count == 0 || !is_same_position(out->extra[i].s, out->extra[out->extra_count - 1].s))
      out->extra[out->extra_count++] = out->extra[i];
  return KM_OK;
}

/* True if the table can be one of a sweep of the mechanism. */
static bool is_sweep_of(const km_mechanism *m, const km_table *table) {
  return km_table_columns(table) > 2 + (size_t)m->coordinate_count && km_table_find(table, "dof") >= 0;
}

km_status km_sweep_redundancies_find(const km_mechanism *m, const km_sweep *sweep, bool named,
                                     km_sweep_redundancies *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_sweep_redundancies){0};
  km_status fits = km_check_given(m != NULL, "mechanism", error);
  if (!fits)
    fits = km_check_given(sweep && is_sweep_of(m, sweep->table), "sweep of this mechanism", error);
  if (fits)
    return fits;
  if (km_table_rows(sweep->table) == 0)
    return KM_OK;
  km_state *state = NULL;
  const mobilities by_row = mobilities_of(sweep->table);
  size_t above, row = find_least_mobility(&by_row, &above);
  km_status status = list_additional(sweep, &by_row, mobility_at(&by_row, row), above, out, error);
  if (!status && named)
    status = create_state_at(m, sweep->table, row, &state, error);
  if (!status && named)
    status = km_redundancies_find(m, state, NULL, NULL, &out->persistent, error);
  km_state_free(state);
  return status;
}

void km_sweep_redundancies_free(km_sweep_redundancies *redundancies) {
  if (!redundancies)
    return;
  km_redundancies_free(&redundancies->persistent);
  km_free(redundancies->extra);
  *redundancies = (km_sweep_redundancies){0};
}
