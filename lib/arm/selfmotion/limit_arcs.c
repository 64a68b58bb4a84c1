/* Arcs of a self-motion curve within the joint limits. Crossings of limits are located as roots on the curve,
 * between turning points of the coordinate (docs/theory.md 12.8). */
#include "arm/ik/ik_branches.h"

#include "base/event_locator.h"

#include <stdlib.h>

/* Excess over the limits; for hinges with narrow limits, modulo full turns. */
double km_arm_limit_excess(const km_arm *a, int column, double q) {
  double half = 0.5 * (a->high[column] - a->low[column]);
  if (!km_arm_has_narrow_limits(a, column))
    return fmax(q - a->high[column], a->low[column] - q);
  double middle = a->low[column] + half;
  return fabs(km_arm_difference(a, column, middle, q)) - half;
}

typedef struct crossing {
  double u;
  int column, change; /* +1: leaves the limits, −1: enters them */
} crossing;

typedef struct crossings {
  const km_selfmotion_curve *curve;
  crossing *items;
  size_t capacity;
  int count;
  int round; /* present round of the closed curve; 0: the stored one */
  bool failed;
} crossings;

/* Range first … end − 1 of rounds of a closed curve, so wide that arcs between limits are complete. */
typedef struct rounds {
  int first, end;
} rounds;

static double span_of(const km_selfmotion_curve *c, int i) {
  return i == c->count - 1 ? c->length - c->u[i] : c->u[i + 1] - c->u[i];
}

static double limit_excess(const crossings *all, int round, int column, double q) {
  const km_selfmotion_curve *c = all->curve;
  return km_arm_limit_excess(c->arm, column, q + round * km_selfmotion_curve_turn(c, column));
}

static double limit_excess_at(const crossings *all, int i, double x, int column) {
  double q[KM_ARM_MAX_JOINTS];
  return km_selfmotion_curve_interpolate(all->curve, i, x, q, NULL) ? limit_excess(all, all->round, column, q[column])
                                                                    : 0.0;
}

static void add(crossings *all, int i, double x, int column, int change) {
  if (!km_reserve((void **)&all->items, &all->capacity, (size_t)all->count + 1, sizeof *all->items)) {
    all->failed = true;
    return;
  }
  const km_selfmotion_curve *c = all->curve;
  all->items[all->count++] = (crossing){all->round * c->length + c->u[i] + x * span_of(c, i), column, change};
}

/* One coordinate on step i of the curve, for root searches. */
typedef struct coordinate_on_step {
  const crossings *all;
  int i, column;
} coordinate_on_step;

static double limit_excess_of(double x, void *context) {
  const coordinate_on_step *on = context;
  return limit_excess_at(on->all, on->i, x, on->column);
}

/* Angle of a hinge past the position half a turn from the middle between its limits. */
static double angle_past_opposite(double x, void *context) {
  const coordinate_on_step *on = context;
  const km_arm *a = on->all->curve->arm;
  double q[KM_ARM_MAX_JOINTS], middle = 0.5 * (a->low[on->column] + a->high[on->column]);
  return km_selfmotion_curve_interpolate(on->all->curve, on->i, x, q, NULL)
             ? km_arm_difference(a, on->column, middle + M_PI, q[on->column])
             : (double)NAN;
}

static double slope_of(double x, void *context) {
  const coordinate_on_step *on = context;
  double q[KM_ARM_MAX_JOINTS], t[KM_ARM_MAX_JOINTS];
  return km_selfmotion_curve_interpolate(on->all->curve, on->i, x, q, t) ? t[on->column] : 0.0;
}

/* Locates the crossing of a limit between x0 and x1 of step i, where the coordinate is monotone. */
static void find_monotone_crossing(crossings *all, int i, double x0, double x1, double f0, double f1, int column) {
  coordinate_on_step on = {all, i, column};
  if ((f0 > 0.0) != (f1 > 0.0))
    add(all, i, km_locate_root(limit_excess_of, &on, x0, x1, f0, f1), column, f1 > 0.0 ? 1 : -1);
}

/* Finds x between x0 and x1 at which a hinge with narrow limits is half a turn from their middle; it is outside the
 * limits there, however small the excluded range. −1: none. */
static double find_opposite(const crossings *all, int i, double x0, double x1, int column) {
  coordinate_on_step on = {all, i, column};
  if (!km_arm_has_narrow_limits(all->curve->arm, column))
    return -1.0;
  double past0 = angle_past_opposite(x0, &on), past1 = angle_past_opposite(x1, &on);
  bool passes = past0 * past1 <= 0.0 && fabs(past0) < 0.5 * M_PI && fabs(past1) < 0.5 * M_PI;
  return passes ? km_locate_root(angle_past_opposite, &on, x0, x1, past0, past1) : -1.0;
}

/* Locates the crossings of limits on a monotone stretch, including an excluded range that is passed within the step. */
static void find_crossings(crossings *all, int i, double x0, double x1, double f0, double f1, int column) {
  double x = f0 <= 0.0 && f1 <= 0.0 ? find_opposite(all, i, x0, x1, column) : -1.0;
  if (x < 0.0) {
    find_monotone_crossing(all, i, x0, x1, f0, f1, column);
    return;
  }
  double f = limit_excess_at(all, i, x, column);
  find_monotone_crossing(all, i, x0, x, f0, f, column);
  find_monotone_crossing(all, i, x, x1, f, f1, column);
}

/* Locates all crossings of one coordinate on step i. The step is halved, so that two turning points on a step are
 * separated. */
