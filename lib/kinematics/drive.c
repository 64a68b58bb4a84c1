/* Moving a driver: controlled steps to a target, ends, limits, and singular poses that are passed. */
#include "kinematics/drive_lanes.h"

#include "base/larger.h"
#include "kinematics/closure.h"
#include "kinematics/curve.h"
#include "kinematics/loops.h"

#include <string.h>

/* Predictor-corrector in the driver s. Symbols: t = dq/ds (scaled, driver's entry 1), h the step in s. */

static const double shortest = 1e-11;    /* a step below this doesn't move: the end is located */
static const double leaving = 1e-14;     /* the same on the way back from a located end, where all is steep */
static const double branch_width = 1e-5; /* a change of sign that stays below this step is a branch point */
static const double crossing = 1e-3;     /* distance from a singular pose at which it is crossed */
static const double between = 1e-12;     /* residual that shows the pose between two regular ones to be on the branch */

typedef enum attempt { ACCEPTED, OPEN, BENT, LIMITED, AWAY, EXHAUSTED } attempt;

static const double easily_drawn = 0.2; /* see km_drive_easy */

/* Steps towards one target. One that is further away than so many of the longest can't be reached: fewer are enough to look
 * for an end or a limit on the way to it. */
enum { MOST_STEPS = 200000, MOST_STEPS_ASTRAY = 10000 };

/* Near a singular pose steps shrink and grow again by halves. Where they stay short nothing moves but what rounding lets
 * through, and so many attempts in a row without a step as long as `creeping` are enough to know. */
enum { MOST_CREEPING = 5000 };
static const double creeping = 1e-5;

static void remember_pivots(km_drive *d) {
  km_partition_copy_pivots(&d->c.course.reference, &d->c.state->partition[d->c.substructure]);
}

/* Pivots and tangent of the present pose, searched. */
static bool start(km_drive *d) {
  const km_substructure *sub = km_drive_driven(d);
  int worst;
  km_loops_update(d->c.mechanism, d->c.state, sub);
  double residual = km_loops_residual(d->c.mechanism, d->c.state, sub, &worst);
  km_pivot_for_steps(d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                     km_rank_tolerance(d->c.mechanism, sub, residual));
  d->here.known = km_continuation_tangent(&d->c, NULL, d->c.course.t);
  remember_pivots(d);
  km_course_begin(&d->c.course, km_drive_driven(d)->columns);
  return d->here.known;
}

/* Where the driver has the only freedom, det of the pivot block changes sign only at a singular pose of the
 * driver: a change over a step that should be regular is a jump to another branch. */
static bool sign_changed(km_drive *d) {
  const km_partition *p = &d->c.state->partition[d->c.substructure];
  if (km_partition_freedom(p) != 1 || p->rank != d->c.course.reference.rank)
    return false;
  if (p->searches == d->c.course.reference.searches)
    return p->sign != d->c.course.reference.sign;
  int before = d->c.course.reference.sign;
  km_partition_refactor_whole(&d->c.course.reference, km_state_jacobian(d->c.state, km_drive_driven(d)));
  int after = d->c.course.reference.sign;
  d->c.course.reference.sign = before;
  return before != after;
}

static bool is_alone(const km_drive *d) {
  return km_partition_freedom(&d->c.course.reference) <= 1;
}

/* So many refusals in a row show that the path may be stiff. */
enum { MOST_BENT = 2 };

/* False for ball joints, or out of memory. */
static bool need_closest(km_drive *d) {
  if (d->closest || d->c.mechanism->ball_count > 0)
    return d->closest != NULL;
  km_closest *closest = KM_ARENA_NEW(&d->arena, km_closest, 1);
  if (closest && km_closest_reserve(closest, d->c.mechanism, km_drive_driven(d), &d->arena))
    d->closest = closest;
  return d->closest != NULL;
}

static bool draw(km_drive *d, double h) {
  if (fabs(h) < creeping || !need_closest(d))
    return false;
  d->strain = km_least_path_draw(d->closest, d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &d->c.course,
                                 h, d->c.move);
  km_state_restore(d->c.state, km_drive_driven(d), d->c.from);
  km_partition_copy_pivots(&d->c.state->partition[d->c.substructure], &d->c.course.reference);
  d->c.state->pivoted[d->c.substructure] = d->c.column;
  return d->drawn = d->strain <= 1.0;
}

