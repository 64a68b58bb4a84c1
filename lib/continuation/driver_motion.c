/* Moving a driver: controlled steps to a target, ends and limits. */
#include "continuation/batch/batch_arrays.h"
#include "continuation/driver_step.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

static const double shortest = 1e-11; /* a step below this doesn't move: the end is located */
static const double leaving = 1e-14;  /* the same on the way back from a located end, where all is steep */

/* Steps towards one target. One that is further away than so many of the longest can't be reached: fewer are enough to look
 * for an end or a limit on the way to it. */
enum { MOST_STEPS = 200000, MOST_STEPS_ASTRAY = 10000 };

/* Near a singular pose steps shrink and grow again by halves. Where they stay short, so many attempts in a row without a step as long as
 * km_driver_motion_creeping are enough to know that nothing moves. */
enum { MOST_CREEPING = 5000 };

/* Several freedoms that are steady go by Adams and Bashforth's second order alone. */
static bool is_several_steady(const km_driver_motion *d) {
  return d->c.steady.is_active && d->c.steady.count > 1;
}

static double longest_step(const km_driver_motion *d) {
  static const double of_several = 0.01;
  return is_several_steady(d) ? of_several : km_driver_longest_step;
}

/* After a step of h that was accepted: how long the next one may be. */
static double lengthen(km_driver_motion *d, double step, double h) {
  static const double easily_drawn = 0.2; /* see km_driver_motion_easy */
  if (fabs(h) > km_driver_motion_leaves && !km_continuation_is_singular(&d->c.state->partition[d->c.substructure]))
    d->here.stopped = 0.0;
  double share = step / fabs(h), square = share * share;
  bool easily =
      d->here.stiff ? d->strain * square < easily_drawn : d->strain * (square * square) < km_driver_motion_easy;
  return easily ? km_smaller(2.0 * step, longest_step(d)) : step;
}

/* Are even the shortest steps refused that lead back where the drive came from, since it has come so close to an end that pivots found
 * anew show a singular pose? */
static bool turns_back(const km_driver_motion *d, double left) {
  return d->here.stopped == 0.0 && left * d->c.course.last_h < 0.0 &&
         km_continuation_is_singular(&d->c.state->partition[d->c.substructure]);
}

/* Over a bridge: to the target if it is on it, else to its end. False: the place is on no bridge, or the loops don't close there. */
static bool use_bridge(km_driver_motion *d, double target) {
  if (d->here.bridge == 0)
    return false;
  if (km_singular_bridge_is_active(d, target))
    return km_singular_bridge_place(d, target);
  return d->here.bridge == d->bridge.number && km_singular_bridge_leave(d, target);
}

/* Advances to `target` by controlled steps; the step that arrives sets the driver exactly. */
static km_attempt walk(km_driver_motion *d, double target, int *limit) {
  use_bridge(d, target);
  d->here.bridge = d->here.s == target ? d->here.bridge : 0;
  double step = km_smaller(d->here.largest, longest_step(d));
  bool may_cross = true;
  d->bent = 0;
  d->regular.s = HUGE_VAL;
  int most = fabs(target - d->here.s) > MOST_STEPS * km_driver_longest_step ? MOST_STEPS_ASTRAY : MOST_STEPS;
  for (int steps = 0, crept = 0; d->here.s != target; ++steps, ++crept) {
    if (steps == most || crept == MOST_CREEPING)
      return KM_ATTEMPT_EXHAUSTED;
    double left = target - d->here.s;
    bool arrives = fabs(left) <= step * km_driver_motion_reach;
    /* Of a short last step the next one would know little. */
    bool halves = (d->here.stiff || is_several_steady(d)) && !arrives && fabs(left) < 2.0 * step;
    double h = arrives ? left : halves ? 0.5 * left : copysign(step, left);
    km_attempt result = km_driver_motion_advance(d, h, km_driver_motion_tightness, limit);
    if (result == KM_ATTEMPT_ACCEPTED) {
      crept = fabs(h) < km_driver_motion_creeping ? crept : 0;
      step = lengthen(d, step, h);
      if (arrives) { /* s + (target - s) may be the next number */
        d->here.s = target;
        km_continuation_place(&d->c, target);
      } else if (fabs(h) >
                 km_driver_motion_branch_width) { /* nearer to where many motions meet their tangents are mixed */
        km_driver_motion_notify(d, d->here.s, d->c.course.t, 1);
      }
      continue;
    }
    if (result == KM_ATTEMPT_OPEN && arrives && may_cross &&
        km_singular_bridge_build(d, target, copysign(1.0, left), 0.0) && use_bridge(d, target))
      continue;
    may_cross = may_cross && !arrives;
    km_singular_bridge_record(d, h);
    step = 0.5 * fabs(h);
    double least = d->here.stopped * left < 0.0 ? leaving : shortest;
    if (step >= least * fmax(1.0, fabs(d->here.s)))
      continue;
    if ((result == KM_ATTEMPT_OPEN || result == KM_ATTEMPT_BENT) &&
        km_singular_bridge_build(d, d->here.s, copysign(1.0, left), 0.7) && use_bridge(d, target)) {
      step = km_driver_motion_least_first;
      continue;
    }
    if (result != KM_ATTEMPT_OPEN || !turns_back(d, left)) {
      d->here.stopped = copysign(1.0, left);
      return result;
    }
    d->here.stopped = -copysign(1.0, left); /* the end lies the other way */
    step = km_smaller(d->here.largest, longest_step(d));
  }
  d->here.largest = km_larger(step, km_driver_motion_least_first);
  return KM_ATTEMPT_ACCEPTED;
}

