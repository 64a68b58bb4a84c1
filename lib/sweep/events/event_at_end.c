/* Zeros and poles at an end of the motion, a turning point of the driver (theory 10.2).
 *
 *   x(s') = x_0 + c sqrt(s'), s' the driver's distance to its end; samples x_1, x_2, x_4 at s', 4 s', 16 s'
 *   x_0 = (8 x_1 - 6 x_2 + x_4) / 3  (parabola in sqrt(s')),  or  (x_1 x_4 - x_2^2) / (x_1 + x_4 - 2 x_2)  (Aitken)
 *   x vanishes at the end if |x_0| is below the change that an end located to 5e-9 explains */
#include "sweep/events/event_search.h"

#include <math.h>
#include <string.h>

void km_event_record_end_sample(km_event_search *search) {
  size_t n = (size_t)search->count, row = n * sizeof(double);
  km_end_samples *last = &search->last, *first = &search->first;
  memmove(last->s + 1, last->s, (KM_MAX_END_SAMPLES - 1) * sizeof *last->s);
  memmove(last->n + n, last->n, (KM_MAX_END_SAMPLES - 1) * row);
  memmove(last->d + n, last->d, (KM_MAX_END_SAMPLES - 1) * row);
  const km_sample_window *w = &search->window;
  const double *values = w->value + (size_t)w->row * w->width;
  last->s[0] = w->s[w->row];
  memcpy(last->n, values, row);
  memcpy(last->d, values + n, row);
  last->have += last->have < KM_MAX_END_SAMPLES;
  if (first->have == KM_MAX_END_SAMPLES)
    return;
  first->s[first->have] = w->s[w->row];
  memcpy(first->n + (size_t)first->have * n, values, row);
  memcpy(first->d + (size_t)first->have * n, values + n, row);
  first->have++;
}

/* Returns the distance of sample k to the end; the next sample is four times as far away. */
static double distance_to_end(const km_end_samples *ending, int k) {
  return fabs(ending->s[k + 1] - ending->s[k]) / 3.0;
}

/* Extrapolates a function to the end from its values at s', 4 s', 16 s': by the parabola or by a power of the
 * distance (Aitken), whichever leaves less. A path of least motion can reach its end with a power other than the
 * root. */
static double extrapolate_to_end(double x_1, double x_2, double x_4) {
  double parabola = (8.0 * x_1 - 6.0 * x_2 + x_4) / 3.0;
  if (!(x_2 > x_1 && x_4 > x_2))
    return parabola;
  double power = (x_1 * x_4 - x_2 * x_2) / (x_1 + x_4 - 2.0 * x_2);
  return fabs(power) < fabs(parabola) ? power : parabola;
}

/* True if the extrapolated value is within the error of an inexactly located end: between s' and 4 s' the function
 * changes by what the root of the distance makes of it. `value_at_end`: its value at the located end, where valid. */
static bool vanishes_at_end(const double x[3], double value_at_end, double distance, double end) {
  double sign = copysign(1.0, x[0]), x_1 = sign * x[0], x_2 = sign * x[1], x_4 = sign * x[2];
  double remainder = fmin(fabs(extrapolate_to_end(x_1, x_2, x_4)), fabs(value_at_end)), difference = x_2 - x_1;
  return x_4 != 0.0 &&
         remainder * remainder * distance < difference * difference * km_same_position * (1.0 + fabs(end));
}

/* Finds the event of function i = n/d at the end from sample k on; false: none. The quotient must vanish or diverge
 * too: if n and d both (nearly) vanish it decides which is faster. With several freedoms the value at the end itself
 * counts, since the path of least motion can change its power between samples. */