/* Along the path of least motion, by whichever way serves, those that cost least first. */
static bool follow_path(km_drive *d, double h) {
  const km_substructure *sub = km_drive_driven(d);
  if (d->here.stiff && (draw(d, h) || d->bent == 0))
    return d->drawn;
  d->strain = km_least_path_continue(d->c.mechanism, sub, &d->c.course, h, d->c.move);
  if (!(d->strain <= 1.0)) {
    d->strain = km_least_path_predict(&d->path, d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                                      &d->c.course.reference, d->c.from, d->c.course.t, h, d->c.move);
    km_state_restore(d->c.state, sub, d->c.from);
  }
  return d->strain <= 1.0 || (!d->here.stiff && d->bent >= MOST_BENT && draw(d, h));
}

/* Where a slide is, in substructure sizes; 0 of an angle. */
static double slid(const km_drive *d, int column) {
  const km_mechanism *m = d->c.mechanism;
  int c = m->column_coordinate[km_drive_driven(d)->column_start + column];
  return km_model_coordinate_is_length(m->model, c) ? d->c.state->q[c] / m->unit[c] : 0.0;
}

/* How far a column may go in one step. A slide that leaves takes as many steps to each tenfold of its distance. */
static double furthest(const km_drive *d, int column) {
  static const double share = 0.25;
  return km_larger(share * fabs(slid(d, column)), km_drive_furthest);
}

/* The coordinate of a slide that the step just tried leads so far away, so fast, that it leaves without bound; -1: none. */
static int leaves(const km_drive *d, double h) {
  const km_substructure *sub = km_drive_driven(d);
  double fastest = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    fastest = km_larger(fabs(d->c.next_t[k]), fastest);
  for (int k = 0; k < sub->columns && fastest > km_drive_away; ++k)
    if (fabs(d->c.next_t[k]) > km_drive_away && d->c.next_t[k] * h * slid(d, k) > 0.0 &&
        fabs(slid(d, k)) > km_drive_away)
      return d->c.mechanism->column_coordinate[sub->column_start + k];
  return -1;
}

/* Where the driver has the only freedom Newton decides everything, and any start near enough serves. Where other freedoms
 * are left the prediction decides what they do: the path of least motion. False if h is too long for it. */
static bool predict(km_drive *d, double h) {
  const km_substructure *sub = km_drive_driven(d);
  bool reaches = true;
  d->drawn = false;
  d->strain = 0.0;
  if (is_alone(d))
    km_continuation_predict(&d->c, h, true);
  else
    reaches = follow_path(d, h);
  for (int k = 0; k < sub->columns; ++k)
    if (!(fabs(d->c.move[k]) <= km_drive_furthest) && !(fabs(d->c.move[k]) <= furthest(d, k)))
      return false;
  return reaches;
}

/* Where other freedoms are left, too few rows of a singular pose tell what they do. */
static bool may_be_singular(const km_drive *d) {
  return !is_alone(d) && d->c.course.last_h == 0.0 && d->c.course.reference.rank < km_drive_driven(d)->rows;
}

/* Does the way that these follow open the loops by far more than it errs? */
static bool opens(km_drive *d) {
  static const double far_more = 100.0;
  const km_substructure *sub = km_drive_driven(d);
  double longest = 0.0;
  int worst;
  for (int k = 0; k < sub->columns; ++k)
    longest = km_larger(fabs(d->c.move[k]), longest);
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  double misfit = km_loops_residual(d->c.mechanism, d->c.state, sub, &worst);
  km_state_restore(d->c.state, sub, d->c.from);
  return misfit > far_more * (km_path_allowed * longest + km_path_grain) + d->c.mechanism->closure_tolerance;
}

/* Has the pose that was reached more independent rows? */
static bool leaves_singular(km_drive *d) {
  const km_substructure *sub = km_drive_driven(d);
  km_partition *p = &d->c.state->partition[d->c.substructure];
  p->rows_only = p->sparse != NULL;
  km_pivot(d->c.mechanism, d->c.state, d->c.substructure, d->c.column, km_rank_tolerance(d->c.mechanism, sub, 0.0));
  int rank = p->rank;
  p->rows_only = false;
  km_partition_copy_pivots(p, &d->c.course.reference);
  km_partition_refactor_whole(p, km_state_jacobian(d->c.state, sub));
  return rank != d->c.course.reference.rank;
}

