/* Continuation of a motion to a target value of the driver (theory 4.6).
 *
 *   s        scaled driver, h step, t = dq/ds with t_driver = 1, J t = 0
 *   step     : accepted -> doubled while the predictor's error allows; rejected -> halved
 *   end      : h < 1e-11 max(1, |s|): turning point (dead point) of the driver
 *   limit    : refined by one or two steps with the rate of the limited coordinate
 *   singular : passed by a step over it or by a Hermite bridge (singular_bridge.c) */
#include "base/number/tolerances.h"
#include "continuation/batch/batch_arrays.h"
#include "continuation/driver_step.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* Attempts in a row without a step of km_driver_motion_short_step: near a singular configuration steps shrink and
 * grow by halves, so a continuation that still advances needs fewer. */
enum { MOST_SHORT_ATTEMPTS = 5000 };

/* True if the step that leads back from an end is rejected even at the shortest length because new pivots show a
 * singular configuration. The end then lies in the other direction. */
static bool is_blocked_on_return(const km_driver_motion *d, double remaining) {
  return d->current.stopped == 0.0 && remaining * d->c.history.last_h < 0.0 &&
         km_continuation_is_singular(d->c.state->factor[d->c.substructure]);
}

/* Moves along a bridge: to the target if the bridge contains it, else to its end. False if no bridge is under the
 * configuration or the loops do not close. */
static bool move_along_bridge(km_driver_motion *d, double target) {
  if (d->current.bridge == 0)
    return false;
  if (km_singular_bridge_is_active(d, target))
    return km_singular_bridge_place(d, target);
  return d->current.bridge == d->bridge.number && km_singular_bridge_leave(d, target);
}

/* Advances to `target` by controlled steps; the last step sets the driver exactly. *limit: the coordinate whose limit
 * ended the motion. */
static km_attempt advance_to_target(km_driver_motion *d, double target, int *limit) {
  move_along_bridge(d, target);
  d->current.bridge = d->current.s == target ? d->current.bridge : 0;
  double step = km_smaller(d->current.largest, km_driver_motion_longest_step(d));
  bool may_build_bridge = true;
  d->rejections = 0;
  d->regular.s = HUGE_VAL;
  int most = fabs(target - d->current.s) > KM_MOST_DRIVER_STEPS * km_longest_step ? KM_MOST_STEPS_TO_UNREACHABLE
                                                                                  : KM_MOST_DRIVER_STEPS;
  for (int steps = 0, short_attempts = 0; d->current.s != target; ++steps, ++short_attempts) {
    if (steps == most || short_attempts == MOST_SHORT_ATTEMPTS)
      return KM_ATTEMPT_EXHAUSTED;
    double remaining = target - d->current.s;
    km_attempt result = km_driver_motion_step_towards(d, target, &step, limit);
    if (result == KM_ATTEMPT_ACCEPTED) {
      /* short steps are close to a branch point, where the tangent mixes several motions */
      bool is_short = fabs(d->c.history.last_h) < km_driver_motion_short_step;
      short_attempts = is_short ? short_attempts : 0;
      if (d->current.s != target && !is_short)
        km_driver_motion_notify(d, d->current.s, d->c.history.t, 1);
      continue;
    }
    double h = copysign(2.0 * step, remaining);
    bool arrives = h == remaining;
    if (result == KM_ATTEMPT_OPEN && arrives && may_build_bridge &&
        km_singular_bridge_build(d, target, copysign(1.0, remaining), 0.0) && move_along_bridge(d, target))
      continue;
    may_build_bridge = may_build_bridge && !arrives;
    km_singular_bridge_record(d, h);
    /* rates are large on the return from a located end */
    double least = d->current.stopped * remaining < 0.0 ? km_sum_rounding : km_exact_misfit;
    if (step >= least * fmax(1.0, fabs(d->current.s)))
      continue;
    if ((result == KM_ATTEMPT_OPEN || result == KM_ATTEMPT_TOO_LONG) &&
        km_singular_bridge_build(d, d->current.s, copysign(1.0, remaining), 0.7) && move_along_bridge(d, target)) {
      step = km_singular_step;
      continue;
    }
    if (result != KM_ATTEMPT_OPEN || !is_blocked_on_return(d, remaining)) {
      d->current.stopped = copysign(1.0, remaining);
      return result;
    }
    d->current.stopped = -copysign(1.0, remaining); /* the end lies in the other direction */
    step = km_smaller(d->current.largest, km_driver_motion_longest_step(d));
  }
  d->current.largest = km_larger(step, km_singular_step);
  return KM_ATTEMPT_ACCEPTED;
}

