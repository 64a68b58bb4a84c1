/* Full turns of hinges: bringing angles within limits, and all the turns that limits leave room for. */
#include "arm/ik/ik_branches.h"

#include <stdlib.h>
#include <string.h>

void km_arm_unwind(const km_arm *a, double *q) {
  for (int k = 0; k < a->n; ++k) {
    bool limited = a->high[k] - a->low[k] < (double)INFINITY;
    double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
    if (km_arm_turns(a, k))
      q[k] = middle + km_arm_difference(a, k, middle, q[k]);
  }
}

bool km_arm_turns_once(const km_arm *a, int column) {
  return km_arm_turns(a, column) && a->high[column] - a->low[column] < 2.0 * M_PI - 1e-9;
}

void km_arm_bring_within(const km_arm *a, double *q) {
  double all[KM_ARM_MOST];
  memcpy(all, q, (size_t)a->n * sizeof *q);
  km_arm_unwind(a, all);
  for (int k = 0; k < a->n; ++k)
    if (km_arm_turns_once(a, k))
      q[k] = all[k];
}

static bool is_roomy(const km_arm *a, int column) {
  return km_arm_turns(a, column) && !km_arm_turns_once(a, column) && a->low[column] > -(double)INFINITY &&
         a->high[column] < (double)INFINITY;
}

void km_arm_turn_range(const km_arm *a, int column, double least, double most, int *first, int *last) {
  *first = *last = 0;
  if (!is_roomy(a, column))
    return;
  const double slack = 1e-12 * (1.0 + fabs(least) + fabs(most));
  *first = (int)ceil((a->low[column] - most - slack) / (2.0 * M_PI));
  *last = (int)floor((a->high[column] - least + slack) / (2.0 * M_PI));
}

void km_arm_turn_toward(const km_arm *a, const double *near, double *q) {
  for (int k = 0; k < a->n; ++k) {
    int first, last;
    double wanted = rint((near[k] - q[k]) / (2.0 * M_PI));
    km_arm_turn_range(a, k, q[k], q[k], &first, &last);
    if (is_roomy(a, k))
      wanted = fmin(fmax(wanted, first), last);
    if (km_arm_turns(a, k) && !km_arm_turns_once(a, k))
      q[k] += 2.0 * M_PI * wanted;
  }
}

/* All shifts by full turns, each counted once: where a hinge turns on round the curve, its rounds are the same curve.
 */
typedef struct lifting {
  const km_loop_curve *curve;
  km_lifts *out;
  int first[KM_ARM_MOST], last[KM_ARM_MOST]; /* of each hinge's shift */
  int shift[KM_ARM_MOST];
  double *shifted; /* [count × n] the curve's angles at a shift */
} lifting;

static void extremes(const km_loop_curve *c, int column, double *least, double *most) {
  *least = *most = c->q[column];
  for (int i = 1; i < c->count; ++i) {
    *least = fmin(*least, c->q[i * c->arm->n + column]);
    *most = fmax(*most, c->q[i * c->arm->n + column]);
  }
}

static int floor_divided(int a, int b) {
  int quotient = a / b;
  return a % b != 0 && (a < 0) != (b < 0) ? quotient - 1 : quotient;
}

/* The hinge that turns on counts the rounds: of its shifts one for each of the turns of a round are left, and the
 * others' are those of all its rounds. */
static void set_ranges(lifting *l) {
  const km_loop_curve *c = l->curve;
  const km_arm *a = c->arm;
  int counting = -1, round_first = 0, round_last = 0;
  double least, most;
  for (int k = 0; k < a->n; ++k) {
    extremes(c, k, &least, &most);
    km_arm_turn_range(a, k, least, most, &l->first[k], &l->last[k]);
    if (counting < 0 && is_roomy(a, k) && km_loop_curve_turn(c, k) != 0.0)
      counting = k;
  }
  if (counting < 0)
    return;
  int turns = (int)rint(km_loop_curve_turn(c, counting) / (2.0 * M_PI)), each = abs(turns);
  round_first = floor_divided(turns > 0 ? l->first[counting] : -l->last[counting], each);
  round_last = floor_divided(turns > 0 ? l->last[counting] : -l->first[counting], each);
  l->first[counting] = 0;
  l->last[counting] = each - 1;
  for (int k = 0; k < a->n; ++k) { /* at round r a hinge is ahead by r of its own turns */
    int own = (int)rint(km_loop_curve_turn(c, k) / (2.0 * M_PI));
    if (k == counting || !is_roomy(a, k))
      continue;
    int one = own * round_first, other = own * round_last;
    l->first[k] -= one > other ? one : other;
    l->last[k] -= one > other ? other : one;
  }
}

