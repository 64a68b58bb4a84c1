/* Full turns of hinges: angles moved into their limits, and all combinations of full turns that wide limits permit
 * (lifted branches in the covering space; docs/theory.md 12.8). */
#include "arm/ik/ik_branches.h"

#include <stdlib.h>
#include <string.h>

/* Shifts hinges by full turns to within half a turn of the middle of their limits. */
void km_arm_unwind(const km_arm *a, double *q) {
  for (int k = 0; k < a->n; ++k) {
    bool limited = a->high[k] - a->low[k] < (double)INFINITY;
    double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
    if (km_arm_is_hinge(a, k))
      q[k] = middle + km_arm_difference(a, k, middle, q[k]);
  }
}

bool km_arm_has_narrow_limits(const km_arm *a, int column) {
  return km_arm_is_hinge(a, column) && a->high[column] - a->low[column] < 2.0 * M_PI - 1e-9;
}

void km_arm_unwind_narrow(const km_arm *a, double *q) {
  double all[KM_ARM_MAX_JOINTS];
  memcpy(all, q, (size_t)a->n * sizeof *q);
  km_arm_unwind(a, all);
  for (int k = 0; k < a->n; ++k)
    if (km_arm_has_narrow_limits(a, k))
      q[k] = all[k];
}

static bool has_wide_limits(const km_arm *a, int column) {
  return km_arm_is_hinge(a, column) && !km_arm_has_narrow_limits(a, column) && a->low[column] > -(double)INFINITY &&
         a->high[column] < (double)INFINITY;
}

void km_arm_full_turn_range(const km_arm *a, int column, double min_sine, double most, int *first, int *last) {
  *first = *last = 0;
  if (!has_wide_limits(a, column))
    return;
  const double group_tolerance = 1e-12 * (1.0 + fabs(min_sine) + fabs(most));
  *first = (int)ceil((a->low[column] - most - group_tolerance) / (2.0 * M_PI));
  *last = (int)floor((a->high[column] - min_sine + group_tolerance) / (2.0 * M_PI));
}

/* Shifts hinges with wide limits by the full turns that are closest to near[n]. */
void km_arm_shift_to_nearest(const km_arm *a, const double *near, double *q) {
  for (int k = 0; k < a->n; ++k) {
    int first, last;
    double wanted = rint((near[k] - q[k]) / (2.0 * M_PI));
    km_arm_full_turn_range(a, k, q[k], q[k], &first, &last);
    if (has_wide_limits(a, k))
      wanted = fmin(fmax(wanted, first), last);
    if (km_arm_is_hinge(a, k) && !km_arm_has_narrow_limits(a, k))
      q[k] += 2.0 * M_PI * wanted;
  }
}

/* Enumeration of all shifts of hinges by full turns, each lifted curve once: if a hinge makes full turns along the
 * closed curve, shifts that differ by rounds of the curve are the same lifted curve. */
typedef struct lift_search {
  const km_selfmotion_curve *curve;
  km_lifted_arcs *out;
  int first[KM_ARM_MAX_JOINTS], last[KM_ARM_MAX_JOINTS]; /* range of each hinge's shift, in full turns */
  int shift[KM_ARM_MAX_JOINTS];
  double *shifted; /* [count × n] the curve's angles, shifted */
} lift_search;

static void extremes(const km_selfmotion_curve *c, int column, double *min_sine, double *most) {
  *min_sine = *most = c->q[column];
  for (int i = 1; i < c->count; ++i) {
    *min_sine = fmin(*min_sine, c->q[i * c->arm->n + column]);
    *most = fmax(*most, c->q[i * c->arm->n + column]);
  }
}

static int floor_divided(int a, int b) {
  int quotient = a / b;
  return a % b != 0 && (a < 0) != (b < 0) ? quotient - 1 : quotient;
}

/* Sets the ranges of shifts. If a hinge with wide limits makes `turns` full turns along the closed curve, its shifts
 * are restricted to 0 … |turns| − 1; the ranges of the other hinges are widened to all rounds. */
static void set_ranges(lift_search *l) {
  const km_selfmotion_curve *c = l->curve;
  const km_arm *a = c->arm;
  int round_hinge = -1, round_first = 0, round_last = 0;
  double min_sine, most;
  for (int k = 0; k < a->n; ++k) {
    extremes(c, k, &min_sine, &most);
    km_arm_full_turn_range(a, k, min_sine, most, &l->first[k], &l->last[k]);
    if (round_hinge < 0 && has_wide_limits(a, k) && km_selfmotion_curve_turn(c, k) != 0.0)
      round_hinge = k;
  }
  if (round_hinge < 0)
    return;
  int angles = (int)rint(km_selfmotion_curve_turn(c, round_hinge) / (2.0 * M_PI)), each = abs(angles);
  round_first = floor_divided(angles > 0 ? l->first[round_hinge] : -l->last[round_hinge], each);
  round_last = floor_divided(angles > 0 ? l->last[round_hinge] : -l->first[round_hinge], each);
  l->first[round_hinge] = 0;
  l->last[round_hinge] = each - 1;
  for (int k = 0; k < a->n; ++k) { /* after r rounds a hinge is shifted by r times its own turns */
    int own = (int)rint(km_selfmotion_curve_turn(c, k) / (2.0 * M_PI));
    if (k == round_hinge || !has_wide_limits(a, k))
      continue;
    int one = own * round_first, other = own * round_last;
    l->first[k] -= one > other ? one : other;
    l->last[k] -= one > other ? other : one;
  }
}