/* Moves a driver outside all loops: the value is set, within its limits. */
static km_motion_end move_tree_joint(km_driver_motion *d, double target) {
  const km_mechanism *m = d->c.mechanism;
  int c = d->c.coordinate;
  double factor = km_model_coordinate_factor(m->model, c), now = d->c.state->q[c], q = target * factor;
  km_motion_end reach = {KM_STOP_NONE, target, -1, -1};
  double slack = km_driver_motion_slack(q);
  double end = q > now ? fmax(m->high[c], now) : fmin(m->low[c], now);
  if (!d->c.ignore_limits && (q > now ? q > end + slack : q < end - slack)) {
    reach = (km_motion_end){KM_STOP_LIMIT, end / factor, -1, c};
    q = end;
  }
  d->c.state->q[c] = q;
  return reach;
}

/* Refines the configuration at the limit of coordinate c. */
static void refine_limit(km_driver_motion *d, int c) {
  int limit = -1;
  for (int round = 0; round < 2; ++round) {
    double h = km_continuation_step_to_limit(&d->c, c);
    if (h == 0.0 || km_driver_motion_advance(d, h, km_correction_ratio, &limit) != KM_ATTEMPT_ACCEPTED)
      return;
  }
}

/* Returns the goal, or the driver's own limit before it. */
static double clamp_to_driver_limit(const km_driver_motion *d, double goal) {
  const km_mechanism *m = d->c.mechanism;
  int c = d->c.coordinate;
  double unit = m->unit[c], high = km_larger(m->high[c] / unit, d->current.s),
         low = km_smaller(m->low[c] / unit, d->current.s);
  double slack = km_driver_motion_slack(goal);
  return d->c.ignore_limits || (goal <= high + slack && goal >= low - slack) ? goal : goal > high ? high : low;
}

/* True if the goal is within 1e-9 of s and the loops close there: the turning point itself, which Newton's method
 * approaches only linearly. The state is then at the goal. */
static bool close_at_turning_point(km_driver_motion *d, double goal) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  if (!(fabs(d->current.s - goal) <= km_relative_zero))
    return false;
  km_closure evidence;
  km_state_save(d->c.state, sub, d->c.from);
  km_continuation_set_driver(&d->c, goal);
  km_loops_close(d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &evidence);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  if (km_loops_residual(d->c.mechanism, d->c.state, sub) <= km_solved_rounding)
    return true;
  km_state_restore(d->c.state, sub, d->c.from);
  return false;
}

/* Returns the slide whose distance ends the motion: beyond 100 sizes, distance and rate use up the digits of the
 * pivots. -1: none. */
static int find_distant_slide(const km_driver_motion *d) {
  static const double distant = 100.0; /* substructure sizes */
  const km_substructure *sub = km_driver_motion_substructure(d);
  for (int k = 0; k < sub->columns; ++k)
    if (fabs(km_driver_step_slide_position(d, k)) > distant)
      return d->c.mechanism->column_coordinate[sub->column_start + k];
  return -1;
}

void km_driver_motion_prepare(km_driver_motion *d, double target) {
  km_driver_motion_write_back(d);
  if (!d->current.known && clamp_to_driver_limit(d, target * km_driver_motion_factor(d)) != d->current.s)
    km_driver_motion_start(d);
}

