/* Inverse dynamics: driving forces of a fully prescribed motion, row by row, without integration (docs/theory.md
 * 11.11). */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "history/inverse_peaks.h"
#include "history/motion_cycle.h"
#include "kmech/inspect.h"

#include <math.h>

/* Largest number of parts of the time between two rows; coordinates are predicted by their rates. */
enum { MAX_PARTS = 64 };
static const double max_motion = 0.1; /* largest motion in one part, radians or characteristic lengths */

enum { DEFAULT_STEPS = 360 };

km_inverse_def km_inverse_default(const km_mechanism *m, const km_constant_rate *rates, int rate_count) {
  km_inverse_def def = {.rates = rates, .rate_count = rate_count, .steps = DEFAULT_STEPS};
  if (!m)
    return def;
  const bool rated = rates && rate_count > 0 && rate_count <= m->coordinate_count;
  bool over_joint;
  const double period = km_longest_period(m->model, rates, rated ? rate_count : 0, &over_joint);
  if (!rated)
    km_model_simulated(m->model, &def.until, NULL);
  else if (km_coordinate_turns(m, rates[0].coordinate))
    def.until = 2.0 * M_PI / km_model_coordinate_factor(m->model, rates[0].coordinate) / fabs(rates[0].rate);
  if (rated || !(def.until > 0.0))
    def.until = fmax(def.until, period);
  return def;
}

/* Checks the definition of inverse dynamics. */
static km_status check_def(const km_mechanism *m, const km_inverse_def *def, km_error *error) {
  if (!(def->until > 0.0) || !isfinite(def->until))
    return km_fail(error, KM_USAGE, "duration %g; expected a positive time", def->until);
  if (def->steps < 1)
    return km_fail(error, KM_USAGE, "%d steps; expected at least one", def->steps);
  km_status status = km_check_list(def->rates, def->rate_count, "rates", error);
  for (int i = 0; i < def->rate_count && !status; ++i)
    status = km_check_index(def->rates[i].coordinate, m->coordinate_count, "coordinate", error);
  return status ? status : km_history_check_frames(m, def->frames, def->frame_count, error);
}

/* Checks that every freedom is prescribed. */
static km_status check_no_freedom(const km_history_writer *w, km_error *error) {
  const km_dynamics *d = w->dynamics;
  if (km_prescribed_count(d->prescribed) == 0)
    return km_fail(error, KM_USAGE, "no motion is prescribed; expected a rate of a joint");
  for (int i = 0; i < d->tree.cluster_count; ++i) {
    const km_cluster_motion *c = &d->cluster[i];
    if (c->freedom == 0)
      continue;
    int free = d->tree.coordinate_order[d->tree.clusters[i].coordinate_start + c->independent[0]];
    return km_fail(
        error, KM_USAGE,
        "joint \"%s\" can still move beside the prescribed motion (%d freedom%s more); expected a prescribed "
        "motion for each freedom, or joints that are held",
        w->m->model->coordinates[free].label, c->freedom, c->freedom == 1 ? "" : "s");
  }
  return KM_OK;
}

/* Prescribes the rates, computes the first accelerations and writes the first row. */
static km_status start(km_history_writer *w, const km_inverse_def *def, km_error *error) {
  km_state *s = w->state;
  s->time = 0.0;
  km_status status = km_dynamics_create(w->m, w->forces, &w->dynamics, error);
  for (int i = 0; i < def->rate_count && !status; ++i)
    status = km_dynamics_prescribe(w->dynamics, def->rates[i].coordinate,
                                   km_state_coordinate(s, def->rates[i].coordinate), def->rates[i].rate, error);
  if (!status)
    status = km_dynamic_friction_create(w->dynamics, &w->friction, error);
  for (int c = 0; c < w->m->coordinate_count; ++c)
    s->rate[c] = 0.0;
  if (!status)
    status = km_dynamics_move_to_prescribed(w->dynamics, s, error);
  if (!status)
    status = km_dynamics_accelerate(w->dynamics, s, error);
  if (!status)
    status = check_no_freedom(w, error);
  if (!status)
    status = km_history_monitor_limits(w, NULL, error);
  if (!status)
    status = km_history_begin(w, error);
  return status ? status : km_history_row(w, error);
}