/* Appends arcs with their shifts and the full turns in their middles. */
static bool add_arcs(lift_search *l, const km_selfmotion_curve *at, const km_arc_span *arcs, int count) {
  const size_t n = (size_t)at->arm->n, size = (size_t)l->out->count + (size_t)count;
  km_lifted_arcs *out = l->out;
  km_arc_span *spans = km_resize(out->arcs, size + 1, sizeof *spans);
  out->arcs = spans ? spans : out->arcs;
  int *shift = km_resize(out->shift, (size + 1) * n, sizeof *shift);
  out->shift = shift ? shift : out->shift;
  int *turn = km_resize(out->turn, (size + 1) * n, sizeof *turn);
  out->turn = turn ? turn : out->turn;
  if (!spans || !shift || !turn)
    return false;
  for (int i = 0; i < count; ++i, ++out->count) {
    double q[KM_ARM_MAX_JOINTS] = {0};
    out->arcs[out->count] = arcs[i];
    km_selfmotion_curve_at(at, 0.5 * (arcs[i].from + arcs[i].to), q);
    for (size_t k = 0; k < n; ++k) {
      shift[(size_t)out->count * n + k] = l->shift[k];
      turn[(size_t)out->count * n + k] = has_wide_limits(at->arm, (int)k) ? (int)rint(q[k] / (2.0 * M_PI)) : 0;
    }
  }
  return true;
}

/* Computes and appends the arcs of the curve at the present shift. */
static bool add_shifted_arcs(lift_search *l) {
  km_selfmotion_curve at = *l->curve;
  at.q = l->shifted;
  for (int i = 0; i < at.count * at.arm->n; ++i)
    at.q[i] = l->curve->q[i] + 2.0 * M_PI * l->shift[i % at.arm->n];
  int count;
  km_arc_span *arcs = km_selfmotion_curve_arcs(&at, &count);
  bool is_ok = arcs && add_arcs(l, &at, arcs, count);
  km_free(arcs);
  return is_ok;
}

/* Advances to the next combination of shifts; false after the last. */
static bool next_shift(lift_search *l) {
  for (int k = 0; k < l->curve->arm->n; ++k) {
    if (l->shift[k] < l->last[k]) {
      l->shift[k]++;
      return true;
    }
    l->shift[k] = l->first[k];
  }
  return false;
}

/* Sort key of an arc. */
typedef struct arc_order {
  const int *turn;
  double from;
  int n, index;
} arc_order;

static int compare_turns(const void *a, const void *b) {
  const arc_order *x = a, *y = b;
  for (int k = 0; k < x->n; ++k)
    if (x->turn[k] != y->turn[k])
      return x->turn[k] < y->turn[k] ? -1 : 1;
  return x->from < y->from ? -1 : x->from > y->from ? 1 : x->index - y->index;
}

/* Sorts the arcs by turns, then by arc length. */
static bool sort_arcs(km_lifted_arcs *lifts, int n) {
  size_t count = (size_t)lifts->count, row = (size_t)n * sizeof *lifts->turn;
  arc_order *order = KM_NEW(arc_order, count + 1);
  km_lifted_arcs sorted = {lifts->count, KM_NEW(km_arc_span, count + 1), KM_NEW(int, (count + 1) * (size_t)n),
                           KM_NEW(int, (count + 1) * (size_t)n)};
  bool is_ok = order && sorted.arcs && sorted.shift && sorted.turn;
  for (int i = 0; i < lifts->count && is_ok; ++i)
    order[i] = (arc_order){lifts->turn + i * n, lifts->arcs[i].from, n, i};
  if (is_ok && count > 1)
    qsort(order, count, sizeof *order, compare_turns);
  for (int i = 0; i < lifts->count && is_ok; ++i) {
    int from = order[i].index;
    sorted.arcs[i] = lifts->arcs[from];
    memcpy(sorted.shift + i * n, lifts->shift + from * n, row);
    memcpy(sorted.turn + i * n, lifts->turn + from * n, row);
  }
  km_free(order);
  km_lifted_arcs *dropped = is_ok ? lifts : &sorted, old = *dropped;
  if (is_ok)
    *lifts = sorted;
  km_lifted_arcs_free(&old);
  return is_ok;
}

/* Enumerates all shifts by full turns and collects their arcs. */
bool km_selfmotion_curve_find_lifted_arcs(const km_selfmotion_curve *c, km_lifted_arcs *out) {
  enum { MAX_LIFTS = 20000 };
  lift_search l = {.curve = c, .out = out};
  *out = (km_lifted_arcs){0};
  l.shifted = KM_NEW(double, (size_t)(c->count * c->arm->n));
  if (!l.shifted)
    return false;
  if (c->arm->freedom == 1) /* if there are more spare freedoms, only the turn of the start is followed */
    set_ranges(&l);
  memcpy(l.shift, l.first, sizeof l.shift);
  bool is_ok = true, some = true;
  for (int k = 0; k < c->arm->n; ++k)
    some = some && l.first[k] <= l.last[k];
  for (int i = 0; is_ok && some && i < MAX_LIFTS; ++i) {
    is_ok = add_shifted_arcs(&l);
    some = next_shift(&l);
  }
  km_free(l.shifted);
  return is_ok && (out->count > 0 ? sort_arcs(out, c->arm->n) : add_arcs(&l, c, NULL, 0));
}

void km_lifted_arcs_free(km_lifted_arcs *lifts) {
  km_free(lifts->arcs);
  km_free(lifts->shift);
  km_free(lifts->turn);
  *lifts = (km_lifted_arcs){0};
}
