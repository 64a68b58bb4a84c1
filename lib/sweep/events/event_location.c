/* Events between samples of a sweep (theory 10.1): roots of n and d, extrema of f = n/d, dips of n.
 *
 *   dip: n_0, n_1, n_2 of one sign, and the minimum of the parabola through |n| is below half of the least of them;
 *        then the minimum of |n| is located: below 0 there are two zeros beside it, at 0 n touches 0 */
#include "sweep/events/event_location.h"
#include "base/number/tolerances.h"

#include <float.h>
#include <math.h>

/* Part of its neighbouring values to which a smooth function drops at its root. */
static const double root_remainder = 1e-7;

/* A function between two samples. */
typedef struct function_on_interval {
  km_event_search *search;
  km_sweeper *r;
  int function;
  km_event_part part;
  double sign;
} function_on_interval;

static double evaluate_at(double s, void *context) {
  const function_on_interval *q = context;
  if (!km_event_search_probe(q->search, q->r, s))
    return nan("");
  double n = q->search->probe_n[q->function], d = q->search->probe_d[q->function];
  return q->sign * (q->part == KM_NUMERATOR ? n : q->part == KM_DENOMINATOR ? d : n / d);
}

bool km_event_find_root(km_event_search *search, km_sweeper *r, int i, km_event_part part, double a, double b,
                        double fa, double fb, double *root) {
  function_on_interval q = {search, r, i, part, 1.0};
  *root = km_locate_root(evaluate_at, &q, a, b, fa, fb);
  return !isnan(evaluate_at(*root, &q));
}

bool km_event_vanishes(double x, double a, double b) {
  return fabs(x) <= root_remainder * fmax(fabs(a), fabs(b));
}

/* Finds the zeros beside an extremum at s whose sign is opposite to the three samples around it. */
static km_status find_zeros_beside_extremum(km_event_search *search, km_sweeper *r, int i, double s, double n_at_s,
                                            km_error *error) {
  const km_sample_run *run = &search->runs[i];
  km_status status = KM_OK;
  for (int side = 0; side < 3 && !status; side += 2) {
    double from = fabs(run->s[side] - s) > fabs(run->s[side] - run->s[1]) ? run->s[1] : run->s[side], root;
    function_on_interval q = {search, r, i, KM_NUMERATOR, 1.0};
    double n_from = evaluate_at(from, &q);
    if (n_from * n_at_s < 0.0 && km_event_find_root(search, r, i, KM_NUMERATOR, from, s, n_from, n_at_s, &root))
      status = km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, root, 0.0}, error);
  }
  return status;
}

/* Adds the extremum at s, or a pole where d touches 0; and zeros beside an extremum on the other side of 0. */
static km_status add_extremum(km_event_search *search, km_sweeper *r, int i, double sign, double s, double value,
                              km_error *error) {
  const int row = search->window.row, last = search->window.last;
  bool is_reached = km_event_search_probe(search, r, s);
  double n = search->probe_n[i], d = search->probe_d[i];
  /* a denominator that touches 0 without a sign change */
  bool denominator_vanishes =
      is_reached && last >= 0 &&
      km_event_vanishes(d, km_sampled_denominator(search, row, i), km_sampled_denominator(search, last, i));
  bool pole = denominator_vanishes &&
              !km_event_vanishes(n, km_sampled_numerator(search, row, i), km_sampled_numerator(search, last, i));
  if (denominator_vanishes && !pole)
    return KM_OK; /* n and d vanish together: their quotient is rounding */
  km_event_kind kind = pole ? KM_EVENT_POLE : sign > 0.0 ? KM_EVENT_MINIMUM : KM_EVENT_MAXIMUM;
  km_status status = km_events_add(search->events, (km_event){kind, i, s, pole ? HUGE_VAL : value}, error);
  bool crosses_zero = is_reached && !pole && search->ratios && value * search->runs[i].f[1] < 0.0;
  return status || !crosses_zero ? status : find_zeros_beside_extremum(search, r, i, s, n, error);
}

km_status km_event_find_extremum(km_event_search *search, km_sweeper *r, int i, double sign, km_error *error) {
  const km_sample_run *run = &search->runs[i];
  function_on_interval q = {search, r, i, KM_QUOTIENT, sign};
  int low = run->s[0] < run->s[2] ? 0 : 2, high = 2 - low;
  km_minimum_bracket b = {run->s[low],      sign * run->f[low], run->s[1],
                          sign * run->f[1], run->s[high],       sign * run->f[high]};
  /* within √ε of its extremum rounding alone changes a function */
  double width = 4.0 * sqrt(DBL_EPSILON) * fmax(fabs(b.low), fabs(b.high)) + 1e-9 * (b.high - b.low);
  if (!km_locate_minimum(evaluate_at, &q, width, -HUGE_VAL, &b) && !search->accepts_best_sample)
    return KM_OK;
  return add_extremum(search, r, i, sign, b.s, sign * b.f, error);
}

