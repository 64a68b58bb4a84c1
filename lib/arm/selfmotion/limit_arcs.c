/* Where a self-motion crosses joint limits: roots on the curve, never samples of it. */
#include "arm/ik/ik_branches.h"

#include <stdlib.h>

double km_arm_beyond(const km_arm *a, int column, double q) {
  double half = 0.5 * (a->high[column] - a->low[column]);
  if (!km_arm_turns_once(a, column))
    return fmax(q - a->high[column], a->low[column] - q);
  double middle = a->low[column] + half;
  return fabs(km_arm_difference(a, column, middle, q)) - half;
}

typedef struct crossing {
  double u;
  int column, change; /* +1: out of the limits, −1: in */
} crossing;

typedef struct crossings {
  const km_loop_curve *curve;
  crossing *items;
  size_t capacity;
  int count;
  int round; /* the one that is looked at; 0: the curve as it is */
  bool failed;
} crossings;

/* The rounds that are looked at, the last one excluded: of an arc that ends at a limit, all there are. */
typedef struct rounds {
  int first, end;
} rounds;

static double span_of(const km_loop_curve *c, int i) {
  return i == c->count - 1 ? c->length - c->u[i] : c->u[i + 1] - c->u[i];
}

static double beyond(const crossings *all, int round, int column, double q) {
  const km_loop_curve *c = all->curve;
  return km_arm_beyond(c->arm, column, q + round * km_loop_curve_turn(c, column));
}

static double beyond_at(const crossings *all, int i, double x, int column) {
  double q[KM_ARM_MOST];
  return km_loop_curve_between(all->curve, i, x, q, NULL) ? beyond(all, all->round, column, q[column]) : 0.0;
}

static void add(crossings *all, int i, double x, int column, int change) {
  if (!km_reserve((void **)&all->items, &all->capacity, (size_t)all->count + 1, sizeof *all->items)) {
    all->failed = true;
    return;
  }
  const km_loop_curve *c = all->curve;
  all->items[all->count++] = (crossing){all->round * c->length + c->u[i] + x * span_of(c, i), column, change};
}

/* Between x0 and x1 of step i the coordinate runs one way: at most one crossing. */
static void look_monotone(crossings *all, int i, double x0, double x1, double f0, double f1, int column) {
  if ((f0 > 0.0) == (f1 > 0.0))
    return;
  int change = f1 > 0.0 ? 1 : -1;
  for (int k = 0; k < 60 && x1 - x0 > 1e-13; ++k) {
    double x = x0 - f0 * (x1 - x0) / (f1 - f0);
    if (!(x > x0 && x < x1) || k % 4 == 3)
      x = 0.5 * (x0 + x1);
    double f = beyond_at(all, i, x, column);
    if ((f > 0.0) == (f1 > 0.0)) {
      x1 = x;
      f1 = f;
    } else {
      x0 = x;
      f0 = f;
    }
  }
  add(all, i, 0.5 * (x0 + x1), column, change);
}

/* Where a hinge that turns once is half a turn from the middle of its limits, between x0 and x1 if it is so there: then
 * it is outside, however little its limits leave out. -1: nowhere. */
static double opposite(const crossings *all, int i, double x0, double x1, int column) {
  const km_loop_curve *c = all->curve;
  const km_arm *a = c->arm;
  double q[KM_ARM_MOST], middle = 0.5 * (a->low[column] + a->high[column]);
  if (!km_arm_turns_once(a, column) || !km_loop_curve_between(c, i, x0, q, NULL))
    return -1.0;
  double side = km_arm_difference(a, column, middle, q[column]);
  if (fabs(side) < 0.5 * M_PI || !km_loop_curve_between(c, i, x1, q, NULL) ||
      side * km_arm_difference(a, column, middle, q[column]) > 0.0)
    return -1.0;
  for (int k = 0; k < 60 && x1 - x0 > 1e-13; ++k) {
    double x = 0.5 * (x0 + x1);
    if (!km_loop_curve_between(c, i, x, q, NULL))
      return -1.0;
    if (side * km_arm_difference(a, column, middle, q[column]) > 0.0)
      x0 = x;
    else
      x1 = x;
  }
  return 0.5 * (x0 + x1);
}

/* As look_monotone, but a gap between the limits that is crossed within the step counts too. */
static void look_between(crossings *all, int i, double x0, double x1, double f0, double f1, int column) {
  double x = f0 <= 0.0 && f1 <= 0.0 ? opposite(all, i, x0, x1, column) : -1.0;
  if (x < 0.0) {
    look_monotone(all, i, x0, x1, f0, f1, column);
    return;
  }
  double f = beyond_at(all, i, x, column);
  look_monotone(all, i, x0, x, f0, f, column);
  look_monotone(all, i, x, x1, f, f1, column);
}

static double slope_at(const km_loop_curve *c, int i, double x, int column) {
  double q[KM_ARM_MOST], t[KM_ARM_MOST];
  return km_loop_curve_between(c, i, x, q, t) ? t[column] : 0.0;
}