/* Taylor predictor q + q̇ dt + q̈ dt²/2 of all coordinates; the loops are closed from there. */
static void predict(const km_mechanism *m, km_state *s, double dt) {
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->ball_of[c] < 0)
      s->q[c] += dt * (s->rate[c] + 0.5 * dt * s->acceleration[c]);
  for (int b = 0; b < m->ball_count; ++b) {
    const double *rate = &s->rate[m->ball_coordinate[b]];
    km_quaternion turn = km_quaternion_exp((km_vec3){dt * rate[0], dt * rate[1], dt * rate[2]});
    s->ball[b] = km_quaternion_normalised(km_quaternion_product(turn, s->ball[b]));
  }
}

/* Number of parts of a time step that keeps each motion below max_motion; it can exceed MAX_PARTS. */
static double parts_needed(const km_mechanism *m, const km_state *s, double dt) {
  double largest = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c)
    largest = fmax(largest, fabs(s->rate[c] * dt * m->scale[c]));
  return ceil(largest / max_motion) + 1.0;
}

static km_status fail_rows_too_far(const km_history_writer *w, double step, km_error *error) {
  const char *unit = w->m->model->units.time->suffix;
  return km_fail(
      error, KM_PARTIAL,
      "at %.9g %s the loops can't be closed: the rows are %.9g %s apart, in which joints move too far; expected more "
      "steps, or a shorter time",
      w->state->time, unit, step, unit);
}

/* Advances to a time in parts: predictor, then an evaluation that closes the loops. */
static km_status advance_to(km_history_writer *w, double time, km_error *error) {
  km_state *s = w->state;
  double from = s->time, parts_wanted = parts_needed(w->m, s, time - from);
  int parts = (int)fmin(parts_wanted, MAX_PARTS);
  for (int i = 1; i <= parts; ++i) {
    double next = i == parts ? time : from + (time - from) * i / parts;
    predict(w->m, s, next - s->time);
    s->time = next;
    km_status status = km_dynamics_accelerate(w->dynamics, s, error);
    if (status)
      return status == KM_DIVERGED && parts_wanted > MAX_PARTS ? fail_rows_too_far(w, time - from, error) : status;
  }
  return KM_OK;
}

/* Writes the rows of the motion. */
static km_status write_rows(km_history_writer *w, const km_inverse_def *def, km_error *error) {
  km_error why;
  for (int row = 1; row <= def->steps; ++row) {
    double time = def->until * row / def->steps;
    km_status status = advance_to(w, time, &why);
    if (status == KM_DIVERGED)
      return km_fail(error, KM_PARTIAL,
                     "at %.9g %s the drive can't go on: it is at a dead point, or a link's reach ends", w->state->time,
                     w->m->model->units.time->suffix);
    if (status)
      return km_fail(error, status, "%s", why.text);
    status = km_history_row(w, error);
    if (status)
      return status;
    if (def->progress && !def->progress(def->context, (double)row / def->steps))
      return km_fail(error, KM_CANCELLED, "cancelled at time %g", time);
  }
  return KM_OK;
}

km_status km_inverse_run(const km_mechanism *m, km_forces *forces, km_state *state, const km_inverse_def *def,
                         km_history *out, km_error *error) {
  km_status status = km_history_check(m, forces, state, def, out, error);
  if (!status)
    status = check_def(m, def, error);
  if (status)
    return status;
  km_error own;
  km_history_writer w = {.m = m,
                         .frames = def->frames,
                         .frame_count = def->frame_count,
                         .reactions = def->reactions,
                         .shaking = true,
                         .axes = def->axes,
                         .forces = forces,
                         .state = state,
                         .out = out};
  status = start(&w, def, &own);
  if (!status)
    status = write_rows(&w, def, &own);
  if (out->table && km_table_rows(out->table) > 0) {
    km_status found = km_inverse_find_peaks(&w, advance_to, status ? NULL : &own);
    status = status ? status : found;
  }
  return km_history_end(&w, status, &own, error);
}
