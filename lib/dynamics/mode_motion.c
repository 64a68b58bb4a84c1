/* Mode shape: motion along an eigenvector of the linearised equations, with closed loops (docs/theory.md 11.12).
 *
 *   q = q₀ + a (Re v cos φ − Im v sin φ)  of an oscillation;   q₀ + a v e^(±t/T)  of a real eigenvalue */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "dynamics/linearisation.h"
#include "model/coordinate_column.h"

#include <string.h>

static const double amplitude_first = 0.25; /* first amplitude, radians or characteristic lengths */
static const double amplitude_least = 1e-3;
static const double max_deviation =
    0.5; /* largest deviation of the closed loops from the linear motion, relative to the
                                      * amplitude */
static const double time_constants = 4.0; /* duration of a decay or growth, in time constants: to 2 % */

typedef struct mode_motion {
  km_dynamics *dynamics;
  km_state *state;
  const km_linear *linear;
  km_stored_configuration stored;
  int k, rows;
  km_linear_kind kind;
  double amplitude;
} mode_motion;

km_linear_kind km_linear_kind_of(const km_linear *l, int k) {
  if (!l || k < 0 || k >= 2 * l->freedom)
    return KM_LINEAR_ZERO;
  if (hypot(l->real[k], l->imaginary[k]) <= l->error_bound[k])
    return KM_LINEAR_ZERO;
  if (l->imaginary[k] != 0.0)
    return KM_LINEAR_OSCILLATES;
  return l->real[k] < 0.0 ? KM_LINEAR_DECAYS : KM_LINEAR_GROWS;
}

/* Factors of the real and imaginary part in a row: cos φ, −sin φ of an oscillation; exponential of a real
 * eigenvalue. */
static void phase_factors(const mode_motion *s, int row, double out[2]) {
  double part = (double)row / (s->rows - 1);
  out[1] = 0.0;
  if (s->kind == KM_LINEAR_DECAYS) {
    out[0] = exp(-time_constants * part);
  } else if (s->kind == KM_LINEAR_GROWS) {
    out[0] = exp(time_constants * (part - 1.0));
  } else {
    out[0] = cos(2.0 * M_PI * part);
    out[1] = -sin(2.0 * M_PI * part);
  }
}

/* Sets the state to a row of the mode shape, with the loops closed. False: they can't be closed, or the result is
 * far from the linear motion. */
static bool set_row(const mode_motion *s, int row) {
  const km_mechanism *m = s->dynamics->mechanism;
  int n = m->coordinate_count;
  const double *mode = s->linear->modes + (size_t)s->k * 2 * (size_t)n;
  double factor[2];
  phase_factors(s, row, factor);
  km_stored_configuration_restore(&s->stored, m, s->state);
  for (int c = 0; c < n; ++c)
    km_coordinate_shift(m, s->state, c, s->amplitude * (factor[0] * mode[c] + factor[1] * mode[n + c]));
  if (!km_constraints_close(s->dynamics, s->state, false))
    return false;
  for (int c = 0; c < n; ++c) {
    double linear_tolerance = s->stored.q[c] + s->amplitude * (factor[0] * mode[c] + factor[1] * mode[n + c]);
    if (m->ball_of[c] < 0 && !(fabs(s->state->q[c] - linear_tolerance) * m->scale[c] <= max_deviation * s->amplitude))
      return false;
  }
  return true;
}

/* Halves the amplitude until the loops close in every row. */
static bool find_amplitude(mode_motion *s) {
  for (s->amplitude = amplitude_first; s->amplitude >= amplitude_least; s->amplitude *= 0.5) {
    int row = 0;
    while (row < s->rows && set_row(s, row))
      ++row;
    if (row == s->rows)
      return true;
  }
  return false;
}

/* Columns of the table: phase or time, then all coordinates. */
static bool add_columns(const mode_motion *s, km_table *table) {
  const km_model *model = s->dynamics->mechanism->model;
  bool is_oscillation = s->kind == KM_LINEAR_OSCILLATES || s->kind == KM_LINEAR_ZERO;
  bool is_ok = km_table_add_column(table, is_oscillation ? "phase" : "t",
                                   is_oscillation ? "deg" : model->units.time->suffix) >= 0;
  for (int c = 0; c < s->linear->coordinate_count && is_ok; ++c)
    is_ok = km_model_add_coordinate_column(model, c, table);
  return is_ok;
}

/* Rows of the table along the mode. */
static bool add_rows(const mode_motion *s, km_table *table) {
  bool is_oscillation = s->kind == KM_LINEAR_OSCILLATES || s->kind == KM_LINEAR_ZERO;
  double range = is_oscillation ? 360.0 : time_constants / fabs(s->linear->real[s->k]);
  for (int r = 0; r < s->rows; ++r) {
    double *row = km_table_add_row(table);
    if (!row || !set_row(s, r))
      return false;
    row[0] = range * r / (s->rows - 1);
    for (int c = 0; c < s->linear->coordinate_count; ++c)
      row[1 + c] = km_state_coordinate(s->state, c);
  }
  return true;
}

static km_status check_mode(const km_dynamics *d, const km_linear *l, int k, int rows, km_error *error) {
  if (l->coordinate_count != d->mechanism->coordinate_count)
    return km_fail(error, KM_USAGE, "linearised equations of %d coordinates; expected those of the mechanism's %d",
                   l->coordinate_count, d->mechanism->coordinate_count);
  if (k < 0 || k >= 2 * l->freedom)
    return km_fail(error, KM_USAGE, "eigenvalue %d; expected one of %d, from 0 on", k, 2 * l->freedom);
  return rows < 2 ? km_fail(error, KM_USAGE, "%d rows; expected at least 2", rows) : KM_OK;
}

/* Finds the amplitude and writes the table. */
static km_status write_motion(mode_motion *s, km_table **out, km_error *error) {
  if (!find_amplitude(s))
    return km_fail(error, KM_DIVERGED, "the loops can't be closed along the mode; the pose can be a dead point");
  km_table *table = km_table_create();
  if (table && add_columns(s, table) && add_rows(s, table)) {
    *out = table;
    return KM_OK;
  }
  km_table_free(table);
  return km_fail(error, KM_MEMORY, "out of memory for a mode's motion");
}

km_status km_linear_motion(km_dynamics *d, km_state *state, const km_linear *l, int k, int rows, km_table **out,
                           km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(d && l, "equations of motion", error);
  if (!status)
    status = check_mode(d, l, k, rows, error);
  if (!status)
    status = km_dynamics_accelerate(d, state, error);
  if (status)
    return status;
  mode_motion s = {.dynamics = d, .state = state, .linear = l, .k = k, .rows = rows, .kind = km_linear_kind_of(l, k)};
  if (km_stored_configuration_create(d, state, &s.stored)) {
    status = write_motion(&s, out, error);
    km_stored_configuration_restore(&s.stored, d->mechanism, state);
    km_dynamics_evaluate(d, state, true);
  } else {
    status = km_fail(error, KM_MEMORY, "out of memory for a mode's motion");
  }
  km_stored_configuration_free(&s.stored);
  return status;
}
