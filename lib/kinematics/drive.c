/* Moving a driver: controlled steps to a target, ends, limits, and singular poses that are passed. */
#include "kinematics/drive.h"

#include "kinematics/closure.h"
#include "kinematics/curve.h"
#include "kinematics/loops.h"

#include <string.h>

/* Predictor-corrector in the driver s. Symbols: t = dq/ds (scaled, driver's entry 1), h the step in s. */

static const double furthest = 0.6;      /* that any coordinate may go in a step, scaled */
static const double shortest = 1e-11;    /* a step below this doesn't move: the end is located */
static const double leaving = 1e-14;     /* the same on the way back from a located end, where all is steep */
static const double singular = 1e-7;     /* last pivot, relative: closer to a singular pose the tangent is noise */
static const double branch_width = 1e-5; /* a change of sign that stays below this step is a branch point */
static const double crossing = 1e-3;     /* distance from a singular pose at which it is crossed */
static const double between = 1e-12;     /* residual that shows the pose between two regular ones to be on the branch */

typedef enum attempt { ACCEPTED, OPEN, BENT, LIMITED, EXHAUSTED } attempt;

static const double easy = 0.05; /* strain: a step twice as long has 16 times the error over its length */

enum { MOST_STEPS = 200000 }; /* towards one target */

/* t from the partition of the present pose; false at a toggle of the driver. */
static bool tangent(km_drive *d, double *t) {
  const km_partition *p = &d->state->partition[d->substructure];
  if (p->forced_dependent)
    return false;
  km_partition_direction(p, d->column, t);
  km_least_step(d->mechanism, d->state, d->substructure, d->column, t);
  return true;
}

static void remember_pivots(km_drive *d) {
  km_partition_copy_pivots(&d->here.reference, &d->state->partition[d->substructure]);
}

/* Pivots and tangent of the present pose, searched. */
static bool start(km_drive *d) {
  const km_substructure *sub = km_drive_driven(d);
  int worst;
  km_loops_update(d->mechanism, d->state, sub);
  double residual = km_loops_residual(d->mechanism, d->state, sub, &worst);
  km_pivot(d->mechanism, d->state, d->substructure, d->column, km_rank_tolerance(d->mechanism, sub, residual));
  d->here.known = tangent(d, d->here.t);
  remember_pivots(d);
  d->here.last_h = 0.0;
  return d->here.known;
}

static double dot(const km_drive *d, const double *a, const double *b) {
  return km_step_dot(d->mechanism, km_drive_driven(d), a, b);
}

/* Where the driver has the only freedom, det of the pivot block changes sign only at a singular pose of the
 * driver: a change over a step that should be regular is a jump to another branch. */
static bool sign_changed(km_drive *d) {
  const km_partition *p = &d->state->partition[d->substructure];
  if (km_partition_freedom(p) != 1 || p->rank != d->here.reference.rank)
    return false;
  if (p->searches == d->here.reference.searches)
    return p->sign != d->here.reference.sign;
  int before = d->here.reference.sign;
  km_partition_refactor(&d->here.reference, km_state_jacobian(d->state, km_drive_driven(d)));
  int after = d->here.reference.sign;
  d->here.reference.sign = before;
  return before != after;
}

static bool is_alone(const km_drive *d) {
  return km_partition_freedom(&d->here.reference) <= 1;
}

/* Where the driver has the only freedom Newton decides everything, and the cubic through the last two poses and their
 * tangents, continued by h, is a start; without a last pose the tangent. Where other freedoms are left the prediction
 * decides what they do: the path of least motion. False if h is too long for it. */
static bool predict(km_drive *d, double h, double *move) {
  int columns = km_drive_driven(d)->columns;
  d->strain = 0.0;
  if (!is_alone(d)) {
    d->strain = km_least_path_predict(&d->path, d->mechanism, d->state, d->substructure, d->column, &d->here.reference,
                                      d->saved, d->here.t, h, move);
    km_state_restore(d->state, km_drive_driven(d), d->saved);
  } else if (fabs(h) <= 4.0 * fabs(d->here.last_h)) { /* further out the last step says nothing */
    km_curve_ahead(columns, d->here.last_h, d->here.last_move, d->here.last_t, d->here.t, h, move);
  } else {
    for (int k = 0; k < columns; ++k)
      move[k] = h * d->here.t[k];
  }
  return d->strain <= 1.0;
}

static void place_driver(km_drive *d, double s) {
  d->state->q[d->coordinate] = s * d->mechanism->unit[d->coordinate];
}