static km_motion_end drive_tree_joint(km_driver_motion *d, double target) {
  const km_mechanism *m = d->c.mechanism;
  int c = d->c.coordinate;
  double factor = km_model_coordinate_factor(m->model, c), now = d->c.state->q[c], q = target * factor;
  km_motion_end reach = {KM_STOP_NONE, target, -1, -1};
  double slack = 1e-12 * (1.0 + fabs(q));
  double end = q > now ? fmax(m->high[c], now) : fmin(m->low[c], now);
  if (!d->c.ignore_limits && (q > now ? q > end + slack : q < end - slack)) {
    reach = (km_motion_end){KM_STOP_LIMIT, end / factor, -1, c};
    q = end;
  }
  d->c.state->q[c] = q;
  return reach;
}

/* The steps that ended at coordinate c's limit have found it to their own length; one or two more by its rate leave
 * nothing but rounding. */
static void settle_at_limit(km_driver_motion *d, int c) {
  const km_mechanism *m = d->c.mechanism;
  int k = m->column_of[c], limit = -1;
  for (int round = 0; round < 2; ++round) {
    double q = d->c.state->q[c], bound = fabs(m->high[c] - q) < fabs(q - m->low[c]) ? m->high[c] : m->low[c];
    double gap = (bound - q) / m->unit[c] / d->c.course.t[k];
    if (m->ball_of[c] >= 0 || gap == 0.0 || !(fabs(gap) < 1e-7) ||
        km_driver_motion_advance(d, gap, km_driver_motion_tightness, &limit) != KM_ATTEMPT_ACCEPTED)
      return;
  }
}

/* The goal, or the driver's own limit on the way to it. */
static double within_own_limit(const km_driver_motion *d, double goal) {
  const km_mechanism *m = d->c.mechanism;
  int c = d->c.coordinate;
  double unit = m->unit[c], high = km_larger(m->high[c] / unit, d->here.s),
         low = km_smaller(m->low[c] / unit, d->here.s);
  double slack = km_driver_motion_slack(goal);
  return d->c.ignore_limits || (goal <= high + slack && goal >= low - slack) ? goal : goal > high ? high : low;
}

/* Is the goal the end itself? Then the pose there, which Newton approaches only slowly, is as good as any. */
static bool touches(km_driver_motion *d, double goal) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  if (!(fabs(d->here.s - goal) <= 1e-9))
    return false;
  km_closure evidence;
  int worst;
  km_state_save(d->c.state, sub, d->c.from);
  km_continuation_place(&d->c, goal);
  km_loops_close(d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &evidence);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  if (km_loops_residual(d->c.mechanism, d->c.state, sub, &worst) <= km_driver_motion_closed)
    return true;
  km_state_restore(d->c.state, sub, d->c.from);
  return false;
}

/* The slide that has come so far where the motion ends that it is what ends it: its distance and its rate have used up the digits
 * of the pivots. -1: there is none. */
static int far_slide(const km_driver_motion *d) {
  static const double far = 100.0; /* substructure sizes */
  const km_substructure *sub = km_driver_motion_substructure(d);
  for (int k = 0; k < sub->columns; ++k)
    if (fabs(km_driver_step_diverges(d, k)) > far)
      return d->c.mechanism->column_coordinate[sub->column_start + k];
  return -1;
}