double km_event_lowest_point(const double s[3], const double n[3]) {
  const double f[3] = {fabs(n[0]), fabs(n[1]), fabs(n[2])};
  double first = (f[1] - f[0]) / (s[1] - s[0]), second = (f[2] - f[1]) / (s[2] - s[1]);
  double curvature = (second - first) / (s[2] - s[0]), slope = first + curvature * (s[1] - s[0]);
  double lowest = s[1] - 0.5 * slope / curvature, least = f[1] - 0.25 * slope * slope / curvature;
  bool shows_zero = n[0] * n[1] > 0.0 && n[1] * n[2] > 0.0 && curvature > 0.0 &&
                    (lowest - s[0]) * (lowest - s[2]) < 0.0 &&
                    least < km_batch_minimum_ratio * fmin(f[0], fmin(f[1], f[2]));
  return shows_zero ? lowest : (double)NAN;
}

/* Finds the bracket of the minimum, with the value at the lowest point; false if n has none there. */
static bool find_bracket(function_on_interval *q, const double *sample, const double *n, double lowest,
                         km_minimum_bracket *b) {
  double s[4] = {sample[0], sample[1], sample[2], lowest};
  double f[4] = {fabs(n[0]), fabs(n[1]), fabs(n[2]), evaluate_at(lowest, q)};
  for (int i = 1; i < 4; ++i) /* sorted by position */
    for (int k = i; k > 0 && s[k] < s[k - 1]; --k) {
      double position = s[k], value = f[k];
      s[k] = s[k - 1];
      f[k] = f[k - 1];
      s[k - 1] = position;
      f[k - 1] = value;
    }
  int i = f[2] < f[1] ? 2 : 1;
  *b = (km_minimum_bracket){s[i - 1], f[i - 1], s[i], f[i], s[i + 1], f[i + 1]};
  return b->f < b->f_low && b->f < b->f_high;
}

/* True if an event of function i between a and b is known. */
static bool is_known(const km_event_search *search, int i, double a, double b) {
  bool known = false;
  for (size_t k = search->events->count; k > 0 && !known; --k) {
    const km_event *e = &search->events->items[k - 1];
    known = e->function == i && (e->s - a) * (e->s - b) <= 0.0;
  }
  return known;
}

/* Adds the zeros of n in a dip. */
static km_status add_zeros_of_dip(km_event_search *search, km_sweeper *r, int i, const double *s, const double *n,
                                  double lowest, km_error *error) {
  function_on_interval q = {search, r, i, KM_NUMERATOR, n[1] < 0.0 ? -1.0 : 1.0};
  km_minimum_bracket b;
  if (!find_bracket(&q, s, n, lowest, &b))
    return KM_OK;
  km_locate_minimum(evaluate_at, &q, sqrt(km_solved_rounding) * (b.high - b.low), 0.0, &b);
  if (!(b.f < -search->zero))
    return b.f < search->zero ? km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, b.s, 0.0}, error) : KM_OK;
  double low = km_locate_root(evaluate_at, &q, b.low, b.s, b.f_low, b.f),
         high = km_locate_root(evaluate_at, &q, b.high, b.s, b.f_high, b.f);
  km_status status = km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, low, 0.0}, error);
  return status ? status : km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, high, 0.0}, error);
}

km_status km_event_find_dips(km_event_search *search, km_sweeper *r, int i, bool *is_moved, km_error *error) {
  const km_sample_window *w = &search->window;
  km_status status = KM_OK;
  for (int k = w->last > 0 ? w->last - 1 : 0; w->last >= 0 && k + 2 <= w->row && !status; ++k) {
    const double *s = w->s + k;
    double n[3], lowest;
    for (int j = 0; j < 3; ++j)
      n[j] = km_sampled_numerator(search, k + j, i);
    lowest = km_event_lowest_point(s, n);
    if (isnan(lowest) || is_known(search, i, s[0], s[2]))
      continue;
    *is_moved = true;
    status = add_zeros_of_dip(search, r, i, s, n, lowest, error);
  }
  return status;
}