/* One predictor and its correction to s + h; the state is left where it ended. */
static attempt correct(km_drive *d, double h, double tightness, double *next_t) {
  const km_substructure *sub = km_drive_driven(d);
  km_closure evidence;
  double predicted = km_step_length(d->mechanism, sub, d->move);
  for (int k = 0; k < sub->columns; ++k)
    if (!(fabs(d->move[k]) <= furthest))
      return BENT;
  km_state_move(d->mechanism, d->state, sub, d->move);
  place_driver(d, d->here.s + h);
  if (km_loops_close(d->mechanism, d->state, d->substructure, d->column, &evidence) != KM_CLOSED || !tangent(d, next_t))
    return OPEN;
  const km_partition *p = &d->state->partition[d->substructure];
  if (p->rank < d->here.reference.rank || p->last_pivot < singular * p->scale)
    return OPEN; /* a singular pose has no tangent of its own */
  if (evidence.correction > tightness * predicted + 1e-9)
    return BENT;
  double along = dot(d, d->here.t, next_t);
  double cosine = along / sqrt(dot(d, d->here.t, d->here.t) * dot(d, next_t, next_t));
  if (!(cosine >= 1.0 - tightness * 0.4))
    return BENT;
  bool changed = !d->passing && sign_changed(d);
  if (changed && fabs(h) > branch_width)
    return BENT;
  d->here.crossings += changed;
  return ACCEPTED;
}

static void accept(km_drive *d, double h) {
  double *swap = d->here.last_t;
  km_state_difference(d->state, km_drive_driven(d), d->saved, d->here.last_move);
  d->here.last_t = d->here.t;
  d->here.t = d->next_t;
  d->next_t = swap;
  d->here.last_h = h;
  d->here.s += h;
  d->here.known = true;
  remember_pivots(d);
}

/* Tries to advance by h. Restores the pose if refused. */
static attempt advance(km_drive *d, double h, double tightness, int *limit) {
  const km_substructure *sub = km_drive_driven(d);
  km_state_save(d->state, sub, d->saved);
  attempt result = predict(d, h, d->move) ? correct(d, h, tightness, d->next_t) : BENT;
  if (result == ACCEPTED) {
    int passed = d->ignore_limits ? -1 : km_state_limit_passed(d->state, sub, d->saved);
    if (passed < 0 && !d->ignore_limits)
      passed = km_state_limit_touched(d->state, sub, d->saved, d->here.t, d->next_t, h);
    if (passed < 0) {
      accept(d, h);
      return ACCEPTED;
    }
    *limit = passed;
    result = LIMITED;
  }
  km_state_restore(d->state, sub, d->saved);
  km_state_forget_pivots(d->state, d->substructure);
  return result;
}

/* Passes a singular pose at `target` along the smooth branch: the pose between two regular ones on either
 * side, by the cubic through both. Near it Newton finds no more than half the digits. */
static bool cross(km_drive *d, double target, int *limit) {
  const km_substructure *sub = km_drive_driven(d);
  double side = target > d->here.s ? 1.0 : -1.0;
  double gap = target - side * crossing - d->here.s;
  if (gap != 0.0 && advance(d, gap, 0.25, limit) != ACCEPTED)
    return false;
  double h = target + side * crossing - d->here.s, near = target - d->here.s;
  km_state_save(d->state, sub, d->near);
  d->passing = true;
  attempt beyond = advance(d, h, 0.05, limit);
  d->passing = false;
  if (beyond != ACCEPTED)
    return false;
  /* accept() has moved the tangents and the move of this step to last_t, last_move. */
  km_state_save(d->state, sub, d->far);
  km_state_restore(d->state, sub, d->near);
  km_curve_between(sub->columns, h, d->here.last_move, d->here.last_t, d->here.t, near, d->move, d->next_t);
  km_state_move(d->mechanism, d->state, sub, d->move);
  place_driver(d, target);
  km_loops_update(d->mechanism, d->state, sub);
  km_state_forget_pivots(d->state, d->substructure);
  int worst;
  if (km_loops_residual(d->mechanism, d->state, sub, &worst) > between) {
    km_state_restore(d->state, sub, d->far); /* a regular pose, if on the other side */
    return false;
  }
  memcpy(d->here.t, d->next_t, (size_t)sub->columns * sizeof *d->here.t);
  d->here.crossings++;
  d->here.s = target;
  d->here.last_h = 0.0;
  return true;
}

/* Advances to `target` by controlled steps; the step that arrives sets the driver exactly. */
static attempt walk(km_drive *d, double target, int *limit) {
  double step = d->here.largest;
  bool may_cross = true;
  for (int steps = 0; d->here.s != target; ++steps) {
    if (steps == MOST_STEPS)
      return EXHAUSTED;
    double left = target - d->here.s;
    bool arrives = fabs(left) <= step;
    double h = arrives ? left : copysign(step, left);
    attempt result = advance(d, h, 0.25, limit);
    if (result == ACCEPTED) {
      if (fabs(h) > 1e-6)
        d->here.stopped = 0.0;
      if (arrives) { /* s + (target - s) may be the next number */
        d->here.s = target;
        place_driver(d, target);
      }
      if (d->strain * pow(step / fabs(h), 4.0) < easy)
        step = fmin(2.0 * step, km_drive_longest);
      continue;
    }
    if (result == OPEN && arrives && may_cross && cross(d, target, limit))
      continue;
    may_cross = may_cross && !arrives;
    step = 0.5 * fabs(h);
    double least = d->here.stopped * left < 0.0 ? leaving : shortest;
    if (step < least * fmax(1.0, fabs(d->here.s))) {
      d->here.stopped = copysign(1.0, left);
      return result;
    }
  }
  d->here.largest = fmax(step, 1e-3);
  return ACCEPTED;
}

