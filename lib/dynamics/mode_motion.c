/* A mode of the linearised equations as a motion about its pose, with closed loops. */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "dynamics/linearisation.h"

#include <string.h>

static const double amplitude_first = 0.25; /* radians or characteristic lengths: seen at a glance */
static const double amplitude_least = 1e-3;
static const double bend = 0.5;      /* of the amplitude: how far loops may lead away from the mode's straight motion */
static const double constants = 4.0; /* time constants that are shown of what dies away or grows: down to 2 % */

typedef struct shaking {
  km_dynamics *dynamics;
  km_state *state;
  const km_linear *linear;
  km_rest_pose poise;
  int k, rows;
  km_linear_kind kind;
  double amplitude;
} shaking;

km_linear_kind km_linear_kind_of(const km_linear *l, int k) {
  if (!l || k < 0 || k >= 2 * l->freedom)
    return KM_LINEAR_STILL;
  if (hypot(l->real[k], l->imaginary[k]) <= l->doubt[k])
    return KM_LINEAR_STILL;
  if (l->imaginary[k] != 0.0)
    return KM_LINEAR_SWINGS;
  return l->real[k] < 0.0 ? KM_LINEAR_DIES : KM_LINEAR_GROWS;
}

/* Factors of the mode's real and imaginary part in a row. */
static void factors(const shaking *s, int row, double out[2]) {
  double part = (double)row / (s->rows - 1);
  out[1] = 0.0;
  if (s->kind == KM_LINEAR_DIES) {
    out[0] = exp(-constants * part);
  } else if (s->kind == KM_LINEAR_GROWS) {
    out[0] = exp(constants * (part - 1.0));
  } else {
    out[0] = cos(2.0 * M_PI * part);
    out[1] = -sin(2.0 * M_PI * part);
  }
}

/* Puts the state where the mode has it in a row, with the loops closed on the independent coordinates. False where that
 * can't be, or where it leads far from the mode. */
static bool place(const shaking *s, int row) {
  const km_mechanism *m = s->dynamics->mechanism;
  int n = m->coordinate_count;
  const double *mode = s->linear->modes + (size_t)s->k * 2 * (size_t)n;
  double factor[2];
  factors(s, row, factor);
  km_poise_restore(&s->poise, m, s->state);
  for (int c = 0; c < n; ++c)
    km_nudge(m, s->state, c, s->amplitude * (factor[0] * mode[c] + factor[1] * mode[n + c]));
  if (!km_constraints_update(s->dynamics, s->state, false))
    return false;
  for (int c = 0; c < n; ++c) {
    double straight = s->poise.q[c] + s->amplitude * (factor[0] * mode[c] + factor[1] * mode[n + c]);
    if (m->ball_of[c] < 0 && !(fabs(s->state->q[c] - straight) * m->scale[c] <= bend * s->amplitude))
      return false;
  }
  return true;
}

static bool find_amplitude(shaking *s) {
  for (s->amplitude = amplitude_first; s->amplitude >= amplitude_least; s->amplitude *= 0.5) {
    int row = 0;
    while (row < s->rows && place(s, row))
      ++row;
    if (row == s->rows)
      return true;
  }
  return false;
}

static bool add_columns(const shaking *s, km_table *table) {
  const km_model *model = s->dynamics->mechanism->model;
  bool turns = s->kind == KM_LINEAR_SWINGS || s->kind == KM_LINEAR_STILL;
  bool good = km_table_add_column(table, turns ? "phase" : "t", turns ? "deg" : model->units.time->suffix) >= 0;
  for (int c = 0; c < s->linear->coordinate_count && good; ++c) {
    km_text name = {0};
    km_text_format(&name, "q.%s", model->coordinates[c].label);
    good = !name.failed && km_table_add_column(table, name.data, km_model_coordinate_unit(model, c)) >= 0;
    km_text_free(&name);
  }
  return good;
}

static bool add_rows(const shaking *s, km_table *table) {
  bool turns = s->kind == KM_LINEAR_SWINGS || s->kind == KM_LINEAR_STILL;
  double whole = turns ? 360.0 : constants / fabs(s->linear->real[s->k]);
  for (int r = 0; r < s->rows; ++r) {
    double *row = km_table_add_row(table);
    if (!row || !place(s, r))
      return false;
    row[0] = whole * r / (s->rows - 1);
    for (int c = 0; c < s->linear->coordinate_count; ++c)
      row[1 + c] = km_state_coordinate(s->state, c);
  }
  return true;
}

static km_status check(const km_dynamics *d, const km_linear *l, int k, int rows, km_error *error) {
  if (l->coordinate_count != d->mechanism->coordinate_count)
    return km_fail(error, KM_USAGE, "linearised equations of %d coordinates; expected those of the mechanism's %d",
                   l->coordinate_count, d->mechanism->coordinate_count);
  if (k < 0 || k >= 2 * l->freedom)
    return km_fail(error, KM_USAGE, "eigenvalue %d; expected one of %d, from 0 on", k, 2 * l->freedom);
  return rows < 2 ? km_fail(error, KM_USAGE, "%d rows; expected at least 2", rows) : KM_OK;
}

static km_status write_motion(shaking *s, km_table **out, km_error *error) {
  if (!find_amplitude(s))
    return km_fail(error, KM_DIVERGED, "the loops can't be closed along the mode; is the pose a dead point?");
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
    status = check(d, l, k, rows, error);
  if (!status)
    status = km_dynamics_accelerate(d, state, error);
  if (status)
    return status;
  shaking s = {.dynamics = d, .state = state, .linear = l, .k = k, .rows = rows, .kind = km_linear_kind_of(l, k)};
  if (km_poise_take(d, state, &s.poise)) {
    status = write_motion(&s, out, error);
    km_poise_restore(&s.poise, d->mechanism, state);
    km_dynamics_evaluate(d, state, true);
  } else {
    status = km_fail(error, KM_MEMORY, "out of memory for a mode's motion");
  }
  km_poise_free(&s.poise);
  return status;
}