void km_driver_motion_prepare(km_driver_motion *d, double target) {
  km_driver_motion_write_back(d);
  if (!d->here.known && within_own_limit(d, target * km_driver_motion_factor(d)) != d->here.s)
    km_driver_motion_start(d);
}

void km_driver_motion_begin(km_driver_motion *d, double target) {
  km_driver_motion_write_back(d);
  double goal = within_own_limit(d, target * km_driver_motion_factor(d)), left = goal - d->here.s;
  int limit;
  if (fabs(left) <= d->here.largest * km_driver_motion_reach || !(d->here.known || km_driver_motion_start(d)))
    return;
  double step = km_smaller(d->here.largest, longest_step(d));
  double h = copysign(step, left);
  if (km_driver_motion_advance(d, h, km_driver_motion_tightness, &limit) != KM_ATTEMPT_ACCEPTED)
    return;
  d->here.largest = fmax(lengthen(d, step, h), km_driver_motion_least_first);
  km_driver_motion_notify(d, d->here.s, d->c.course.t, 1);
}

km_motion_end km_driver_motion_move_to(km_driver_motion *d, double target) {
  if (!d || !isfinite(target))
    return (km_motion_end){KM_STOP_MAX_STEPS, nan(""), -1, -1};
  if (d->c.substructure < 0)
    return drive_tree_joint(d, target);
  km_driver_motion_write_back(d);
  const km_mechanism *m = d->c.mechanism;
  double factor = km_driver_motion_factor(d), goal = target * factor, own = within_own_limit(d, goal);
  int limit = -1;
  km_attempt result = KM_ATTEMPT_ACCEPTED;
  if (d->here.s != own) {
    bool ready = d->here.known || km_driver_motion_start(d);
    result = ready ? walk(d, own, &limit) : KM_ATTEMPT_OPEN;
  }
  if (result == KM_ATTEMPT_ACCEPTED || ((result == KM_ATTEMPT_OPEN || result == KM_ATTEMPT_BENT) && touches(d, own)))
    return own == goal ? (km_motion_end){KM_STOP_NONE, target, -1, -1}
                       : (km_motion_end){KM_STOP_LIMIT, own / factor, -1, d->c.coordinate};
  if (result == KM_ATTEMPT_LIMITED)
    settle_at_limit(d, limit);
  /* What was tried last has left another pose's Jacobian behind. */
  km_loops_update(m, d->c.state, km_driver_motion_substructure(d));
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  if (result == KM_ATTEMPT_EXHAUSTED)
    return (km_motion_end){KM_STOP_MAX_STEPS, d->here.s / factor, d->c.substructure, -1};
  if (result == KM_ATTEMPT_LIMITED)
    return (km_motion_end){KM_STOP_LIMIT, d->here.s / factor, -1, limit};
  int slide = result == KM_ATTEMPT_AWAY ? limit : far_slide(d);
  return (km_motion_end){slide >= 0 ? KM_STOP_UNBOUNDED : KM_STOP_TOGGLE, d->here.s / factor, d->c.substructure, slide};
}

void km_driver_motion_rates(const km_driver_motion *d, const double *t, int stride, double *rates) {
  const km_mechanism *m = d->c.mechanism;
  memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
  rates[d->c.coordinate] = 1.0;
  if (d->c.substructure < 0)
    return;
  const km_substructure *sub = km_driver_motion_substructure(d);
  double inverse = 1.0 / m->unit[d->c.coordinate];
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    rates[c] = t[k * stride] * m->unit[c] * inverse;
  }
}

void km_driver_motion_notify(const km_driver_motion *d, double s, const double *t, int stride) {
  if (!d->watch.stepped)
    return;
  km_driver_motion_rates(d, t, stride, d->watch.rates);
  d->watch.stepped(d->watch.self, s / km_driver_motion_factor(d), d->watch.rates);
}

void km_driver_motion_expect_stiff(km_driver_motion *d) {
  d->here.stiff = d->c.substructure >= 0;
}

bool km_driver_motion_tangent(km_driver_motion *d, double *rates) {
  if (!d || !rates)
    return false;
  if (km_driver_motion_is_batched(d)) {
    km_driver_motion_rates(d, &d->lanes->t->of[d->lane], KM_BATCH_LANES, rates);
    return true;
  }
  km_driver_motion_write_back(d);
  if (d->c.substructure >= 0 && !d->here.known && !km_driver_motion_start(d))
    return false;
  km_driver_motion_rates(d, d->c.course.t, 1, rates);
  return true;
}

int km_driver_motion_crossings(const km_driver_motion *d) {
  if (!d)
    return 0;
  return d->here.crossings;
}
