/* What functions n/d do at an end of the motion where the driver gives out. */
#include "sweep/event_search.h"

#include <math.h>
#include <string.h>

void km_event_keep_ending(km_event_search *scan) {
  size_t n = (size_t)scan->count, row = n * sizeof(double);
  km_ending *last = &scan->last, *first = &scan->first;
  memmove(last->s + 1, last->s, (KM_ENDING - 1) * sizeof *last->s);
  memmove(last->n + n, last->n, (KM_ENDING - 1) * row);
  memmove(last->d + n, last->d, (KM_ENDING - 1) * row);
  last->s[0] = scan->s[0];
  memcpy(last->n, scan->n[0], row);
  memcpy(last->d, scan->d[0], row);
  last->have += last->have < KM_ENDING;
  if (first->have == KM_ENDING)
    return;
  first->s[first->have] = scan->s[0];
  memcpy(first->n + (size_t)first->have * n, scan->n[0], row);
  memcpy(first->d + (size_t)first->have * n, scan->d[0], row);
  first->have++;
}

/* An end is located as well as this, relatively. */
static const double located = 5e-9;
/* A function that grows less over four times the way has no power of it that its digits tell. */
static const double least_growth = 1.2;

/* The way from a sample to the end, of which the next sample is four times as far away. */
static double way_from(const km_ending *ending, int k) {
  return fabs(ending->s[k + 1] - ending->s[k]) / 3.0;
}

/* What a function comes to at the end, from its values at once, twice and four times the root of the way to it: by the parabola, or
 * by a power of the way (Aitken), whichever leaves less. A path of least motion can come to its end by another power than the
 * root. */
static double left_at_end(double once, double twice, double four) {
  double parabola = (8.0 * once - 6.0 * twice + four) / 3.0;
  if (!(twice > least_growth * once && four > least_growth * twice))
    return parabola;
  double power = (once * four - twice * twice) / (once + four - 2.0 * twice);
  return fabs(power) < fabs(parabola) ? power : parabola;
}

/* Is what a function comes to no more than what comes of an end that isn't located exactly? From once to twice the root of the
 * way it has changed by what the root alone makes of it. `there`: its value at the end as it is located, where that counts. */
static bool comes_to_nothing(const double x[3], double there, double way, double end) {
  double sign = copysign(1.0, x[0]), once = sign * x[0], twice = sign * x[1], four = sign * x[2];
  double left = fmin(fabs(left_at_end(once, twice, four)), fabs(there)), change = twice - once;
  return four != 0.0 && left * left * way < change * change * located * (1.0 + fabs(end));
}

/* What function i = n/d does at the end, from the sample k on; false: nothing that is told. A zero and a pole show in the quotient
 * too: where both vanish, or nearly do, it tells whether one of them does so faster. Of several freedoms the pose at the end counts
 * too: the path of least motion to it can change from one power of the way to another between the samples. */
static bool tell_end(const km_ending *ending, int count, int k, int i, double end, bool several, km_event_kind *kind) {
  double n[3], d[3], quotient[3], inverse[3], way = way_from(ending, k);
  bool counts = several && ending->s[0] == end;
  double n_there = counts ? ending->n[i] : HUGE_VAL, d_there = counts ? ending->d[i] : HUGE_VAL;
  double there = counts ? n_there / d_there : HUGE_VAL, inverse_there = counts ? d_there / n_there : HUGE_VAL;
  for (int j = 0; j < 3; ++j) {
    n[j] = ending->n[(k + j) * count + i];
    d[j] = ending->d[(k + j) * count + i];
    quotient[j] = n[j] / d[j];
    inverse[j] = d[j] / n[j];
  }
  bool nil = comes_to_nothing(n, n_there, way, end), without = comes_to_nothing(d, d_there, way, end);
  bool zero = nil && comes_to_nothing(quotient, there, way, end);
  bool pole = without && comes_to_nothing(inverse, inverse_there, way, end);
  *kind = zero == pole ? KM_EVENT_UNDEFINED : pole ? KM_EVENT_POLE : KM_EVENT_ZERO;
  return zero || pole || (nil && without);
}

/* The first of three samples that come to the end by quarters of the way, so far from it that an end which isn't located exactly
 * changes the parabola by less than half of what it may. -1: none. */
static int nearest(const km_ending *ending, double end) {
  const double *s = ending->s;
  for (int k = 1; k + 2 < ending->have; ++k) {
    double way = way_from(ending, k);
    bool quarters = fabs(fabs(s[k + 2] - s[k + 1]) - 12.0 * way) < 0.01 * way;
    if (quarters && way > 4.0 * located * (1.0 + fabs(end)))
      return k;
  }
  return -1;
}

/* The sweep has left no such samples: by chance its last one before the end was too near to it. Takes them anew, on the way to
 * `inside`: 0, the first of them; −1: there aren't any. */
static int sample_anew(const km_event_search *scan, km_sweeper *r, km_ending *ending, double end, double inside) {
  size_t n = (size_t)scan->count;
  for (int k = 0; k < 3; ++k) {
    double way = 1e-6 * (1.0 + fabs(end)) * ldexp(1.0, 2 * k), s = end + copysign(way, inside - end);
    if (way > fabs(inside - end) || !km_event_search_visit(scan, r, s))
      return -1;
    ending->s[k] = s;
    memcpy(ending->n + (size_t)k * n, scan->probe_n, n * sizeof *ending->n);
    memcpy(ending->d + (size_t)k * n, scan->probe_d, n * sizeof *ending->d);
  }
  return 0;
}

/* What rounding has told of a function next to an end where it vanishes or has a pole. */
static void forget_end(km_events *events, int function, double s, double way) {
  size_t kept = 0;
  for (size_t i = 0; i < events->count; ++i) {
    const km_event *e = &events->items[i];
    bool extreme = e->kind == KM_EVENT_MINIMUM || e->kind == KM_EVENT_MAXIMUM;
    if (extreme || e->function != function || fabs(e->s - s) > way)
      events->items[kept++] = *e;
  }
  events->count = kept;
}

km_status km_event_at_end(km_event_search *scan, km_sweeper *r, double end, km_error *error) {
  const km_table *table = r->out->table;
  size_t rows = km_table_rows(table);
  if (rows < 2 || !scan->events)
    return KM_OK;
  bool away = km_table_row(table, 0)[1] == end;
  km_ending *ending = away ? &scan->first : &scan->last;
  int k = nearest(ending, end), count = scan->count;
  km_status status = KM_OK;
  if (k < 0 && r->out->freedom == 1) /* of several freedoms another way may lead back */
    k = sample_anew(scan, r, ending, end, km_table_row(table, away ? rows - 1 : 0)[1]);
  for (int i = 0; i < count && k >= 0 && !status; ++i) {
    km_event_kind kind;
    if (!tell_end(ending, count, k, i, end, r->out->freedom > 1, &kind))
      continue;
    forget_end(scan->events, i, end, fabs(ending->s[k] - end));
    status = km_events_add(scan->events, (km_event){kind, i, end, kind == KM_EVENT_POLE ? HUGE_VAL : 0.0}, error);
    /* Of several freedoms a way back from an end needn't be the one that led to it. */
    if (kind != KM_EVENT_POLE || status || scan->shown == end || r->out->freedom > 1)
      continue;
    status = km_event_search_add_row(scan, r, km_table_row(table, away ? 1 : rows - 2)[1], end, away, error);
    scan->shown = end;
  }
  r->mover.settle(r->mover.self);
  return status;
}