void km_driver_motion_begin(km_driver_motion *d, double target) {
  km_driver_motion_write_back(d);
  double goal = clamp_to_driver_limit(d, target * km_driver_motion_factor(d)), remaining = goal - d->current.s;
  int limit;
  if (km_driver_motion_reaches(remaining, d->current.largest) || !(d->current.known || km_driver_motion_start(d)))
    return;
  double step = km_smaller(d->current.largest, km_driver_motion_longest_step(d));
  if (km_driver_motion_step_towards(d, goal, &step, &limit) != KM_ATTEMPT_ACCEPTED)
    return;
  d->current.largest = fmax(step, km_singular_step);
  km_driver_motion_notify(d, d->current.s, d->c.history.t, 1);
}

km_motion_end km_driver_motion_move_to(km_driver_motion *d, double target) {
  if (!d || !isfinite(target))
    return (km_motion_end){KM_STOP_MAX_STEPS, nan(""), -1, -1};
  if (d->c.substructure < 0)
    return move_tree_joint(d, target);
  km_driver_motion_write_back(d);
  const km_mechanism *m = d->c.mechanism;
  double factor = km_driver_motion_factor(d), goal = target * factor, own = clamp_to_driver_limit(d, goal);
  int limit = -1;
  km_attempt result = KM_ATTEMPT_ACCEPTED;
  if (d->current.s != own) {
    bool has_tangent = d->current.known || km_driver_motion_start(d);
    result = has_tangent ? advance_to_target(d, own, &limit) : KM_ATTEMPT_OPEN;
  }
  if (result == KM_ATTEMPT_ACCEPTED ||
      ((result == KM_ATTEMPT_OPEN || result == KM_ATTEMPT_TOO_LONG) && close_at_turning_point(d, own)))
    return own == goal ? (km_motion_end){KM_STOP_NONE, target, -1, -1}
                       : (km_motion_end){KM_STOP_LIMIT, own / factor, -1, d->c.coordinate};
  if (result == KM_ATTEMPT_AT_LIMIT)
    refine_limit(d, limit);
  /* the rejected trial left errors and Jacobian of another configuration */
  km_loops_update(m, d->c.state, km_driver_motion_substructure(d));
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  if (result == KM_ATTEMPT_EXHAUSTED)
    return (km_motion_end){KM_STOP_MAX_STEPS, d->current.s / factor, d->c.substructure, -1};
  if (result == KM_ATTEMPT_AT_LIMIT)
    return (km_motion_end){KM_STOP_LIMIT, d->current.s / factor, -1, limit};
  int slide = result == KM_ATTEMPT_DIVERGING ? limit : find_distant_slide(d);
  return (km_motion_end){slide >= 0 ? KM_STOP_UNBOUNDED : KM_STOP_TOGGLE, d->current.s / factor, d->c.substructure,
                         slide};
}

void km_driver_motion_rates(const km_driver_motion *d, const double *t, int stride, double *rates) {
  if (d->c.substructure >= 0)
    km_continuation_rates(&d->c, t, stride, 1.0 / d->c.mechanism->unit[d->c.coordinate], rates);
  else
    memset(rates, 0, (size_t)d->c.mechanism->coordinate_count * sizeof *rates);
  rates[d->c.coordinate] = 1.0;
}

void km_driver_motion_notify(const km_driver_motion *d, double s, const double *t, int stride) {
  if (!d->observer.notify)
    return;
  km_driver_motion_rates(d, t, stride, d->observer.rates);
  d->observer.notify(d->observer.self, s / km_driver_motion_factor(d), d->observer.rates);
}

void km_driver_motion_expect_stiff(km_driver_motion *d) {
  d->current.is_stiff = d->c.substructure >= 0;
}

bool km_driver_motion_tangent(km_driver_motion *d, double *rates) {
  if (!d || !rates)
    return false;
  if (km_driver_motion_is_batched(d)) {
    km_driver_motion_rates(d, &d->lanes->t->of[d->lane], KM_BATCH_LANES, rates);
    return true;
  }
  km_driver_motion_write_back(d);
  if (d->c.substructure >= 0 && !d->current.known && !km_driver_motion_start(d))
    return false;
  km_driver_motion_rates(d, d->c.history.t, 1, rates);
  return true;
}

int km_driver_motion_crossings(const km_driver_motion *d) {
  if (!d)
    return 0;
  return d->current.crossings;
}