/* One predictor and its correction to s + h; the state is left where it ended. */
static attempt try_step(km_drive *d, double h, double tightness) {
  if (d->bent > 0 && fabs(h) < creeping && may_be_singular(d)) /* too short to tell */
    return BENT;
  if (!predict(d, h) || (may_be_singular(d) && !d->drawn && opens(d)))
    return BENT;
  const km_step_terms terms = {.parameter = d->here.s + h,
                               .most_correction = km_drive_most_correction(
                                   tightness, km_step_length(d->c.mechanism, km_drive_driven(d), d->c.move)),
                               .least_cosine = km_drive_least_cosine(tightness),
                               .least_rank = d->c.course.reference.rank,
                               .leaves_end = d->here.stopped * h < 0.0};
  km_step_fate fate = km_continuation_correct(&d->c, &terms);
  if (fate != KM_STEP_TAKEN)
    return fate == KM_STEP_OPEN ? OPEN : BENT;
  if (may_be_singular(d) && leaves_singular(d))
    return BENT;
  bool changed = !d->passing && sign_changed(d);
  if (changed && fabs(h) > branch_width)
    return BENT;
  d->here.crossings += changed;
  return ACCEPTED;
}

/* May the step just tried be taken? Else `limit` is the coordinate that forbids it. */
static attempt judge(const km_drive *d, double h, int *limit) {
  int passed = km_continuation_limit(&d->c, h), gone = passed < 0 ? leaves(d, h) : -1;
  *limit = passed >= 0 ? passed : gone >= 0 ? gone : *limit;
  return passed >= 0 ? LIMITED : gone >= 0 ? AWAY : ACCEPTED;
}

/* Tries to advance by h. Restores the pose if refused. */
static attempt advance(km_drive *d, double h, double tightness, int *limit) {
  km_state_save(d->c.state, km_drive_driven(d), d->c.from);
  attempt result = try_step(d, h, tightness);
  result = result == ACCEPTED ? judge(d, h, limit) : result;
  if (result != ACCEPTED) {
    ++d->bent;
    km_continuation_refuse(&d->c);
    return result;
  }
  d->bent = 0;
  d->here.stiff = d->drawn;
  km_continuation_accept(&d->c, h);
  d->here.s += h;
  d->here.known = true;
  return ACCEPTED;
}

/* Passes a singular pose at `target` along the smooth branch: the pose between two regular ones on either
 * side, by the cubic through both. Near it Newton finds no more than half the digits. */
static bool cross(km_drive *d, double target, int *limit) {
  const km_substructure *sub = km_drive_driven(d);
  double side = target > d->here.s ? 1.0 : -1.0;
  double gap = target - side * crossing - d->here.s;
  if (gap != 0.0 && advance(d, gap, km_drive_tightness, limit) != ACCEPTED)
    return false;
  double h = target + side * crossing - d->here.s, near = target - d->here.s;
  km_state_save(d->c.state, sub, d->near);
  d->passing = true;
  attempt beyond = advance(d, h, km_drive_crossing_tightness, limit);
  d->passing = false;
  if (beyond != ACCEPTED)
    return false;
  /* Accepting it has moved its tangent and its move to last_t, last_move. */
  km_state_save(d->c.state, sub, d->far);
  km_state_restore(d->c.state, sub, d->near);
  km_curve_between(sub->columns, h, d->c.course.last_move, d->c.course.last_t, d->c.course.t, near, d->c.move,
                   d->c.next_t);
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_continuation_place(&d->c, target);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_state_forget_pivots(d->c.state, d->c.substructure);
  int worst;
  if (km_loops_residual(d->c.mechanism, d->c.state, sub, &worst) > between) {
    km_state_restore(d->c.state, sub, d->far); /* a regular pose, if on the other side */
    return false;
  }
  memcpy(d->c.course.t, d->c.next_t, (size_t)sub->columns * sizeof *d->c.course.t);
  d->here.crossings++;
  d->here.s = target;
  km_course_begin(&d->c.course, sub->columns);
  return true;
}

/* After a step of h that was accepted: how long the next one may be. */
static double lengthen(km_drive *d, double step, double h) {
  if (fabs(h) > km_drive_leaves && !km_continuation_is_singular(&d->c.state->partition[d->c.substructure]))
    d->here.stopped = 0.0;
  double share = step / fabs(h), square = share * share;
  bool easily = d->here.stiff ? d->strain * square < easily_drawn : d->strain * (square * square) < km_drive_easy;
  return easily ? km_smaller(2.0 * step, km_drive_longest) : step;
}

/* Are even the shortest steps refused that lead back where the drive came from, since it has come so close to an end that pivots found
 * anew show a singular pose? */