static bool find_event_at_end(const km_end_samples *ending, int count, int k, int i, double end, bool several_freedoms,
                              km_event_kind *kind) {
  double n[3], d[3], quotient[3], inverse[3], distance = distance_to_end(ending, k);
  bool has_end_value = several_freedoms && ending->s[0] == end;
  double n_at_end = has_end_value ? ending->n[i] : HUGE_VAL, d_at_end = has_end_value ? ending->d[i] : HUGE_VAL;
  double value_at_end = has_end_value ? n_at_end / d_at_end : HUGE_VAL,
         inverse_at_end = has_end_value ? d_at_end / n_at_end : HUGE_VAL;
  for (int j = 0; j < 3; ++j) {
    n[j] = ending->n[(k + j) * count + i];
    d[j] = ending->d[(k + j) * count + i];
    quotient[j] = n[j] / d[j];
    inverse[j] = d[j] / n[j];
  }
  bool n_vanishes = vanishes_at_end(n, n_at_end, distance, end),
       d_vanishes = vanishes_at_end(d, d_at_end, distance, end);
  bool is_zero = n_vanishes && vanishes_at_end(quotient, value_at_end, distance, end);
  bool is_pole = d_vanishes && vanishes_at_end(inverse, inverse_at_end, distance, end);
  *kind = is_zero == is_pole ? KM_EVENT_UNDEFINED : is_pole ? KM_EVENT_POLE : KM_EVENT_ZERO;
  return is_zero || is_pole || (n_vanishes && d_vanishes);
}

/* Returns the first of three samples at distances in ratio 1 : 4 : 16, so far from the end that its location error
 * changes the parabola by less than half the tolerance; -1: none. */
static int find_end_samples(const km_end_samples *ending, double end) {
  const double *s = ending->s;
  for (int k = 1; k + 2 < ending->have; ++k) {
    double distance = distance_to_end(ending, k);
    bool is_geometric = fabs(fabs(s[k + 2] - s[k + 1]) - 12.0 * distance) < 0.01 * distance;
    if (is_geometric && distance > 4.0 * km_same_position * (1.0 + fabs(end)))
      return k;
  }
  return -1;
}

/* Takes new samples at an end where the sweep left none in this ratio, towards `inside`: returns 0, the first of
 * them; −1: not reached. */
static int take_end_samples(km_event_search *search, km_sweeper *r, km_end_samples *ending, double end, double inside) {
  size_t n = (size_t)search->count;
  for (int k = 0; k < 3; ++k) {
    double distance = 1e-6 * (1.0 + fabs(end)) * ldexp(1.0, 2 * k), s = end + copysign(distance, inside - end);
    if (distance > fabs(inside - end) || !km_event_search_probe(search, r, s))
      return -1;
    ending->s[k] = s;
    memcpy(ending->n + (size_t)k * n, search->probe_n, n * sizeof *ending->n);
    memcpy(ending->d + (size_t)k * n, search->probe_d, n * sizeof *ending->d);
  }
  return 0;
}

/* Removes the events that rounding produced next to an end where the function vanishes or has a pole. */
static void remove_events_near_end(km_events *events, int function, double s, double distance) {
  size_t count = 0;
  for (size_t i = 0; i < events->count; ++i) {
    const km_event *e = &events->items[i];
    bool is_extremum = e->kind == KM_EVENT_MINIMUM || e->kind == KM_EVENT_MAXIMUM;
    if (is_extremum || e->function != function || fabs(e->s - s) > distance)
      events->items[count++] = *e;
  }
  events->count = count;
}

km_status km_event_at_end(km_event_search *search, km_sweeper *r, double end, km_error *error) {
  const km_table *table = r->out->table;
  size_t rows = km_table_rows(table);
  if (rows < 2 || !search->events)
    return KM_OK;
  bool is_start = km_table_row(table, 0)[1] == end;
  km_end_samples *ending = is_start ? &search->first : &search->last;
  int k = find_end_samples(ending, end), count = search->count;
  km_status status = KM_OK;
  if (k < 0 && r->out->freedom == 1) /* the return path can differ with several freedoms */
    k = take_end_samples(search, r, ending, end, km_table_row(table, is_start ? rows - 1 : 0)[1]);
  for (int i = 0; i < count && k >= 0 && !status; ++i) {
    km_event_kind kind;
    if (!find_event_at_end(ending, count, k, i, end, r->out->freedom > 1, &kind))
      continue;
    remove_events_near_end(search->events, i, end, fabs(ending->s[k] - end));
    status = km_events_add(search->events, (km_event){kind, i, end, kind == KM_EVENT_POLE ? HUGE_VAL : 0.0}, error);
    /* the return path can differ with several freedoms */
    if (kind != KM_EVENT_POLE || status || search->sampled_pole == end || r->out->freedom > 1)
      continue;
    status =
        km_event_search_approach_pole(search, r, km_table_row(table, is_start ? 1 : rows - 2)[1], end, is_start, error);
    search->sampled_pole = end;
  }
  r->mover.restore(r->mover.self);
  return status;
}