static bool add_arcs(lifting *l, const km_loop_curve *at, const km_arc_span *arcs, int count) {
  const size_t n = (size_t)at->arm->n, size = (size_t)l->out->count + (size_t)count;
  km_lifts *out = l->out;
  km_arc_span *spans = km_resize(out->arcs, size + 1, sizeof *spans);
  out->arcs = spans ? spans : out->arcs;
  int *shift = km_resize(out->shift, (size + 1) * n, sizeof *shift);
  out->shift = shift ? shift : out->shift;
  int *turn = km_resize(out->turn, (size + 1) * n, sizeof *turn);
  out->turn = turn ? turn : out->turn;
  if (!spans || !shift || !turn)
    return false;
  for (int i = 0; i < count; ++i, ++out->count) {
    double q[KM_ARM_MOST] = {0};
    out->arcs[out->count] = arcs[i];
    km_loop_curve_at(at, 0.5 * (arcs[i].from + arcs[i].to), q);
    for (size_t k = 0; k < n; ++k) {
      shift[(size_t)out->count * n + k] = l->shift[k];
      turn[(size_t)out->count * n + k] = is_roomy(at->arm, (int)k) ? (int)rint(q[k] / (2.0 * M_PI)) : 0;
    }
  }
  return true;
}

static bool lift(lifting *l) {
  km_loop_curve at = *l->curve;
  at.q = l->shifted;
  for (int i = 0; i < at.count * at.arm->n; ++i)
    at.q[i] = l->curve->q[i] + 2.0 * M_PI * l->shift[i % at.arm->n];
  int count;
  km_arc_span *arcs = km_loop_curve_arcs(&at, &count);
  bool whole = arcs && add_arcs(l, &at, arcs, count);
  km_free(arcs);
  return whole;
}

/* The next combination of shifts; false after the last. */
static bool advance(lifting *l) {
  for (int k = 0; k < l->curve->arm->n; ++k) {
    if (l->shift[k] < l->last[k]) {
      l->shift[k]++;
      return true;
    }
    l->shift[k] = l->first[k];
  }
  return false;
}

/* The order of an arc among all. */
typedef struct rank {
  const int *turn;
  double from;
  int n, index;
} rank;

static int by_turn(const void *a, const void *b) {
  const rank *x = a, *y = b;
  for (int k = 0; k < x->n; ++k)
    if (x->turn[k] != y->turn[k])
      return x->turn[k] < y->turn[k] ? -1 : 1;
  return x->from < y->from ? -1 : x->from > y->from ? 1 : x->index - y->index;
}

static bool sort(km_lifts *lifts, int n) {
  size_t count = (size_t)lifts->count, row = (size_t)n * sizeof *lifts->turn;
  rank *order = KM_NEW(rank, count + 1);
  km_lifts sorted = {lifts->count, KM_NEW(km_arc_span, count + 1), KM_NEW(int, (count + 1) * (size_t)n),
                     KM_NEW(int, (count + 1) * (size_t)n)};
  bool whole = order && sorted.arcs && sorted.shift && sorted.turn;
  for (int i = 0; i < lifts->count && whole; ++i)
    order[i] = (rank){lifts->turn + i * n, lifts->arcs[i].from, n, i};
  if (whole && count > 1)
    qsort(order, count, sizeof *order, by_turn);
  for (int i = 0; i < lifts->count && whole; ++i) {
    int from = order[i].index;
    sorted.arcs[i] = lifts->arcs[from];
    memcpy(sorted.shift + i * n, lifts->shift + from * n, row);
    memcpy(sorted.turn + i * n, lifts->turn + from * n, row);
  }
  km_free(order);
  km_lifts *dropped = whole ? lifts : &sorted, old = *dropped;
  if (whole)
    *lifts = sorted;
  km_lifts_free(&old);
  return whole;
}

bool km_loop_curve_lifts(const km_loop_curve *c, km_lifts *out) {
  enum { MOST_LIFTS = 20000 };
  lifting l = {.curve = c, .out = out};
  *out = (km_lifts){0};
  l.shifted = KM_NEW(double, (size_t)(c->count * c->arm->n));
  if (!l.shifted)
    return false;
  if (c->arm->freedom == 1) /* on a surface of poses only the turn of its start is followed */
    set_ranges(&l);
  memcpy(l.shift, l.first, sizeof l.shift);
  bool whole = true, some = true;
  for (int k = 0; k < c->arm->n; ++k)
    some = some && l.first[k] <= l.last[k];
  for (int i = 0; whole && some && i < MOST_LIFTS; ++i) {
    whole = lift(&l);
    some = advance(&l);
  }
  km_free(l.shifted);
  return whole && (out->count > 0 ? sort(out, c->arm->n) : add_arcs(&l, c, NULL, 0));
}

void km_lifts_free(km_lifts *lifts) {
  km_free(lifts->arcs);
  km_free(lifts->shift);
  km_free(lifts->turn);
  *lifts = (km_lifts){0};
}