static bool turns_back(const km_drive *d, double left) {
  return d->here.stopped == 0.0 && left * d->c.course.last_h < 0.0 &&
         km_continuation_is_singular(&d->c.state->partition[d->c.substructure]);
}

/* At a toggle the rates of others grow without bound: by so much, in radians or sizes of the substructure for each of the driver's, at the
 * distance at which an end is located. Where they don't, the mechanism is singular, but not there that it turns back. */
static bool is_toggle(const km_drive *d) {
  static const double beyond_bounds = 1e3;
  double fastest = 0.0;
  for (int k = 0; k < km_drive_driven(d)->columns; ++k)
    fastest = km_larger_or_nan(fabs(d->c.course.t[k]), fastest);
  return !(fastest < beyond_bounds);
}

/* Where a step of a length that tells poses apart is refused, the present pose may still be away from what refuses it. */
static void remember_place(km_drive *d, double h) {
  static const double long_enough = 5e-3;
  const km_course *course = &d->c.course;
  if (fabs(h) < long_enough)
    return;
  km_state_save(d->c.state, km_drive_driven(d), d->regular.pose);
  d->regular.s = d->here.s;
  d->regular.h = course->last_h;
  memcpy(d->regular.move, course->last_move, (size_t)km_drive_driven(d)->columns * sizeof *course->last_move);
}

/* Back to the place that was remembered, or to the one a step before it. */
static bool go_back(km_drive *d, bool before) {
  const km_substructure *sub = km_drive_driven(d);
  const km_drive_regular *r = &d->regular;
  km_state_restore(d->c.state, sub, r->pose);
  d->here.s = r->s;
  if (before) {
    for (int k = 0; k < sub->columns; ++k)
      d->c.move[k] = -r->move[k];
    km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
    d->here.s -= r->h;
    km_continuation_place(&d->c, d->here.s);
  }
  return start(d);
}

/* Does the motion behind a singular pose at `s` come back to it? Else there is a gap between two toggles. The drive stays behind. */
static bool comes_back(km_drive *d, double s, int *limit) {
  static const double near_enough = 1e-5, no_step = 1e-7;
  const km_drive_place behind = d->here;
  km_state_save(d->c.state, km_drive_driven(d), d->far);
  double step = fabs(s - d->here.s), left = step;
  while (left > near_enough && step > no_step) {
    step = km_smaller(step, 0.5 * left);
    bool taken = advance(d, copysign(step, s - d->here.s), km_drive_tightness, limit) == ACCEPTED;
    step *= taken ? 2.0 : 0.5;
    left = fabs(s - d->here.s);
  }
  km_state_restore(d->c.state, km_drive_driven(d), d->far);
  d->here = behind;
  return left <= near_enough && start(d);
}

/* Over a singular pose at `s`, as far behind it as it is away. */
static bool leap(km_drive *d, double s, double target, int *limit) {
  double way = 2.0 * (s - d->here.s);
  way = fabs(way) < fabs(target - d->here.s) ? way : target - d->here.s;
  d->passing = true;
  bool over = way * (target - s) > 0.0 && advance(d, way, km_drive_crossing_tightness, limit) == ACCEPTED && start(d);
  d->passing = false;
  return over;
}

/* Steps have become too short at a singular pose that is no toggle: many motions may meet there, between which short steps can't tell.
 * False, with the state where it was, if no step from a place before it leads over it. */
static bool leap_over(km_drive *d, double target, int *limit) {
  const km_drive_place here = d->here;
  if (is_toggle(d) || d->regular.s == d->here.s || !(fabs(d->regular.s - d->here.s) <= km_drive_longest))
    return false;
  km_state_save(d->c.state, km_drive_driven(d), d->near);
  for (int before = 0; before < (d->regular.h != 0.0 ? 2 : 1); ++before)
    if (go_back(d, before) && leap(d, here.s, target, limit) && comes_back(d, here.s, limit)) {
      d->here.crossings++;
      return true;
    }
  km_state_restore(d->c.state, km_drive_driven(d), d->near);
  d->here = here;
  d->here.known = false;
  return false;
}