static km_reach drive_tree_joint(km_drive *d, double target) {
  const km_mechanism *m = d->mechanism;
  int c = d->coordinate;
  double factor = km_model_coordinate_factor(m->model, c), now = d->state->q[c], q = target * factor;
  km_reach reach = {KM_STOP_NONE, target, -1, -1};
  double slack = 1e-12 * (1.0 + fabs(q));
  double end = q > now ? fmax(m->high[c], now) : fmin(m->low[c], now);
  if (!d->ignore_limits && (q > now ? q > end + slack : q < end - slack)) {
    reach = (km_reach){KM_STOP_LIMIT, end / factor, -1, c};
    q = end;
  }
  d->state->q[c] = q;
  return reach;
}

/* The steps that ended at coordinate c's limit have found it to their own length; one or two more by its rate leave
 * nothing but rounding. */
static void settle_at_limit(km_drive *d, int c) {
  const km_mechanism *m = d->mechanism;
  int k = m->column_of[c], limit = -1;
  for (int round = 0; round < 2; ++round) {
    double q = d->state->q[c], bound = fabs(m->high[c] - q) < fabs(q - m->low[c]) ? m->high[c] : m->low[c];
    double gap = (bound - q) / m->unit[c] / d->here.t[k];
    if (m->ball_of[c] >= 0 || gap == 0.0 || !(fabs(gap) < 1e-7) || advance(d, gap, 0.25, &limit) != ACCEPTED)
      return;
  }
}

/* The goal, or the driver's own limit on the way to it. */
static double within_own_limit(const km_drive *d, double goal) {
  const km_mechanism *m = d->mechanism;
  int c = d->coordinate;
  double unit = m->unit[c], high = fmax(m->high[c] / unit, d->here.s), low = fmin(m->low[c] / unit, d->here.s);
  double slack = 1e-12 * (1.0 + fabs(goal));
  return d->ignore_limits || (goal <= high + slack && goal >= low - slack) ? goal : goal > high ? high : low;
}

/* Is the goal the end itself? Then the pose there, which Newton approaches only slowly, is as good as any. */
static bool touches(km_drive *d, double goal) {
  const km_substructure *sub = km_drive_driven(d);
  if (!(fabs(d->here.s - goal) <= 1e-9))
    return false;
  km_closure evidence;
  int worst;
  km_state_save(d->state, sub, d->saved);
  place_driver(d, goal);
  km_loops_close(d->mechanism, d->state, d->substructure, d->column, &evidence);
  km_loops_update(d->mechanism, d->state, sub);
  km_state_forget_pivots(d->state, d->substructure);
  if (km_loops_residual(d->mechanism, d->state, sub, &worst) <= between)
    return true;
  km_state_restore(d->state, sub, d->saved);
  return false;
}

km_reach km_drive_to(km_drive *d, double target) {
  if (!d || !isfinite(target))
    return (km_reach){KM_STOP_GAVE_OUT, nan(""), -1, -1};
  if (d->substructure < 0)
    return drive_tree_joint(d, target);
  const km_mechanism *m = d->mechanism;
  double factor = km_model_coordinate_factor(m->model, d->coordinate) / m->unit[d->coordinate];
  double goal = target * factor, own = within_own_limit(d, goal);
  int limit = -1;
  attempt result = ACCEPTED;
  if (d->here.s != own) {
    bool ready = d->here.known || start(d);
    result = ready ? walk(d, own, &limit) : OPEN;
  }
  if (result == ACCEPTED || ((result == OPEN || result == BENT) && touches(d, own)))
    return own == goal ? (km_reach){KM_STOP_NONE, target, -1, -1}
                       : (km_reach){KM_STOP_LIMIT, own / factor, -1, d->coordinate};
  if (result == LIMITED)
    settle_at_limit(d, limit);
  /* What was tried last has left another pose's Jacobian behind. */
  km_loops_update(m, d->state, km_drive_driven(d));
  km_state_forget_pivots(d->state, d->substructure);
  if (result == EXHAUSTED)
    return (km_reach){KM_STOP_GAVE_OUT, d->here.s / factor, d->substructure, -1};
  if (result == LIMITED)
    return (km_reach){KM_STOP_LIMIT, d->here.s / factor, -1, limit};
  return (km_reach){KM_STOP_TOGGLE, d->here.s / factor, d->substructure, -1};
}

bool km_drive_tangent(km_drive *d, double *rates) {
  if (!d || !rates)
    return false;
  const km_mechanism *m = d->mechanism;
  memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
  rates[d->coordinate] = 1.0;
  if (d->substructure < 0)
    return true;
  if (!d->here.known && !start(d))
    return false;
  const km_substructure *sub = km_drive_driven(d);
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    rates[c] = d->here.t[k] * m->unit[c] / m->unit[d->coordinate];
  }
  return true;
}

int km_drive_crossings(const km_drive *d) {
  if (!d)
    return 0;
  return d->here.crossings;
}