static void find_step_crossings(crossings *all, int i, int column) {
  const km_selfmotion_curve *c = all->curve;
  const int n = c->arm->n;
  int next = i == c->count - 1 ? 0 : i + 1;
  coordinate_on_step on = {all, i, column};
  double x[3] = {0.0, 0.5, 1.0}, f[3], s[3];
  f[0] = limit_excess(all, all->round, column, c->q[i * n + column]);
  /* the end of a round equals the start of the next one to the bit, so rounding cannot separate them at a limit */
  f[2] = limit_excess(all, next ? all->round : all->round + 1, column, c->q[next * n + column]);
  /* a coordinate changes by at most the arc length */
  if (fabs(f[0]) > 1.01 * span_of(c, i) && (f[0] > 0.0) == (f[2] > 0.0))
    return;
  f[1] = limit_excess_at(all, i, 0.5, column);
  s[0] = c->t[i * n + column];
  s[1] = slope_of(0.5, &on);
  s[2] = c->t[next * n + column];
  for (int half = 0; half < 2; ++half) {
    if ((s[half] > 0.0) == (s[half + 1] > 0.0)) {
      find_crossings(all, i, x[half], x[half + 1], f[half], f[half + 1], column);
      continue;
    }
    double turn = km_locate_root(slope_of, &on, x[half], x[half + 1], s[half], s[half + 1]),
           f_turn = limit_excess_at(all, i, turn, column);
    find_crossings(all, i, x[half], turn, f[half], f_turn, column);
    find_crossings(all, i, turn, x[half + 1], f_turn, f[half + 1], column);
  }
}

static int compare_arc_length(const void *a, const void *b) {
  const crossing *x = a, *y = b;
  if (x->u != y->u)
    return x->u < y->u ? -1 : 1;
  return x->change - y->change;
}

/* Converts the sorted crossings to arcs on which no coordinate is outside its limits; `out` is the number outside at
 * the start. */
static int arcs_of_crossings(const crossings *all, const rounds *r, int out, km_arc_span *arcs) {
  const km_selfmotion_curve *c = all->curve;
  double start = c->u[0] + r->first * c->length, from = start;
  int count = 0, column = -1;
  for (int k = 0; k < all->count; ++k) {
    const crossing *x = &all->items[k];
    if (out == 0 && x->change > 0)
      arcs[count++] = (km_arc_span){from, x->u, {column, x->column}};
    out += x->change;
    if (out == 0) {
      from = x->u;
      column = x->column;
    }
  }
  double end = c->closed ? r->end * c->length : c->u[c->count - 1];
  if (out == 0)
    arcs[count++] = (km_arc_span){from, end, {column, -1}};
  if (c->closed && !km_selfmotion_curve_continues(c) && count > 1 && arcs[0].from == start &&
      arcs[count - 1].column[1] < 0) { /* both are one arc through the start */
    --count;
    arcs[0].from = arcs[count].from - c->length;
    arcs[0].column[0] = arcs[count].column[0];
  }
  return count;
}

static bool is_limited(const km_arm *a, int column) {
  return a->low[column] > -(double)INFINITY || a->high[column] < (double)INFINITY;
}

static bool hinge_continues(const km_selfmotion_curve *c, int column) {
  return is_limited(c->arm, column) && !km_arm_has_narrow_limits(c->arm, column) &&
         km_selfmotion_curve_turn(c, column) != 0.0;
}

bool km_selfmotion_curve_continues(const km_selfmotion_curve *c) {
  for (int k = 0; k < c->arm->n; ++k)
    if (hinge_continues(c, k))
      return true;
  return false;
}

/* Number of rounds in which a hinge with full turns stays within a limit at the distance `room`; 1 if there is no
 * limit. */
static int rounds_within(double room, double turn) {
  enum { MAX_ROUNDS = 200 };
  double count = floor(fmax(room, 0.0) / fabs(turn)) + 1.0;
  return count < (double)INFINITY ? (int)fmin(count, MAX_ROUNDS) : 1;
}

/* Rounds of a closed curve within the wide limits of all hinges that make full turns. */
static rounds rounds_of(const km_selfmotion_curve *c) {
  const km_arm *a = c->arm;
  int before = 0, after = 1;
  bool found = false;
  for (int k = 0; k < a->n; ++k) {
    double turn = km_selfmotion_curve_turn(c, k), least = c->q[k], most = c->q[k];
    if (!hinge_continues(c, k))
      continue;
    for (int i = 1; i < c->count; ++i) {
      least = fmin(least, c->q[i * a->n + k]);
      most = fmax(most, c->q[i * a->n + k]);
    }
    int up = rounds_within(a->high[k] - least, turn), down = rounds_within(most - a->low[k], turn);
    int forward = turn > 0.0 ? up : down, back = turn > 0.0 ? down : up;
    after = found && after < forward ? after : forward;
    before = found && before < back ? before : back;
    found = true;
  }
  return (rounds){-before, after};
}

/* Locates all crossings of limits, sorts them and returns the arcs within the limits. */
km_arc_span *km_selfmotion_curve_arcs(const km_selfmotion_curve *c, int *count) {
  crossings all = {.curve = c};
  const rounds r = rounds_of(c);
  int out = 0;
  *count = -1;
  for (int k = 0; k < c->arm->n; ++k) {
    if (!is_limited(c->arm, k))
      continue;
    all.round = r.first;
    out += limit_excess(&all, r.first, k, c->q[k]) > 0.0;
    for (; all.round < r.end; ++all.round)
      for (int i = 0; i < (c->closed ? c->count : c->count - 1) && !all.failed; ++i)
        find_step_crossings(&all, i, k);
  }
  if (all.count)
    qsort(all.items, (size_t)all.count, sizeof *all.items, compare_arc_length);
  km_arc_span *arcs = all.failed ? NULL : KM_NEW(km_arc_span, (size_t)all.count + 1);
  if (arcs)
    *count = arcs_of_crossings(&all, &r, out, arcs);
  km_free(all.items);
  return arcs;
}