/* Advances to `target` by controlled steps; the step that arrives sets the driver exactly. */
static attempt walk(km_drive *d, double target, int *limit) {
  double step = d->here.largest;
  bool may_cross = true;
  d->bent = 0;
  d->regular.s = HUGE_VAL;
  int most = fabs(target - d->here.s) > MOST_STEPS * km_drive_longest ? MOST_STEPS_ASTRAY : MOST_STEPS;
  for (int steps = 0, crept = 0; d->here.s != target; ++steps, ++crept) {
    if (steps == most || crept == MOST_CREEPING)
      return EXHAUSTED;
    double left = target - d->here.s;
    bool arrives = fabs(left) <= step * km_drive_reach;
    /* Of a short last step the next one would know little. */
    bool halves = d->here.stiff && !arrives && fabs(left) < 2.0 * step;
    double h = arrives ? left : halves ? 0.5 * left : copysign(step, left);
    attempt result = advance(d, h, km_drive_tightness, limit);
    if (result == ACCEPTED) {
      crept = fabs(h) < creeping ? crept : 0;
      step = lengthen(d, step, h);
      if (arrives) { /* s + (target - s) may be the next number */
        d->here.s = target;
        km_continuation_place(&d->c, target);
      } else if (fabs(h) > branch_width) { /* nearer to where many motions meet their tangents are mixed */
        km_drive_tell(d, d->here.s, d->c.course.t, 1);
      }
      continue;
    }
    if (result == OPEN && arrives && may_cross && cross(d, target, limit))
      continue;
    may_cross = may_cross && !arrives;
    remember_place(d, h);
    step = 0.5 * fabs(h);
    double least = d->here.stopped * left < 0.0 ? leaving : shortest;
    if (step >= least * fmax(1.0, fabs(d->here.s)))
      continue;
    if ((result == OPEN || result == BENT) && leap_over(d, target, limit)) {
      step = crossing;
      continue;
    }
    if (result != OPEN || !turns_back(d, left)) {
      d->here.stopped = copysign(1.0, left);
      return result;
    }
    d->here.stopped = -copysign(1.0, left); /* the end lies the other way */
    step = d->here.largest;
  }
  d->here.largest = km_larger(step, km_drive_least_first);
  return ACCEPTED;
}

static km_reach drive_tree_joint(km_drive *d, double target) {
  const km_mechanism *m = d->c.mechanism;
  int c = d->c.coordinate;
  double factor = km_model_coordinate_factor(m->model, c), now = d->c.state->q[c], q = target * factor;
  km_reach reach = {KM_STOP_NONE, target, -1, -1};
  double slack = 1e-12 * (1.0 + fabs(q));
  double end = q > now ? fmax(m->high[c], now) : fmin(m->low[c], now);
  if (!d->c.ignore_limits && (q > now ? q > end + slack : q < end - slack)) {
    reach = (km_reach){KM_STOP_LIMIT, end / factor, -1, c};
    q = end;
  }
  d->c.state->q[c] = q;
  return reach;
}

/* The steps that ended at coordinate c's limit have found it to their own length; one or two more by its rate leave
 * nothing but rounding. */
static void settle_at_limit(km_drive *d, int c) {
  const km_mechanism *m = d->c.mechanism;
  int k = m->column_of[c], limit = -1;
  for (int round = 0; round < 2; ++round) {
    double q = d->c.state->q[c], bound = fabs(m->high[c] - q) < fabs(q - m->low[c]) ? m->high[c] : m->low[c];
    double gap = (bound - q) / m->unit[c] / d->c.course.t[k];
    if (m->ball_of[c] >= 0 || gap == 0.0 || !(fabs(gap) < 1e-7) ||
        advance(d, gap, km_drive_tightness, &limit) != ACCEPTED)
      return;
  }
}

/* The goal, or the driver's own limit on the way to it. */
static double within_own_limit(const km_drive *d, double goal) {
  const km_mechanism *m = d->c.mechanism;
  int c = d->c.coordinate;
  double unit = m->unit[c], high = km_larger(m->high[c] / unit, d->here.s),
         low = km_smaller(m->low[c] / unit, d->here.s);
  double slack = km_drive_slack(goal);
  return d->c.ignore_limits || (goal <= high + slack && goal >= low - slack) ? goal : goal > high ? high : low;
}

/* Is the goal the end itself? Then the pose there, which Newton approaches only slowly, is as good as any. */
static bool touches(km_drive *d, double goal) {
  const km_substructure *sub = km_drive_driven(d);
  if (!(fabs(d->here.s - goal) <= 1e-9))
    return false;
  km_closure evidence;
  int worst;
  km_state_save(d->c.state, sub, d->c.from);
  km_continuation_place(&d->c, goal);
  km_loops_close(d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &evidence);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_state_forget_pivots(d->c.state, d->c.substructure);
  if (km_loops_residual(d->c.mechanism, d->c.state, sub, &worst) <= between)
    return true;
  km_state_restore(d->c.state, sub, d->c.from);
  return false;
}