/* The turning point of the coordinate between x0 and x1, where its slope changes sign. */
static double turning_point(const km_loop_curve *c, int i, double x0, double x1, double s0, int column) {
  for (int k = 0; k < 50 && x1 - x0 > 1e-12; ++k) {
    double x = 0.5 * (x0 + x1), s = slope_at(c, i, x, column);
    if ((s > 0.0) == (s0 > 0.0))
      x0 = x;
    else
      x1 = x;
  }
  return 0.5 * (x0 + x1);
}

/* One coordinate over step i, halves apart: a coordinate that turns twice on a step shows it in the middle. */
static void look(crossings *all, int i, int column) {
  const km_loop_curve *c = all->curve;
  const int n = c->arm->n;
  int next = i == c->count - 1 ? 0 : i + 1;
  double x[3] = {0.0, 0.5, 1.0}, f[3], s[3];
  f[0] = beyond(all, all->round, column, c->q[i * n + column]);
  /* The end of a round is the start of the next one, to the bit: at a limit rounding must not tell them apart. */
  f[2] = beyond(all, next ? all->round : all->round + 1, column, c->q[next * n + column]);
  /* A coordinate changes by no more than the arc. */
  if (fabs(f[0]) > 1.01 * span_of(c, i) && (f[0] > 0.0) == (f[2] > 0.0))
    return;
  f[1] = beyond_at(all, i, 0.5, column);
  s[0] = c->t[i * n + column];
  s[1] = slope_at(c, i, 0.5, column);
  s[2] = c->t[next * n + column];
  for (int half = 0; half < 2; ++half) {
    if ((s[half] > 0.0) == (s[half + 1] > 0.0)) {
      look_between(all, i, x[half], x[half + 1], f[half], f[half + 1], column);
      continue;
    }
    double turn = turning_point(c, i, x[half], x[half + 1], s[half], column), f_turn = beyond_at(all, i, turn, column);
    look_between(all, i, x[half], turn, f[half], f_turn, column);
    look_between(all, i, turn, x[half + 1], f_turn, f[half + 1], column);
  }
}

static int by_u(const void *a, const void *b) {
  const crossing *x = a, *y = b;
  if (x->u != y->u)
    return x->u < y->u ? -1 : 1;
  return x->change - y->change;
}

/* From the crossings in order to the stretches between them where nothing is out of its limits. */
static int gather(const crossings *all, const rounds *r, int out, km_arc_span *arcs) {
  const km_loop_curve *c = all->curve;
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
  if (c->closed && !km_loop_curve_runs_on(c) && count > 1 && arcs[0].from == start &&
      arcs[count - 1].column[1] < 0) { /* one, through the start */
    --count;
    arcs[0].from = arcs[count].from - c->length;
    arcs[0].column[0] = arcs[count].column[0];
  }
  return count;
}

static bool is_limited(const km_arm *a, int column) {
  return a->low[column] > -(double)INFINITY || a->high[column] < (double)INFINITY;
}

static bool turns_on(const km_loop_curve *c, int column) {
  return is_limited(c->arm, column) && !km_arm_turns_once(c->arm, column) && km_loop_curve_turn(c, column) != 0.0;
}

bool km_loop_curve_runs_on(const km_loop_curve *c) {
  for (int k = 0; k < c->arm->n; ++k)
    if (turns_on(c, k))
      return true;
  return false;
}

/* How many rounds leave a hinge that turns on within its limit, `room` away at most; one if it never meets it. */
static int rounds_within(double room, double turn) {
  enum { MOST_ROUNDS = 200 };
  double count = floor(fmax(room, 0.0) / fabs(turn)) + 1.0;
  return count < (double)INFINITY ? (int)fmin(count, MOST_ROUNDS) : 1;
}

static rounds rounds_of(const km_loop_curve *c) {
  const km_arm *a = c->arm;
  int before = 0, after = 1;
  bool found = false;
  for (int k = 0; k < a->n; ++k) {
    double turn = km_loop_curve_turn(c, k), least = c->q[k], most = c->q[k];
    if (!turns_on(c, k))
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

km_arc_span *km_loop_curve_arcs(const km_loop_curve *c, int *count) {
  crossings all = {.curve = c};
  const rounds r = rounds_of(c);
  int out = 0;
  *count = -1;
  for (int k = 0; k < c->arm->n; ++k) {
    if (!is_limited(c->arm, k))
      continue;
    all.round = r.first;
    out += beyond(&all, r.first, k, c->q[k]) > 0.0;
    for (; all.round < r.end; ++all.round)
      for (int i = 0; i < (c->closed ? c->count : c->count - 1) && !all.failed; ++i)
        look(&all, i, k);
  }
  if (all.count)
    qsort(all.items, (size_t)all.count, sizeof *all.items, by_u);
  km_arc_span *arcs = all.failed ? NULL : KM_NEW(km_arc_span, (size_t)all.count + 1);
  if (arcs)
    *count = gather(&all, &r, out, arcs);
  km_free(all.items);
  return arcs;
}