/* The slide that has come so far where the motion ends that it is what ends it: its distance and its rate have used up the digits
 * of the pivots. -1: there is none. */
static int far_slide(const km_drive *d) {
  static const double far = 100.0; /* substructure sizes */
  const km_substructure *sub = km_drive_driven(d);
  for (int k = 0; k < sub->columns; ++k)
    if (fabs(slid(d, k)) > far)
      return d->c.mechanism->column_coordinate[sub->column_start + k];
  return -1;
}

void km_drive_get_ready(km_drive *d, double target) {
  km_drive_settle(d);
  if (!d->here.known && within_own_limit(d, target * km_drive_factor(d)) != d->here.s)
    start(d);
}

void km_drive_begin(km_drive *d, double target) {
  km_drive_settle(d);
  double goal = within_own_limit(d, target * km_drive_factor(d)), left = goal - d->here.s, step = d->here.largest;
  int limit;
  if (fabs(left) <= step * km_drive_reach || !(d->here.known || start(d)))
    return;
  double h = copysign(step, left);
  if (advance(d, h, km_drive_tightness, &limit) != ACCEPTED)
    return;
  d->here.largest = fmax(lengthen(d, step, h), km_drive_least_first);
  km_drive_tell(d, d->here.s, d->c.course.t, 1);
}

km_reach km_drive_to(km_drive *d, double target) {
  if (!d || !isfinite(target))
    return (km_reach){KM_STOP_GAVE_OUT, nan(""), -1, -1};
  if (d->c.substructure < 0)
    return drive_tree_joint(d, target);
  km_drive_settle(d);
  const km_mechanism *m = d->c.mechanism;
  double factor = km_drive_factor(d), goal = target * factor, own = within_own_limit(d, goal);
  int limit = -1;
  attempt result = ACCEPTED;
  if (d->here.s != own) {
    bool ready = d->here.known || start(d);
    result = ready ? walk(d, own, &limit) : OPEN;
  }
  if (result == ACCEPTED || ((result == OPEN || result == BENT) && touches(d, own)))
    return own == goal ? (km_reach){KM_STOP_NONE, target, -1, -1}
                       : (km_reach){KM_STOP_LIMIT, own / factor, -1, d->c.coordinate};
  if (result == LIMITED)
    settle_at_limit(d, limit);
  /* What was tried last has left another pose's Jacobian behind. */
  km_loops_update(m, d->c.state, km_drive_driven(d));
  km_state_forget_pivots(d->c.state, d->c.substructure);
  if (result == EXHAUSTED)
    return (km_reach){KM_STOP_GAVE_OUT, d->here.s / factor, d->c.substructure, -1};
  if (result == LIMITED)
    return (km_reach){KM_STOP_LIMIT, d->here.s / factor, -1, limit};
  int slide = result == AWAY ? limit : far_slide(d);
  return (km_reach){slide >= 0 ? KM_STOP_AWAY : KM_STOP_TOGGLE, d->here.s / factor, d->c.substructure, slide};
}

void km_drive_rates(const km_drive *d, const double *t, int stride, double *rates) {
  const km_mechanism *m = d->c.mechanism;
  memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
  rates[d->c.coordinate] = 1.0;
  if (d->c.substructure < 0)
    return;
  const km_substructure *sub = km_drive_driven(d);
  double inverse = 1.0 / m->unit[d->c.coordinate];
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    rates[c] = t[k * stride] * m->unit[c] * inverse;
  }
}

void km_drive_tell(const km_drive *d, double s, const double *t, int stride) {
  if (!d->watch.stepped)
    return;
  km_drive_rates(d, t, stride, d->watch.rates);
  d->watch.stepped(d->watch.self, s / km_drive_factor(d), d->watch.rates);
}

void km_drive_expect_stiff(km_drive *d) {
  d->here.stiff = d->c.substructure >= 0;
}

bool km_drive_tangent(km_drive *d, double *rates) {
  if (!d || !rates)
    return false;
  if (km_drive_rides(d)) {
    km_drive_ridden_rates(d, rates);
    return true;
  }
  km_drive_settle(d);
  if (d->c.substructure >= 0 && !d->here.known && !start(d))
    return false;
  km_drive_rates(d, d->c.course.t, 1, rates);
  return true;
}

int km_drive_crossings(const km_drive *d) {
  if (!d)
    return 0;
  return d->here.crossings;
}
