/* Events of f = n/d between the samples of a sweep (theory 10.1).
 *
 *   zero : root of n;   pole: root of d;   undefined: both      sign change, Brent's method, n or d drops to 1e-7
 *   extremum of f      : middle one of three samples            Brent's minimisation, to 4 sqrt(eps)
 *   near a pole        : 16 samples at halved distances, for extrema next to it and for pictures */
#include "sweep/zero_pole_search.h"

#include "mobility/mobility_numbers.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <gsl/gsl_roots.h>
#include <string.h>

/* Iterations of Brent's methods; samples towards a pole, the last one at 2⁻¹⁶ of the distance. */
enum { MAX_ITERATIONS = 100, POLE_SAMPLES = 16 };

/* Relative change below which a function counts as constant. */
static const double constant_change = 1e-9;
/* Relative distance of the bounds of an extremum: Brent's steps are at least √ε, since a function changes by rounding
 * only over less. */
static const double extremum_tolerance = 4.0 * GSL_SQRT_DBL_EPSILON;
/* Part of its neighbouring values to which a smooth function drops at its root. */
static const double root_remainder = 1e-7;

bool km_event_search_reserve(km_event_search *search, int count) {
  size_t n = (size_t)count;
  search->count = count;
  search->sampled_pole = nan("");
  search->probe_n = KM_NEW(double, 6 * n);
  search->runs = KM_NEW(km_sample_run, n);
  search->first.n = KM_NEW(double, 4 * KM_MAX_END_SAMPLES * n);
  if (!search->probe_n || !search->runs || !search->first.n)
    return false;
  search->first.d = search->first.n + KM_MAX_END_SAMPLES * n;
  search->last.n = search->first.d + KM_MAX_END_SAMPLES * n;
  search->last.d = search->last.n + KM_MAX_END_SAMPLES * n;
  search->probe_d = search->probe_n + n;
  for (int i = 0; i < 2; ++i) {
    search->n[i] = search->probe_n + (size_t)(2 + i) * n;
    search->d[i] = search->probe_n + (size_t)(4 + i) * n;
  }
  return true;
}

void km_event_search_free(km_event_search *search) {
  km_free(search->probe_n);
  km_free(search->runs);
  km_free(search->first.n);
}

km_status km_events_add(km_events *events, km_event event, km_error *error) {
  void *items = events->items;
  if (!km_reserve(&items, &events->capacity, events->count + 1, sizeof event))
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  events->items = items;
  events->items[events->count++] = event;
  return KM_OK;
}

void km_events_sort(km_events *events, const km_sweep_plan *plan) {
  bool backwards = plan->arclength <= 0.0 && plan->to < plan->from;
  km_event *e = events->items;
  for (size_t i = 1; i < events->count; ++i)
    for (size_t k = i; k > 0 && (backwards ? e[k].s > e[k - 1].s : e[k].s < e[k - 1].s); --k) {
      km_event swap = e[k];
      e[k] = e[k - 1];
      e[k - 1] = swap;
    }
}

static void evaluate(const km_event_search *search, km_sweeper *r, double *n, double *d) {
  if (r->substructure >= 0 && !r->is_batched)
    km_motions_update(r->m, r->s, r->substructure);
  for (int i = 0; i < search->count; ++i)
    d[i] = 1.0;
  search->values(search->self, r, n, d);
}

bool km_event_search_probe(const km_event_search *search, km_sweeper *r, double s) {
  r->is_batched = false; /* the motion is single from here on */
  if (!r->mover.probe(r->mover.self, s, r->rates))
    return false;
  evaluate(search, r, search->probe_n, search->probe_d);
  return true;
}

typedef enum event_part { NUMERATOR, DENOMINATOR, QUOTIENT } event_part;

/* A function between two samples, for GSL. */
typedef struct function_on_interval {
  km_event_search *search;
  km_sweeper *r;
  int function;
  event_part part;
  double sign;
  bool is_lost; /* a configuration was not reached, or has no value */
} function_on_interval;

static double evaluate_at(double s, void *context) {
  function_on_interval *q = context;
  bool is_reached = km_event_search_probe(q->search, q->r, s);
  double n = q->search->probe_n[q->function], d = q->search->probe_d[q->function];
  double f = q->part == NUMERATOR ? n : q->part == DENOMINATOR ? d : n / d;
  q->is_lost = q->is_lost || !is_reached || isnan(f);
  return q->is_lost ? (double)NAN : q->sign * f; /* NaN ends the search */
}

/* Finds the root of a part of function i between two positions with different signs; false if it is not found. The
 * state stays at the root. */
static bool find_root(km_event_search *search, km_sweeper *r, int i, event_part part, double from, double to,
                      double *root) {
  function_on_interval q = {search, r, i, part, 1.0, false};
  gsl_function f = {evaluate_at, &q};
  double low = fmin(from, to), high = fmax(from, to);
  *root = low;
  gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
  if (!solver)
    return false;
  bool found = gsl_root_fsolver_set(solver, &f, low, high) == GSL_SUCCESS;
  for (int k = 0; found && k < MAX_ITERATIONS && !q.is_lost; ++k) {
    found = gsl_root_fsolver_iterate(solver) == GSL_SUCCESS;
    *root = gsl_root_fsolver_root(solver);
    double left = gsl_root_fsolver_x_lower(solver), right = gsl_root_fsolver_x_upper(solver);
    if (right - left <= 1e-13 * (fabs(left) + fabs(right)) + 1e-15)
      break;
  }
  gsl_root_fsolver_free(solver);
  return found && !isnan(evaluate_at(*root, &q));
}

/* True if |x| is at most root_remainder of the neighbouring values a and b. */
static bool vanishes(double x, double a, double b) {
  return fabs(x) <= root_remainder * fmax(fabs(a), fabs(b));
}

/* Finds the zeros beside an extremum at s whose sign is opposite to the three samples around it. */
static km_status find_zeros_beside_extremum(km_event_search *search, km_sweeper *r, int i, double s, km_error *error) {
  const km_sample_run *run = &search->runs[i];
  km_status status = KM_OK;
  for (int side = 0; side < 3 && !status; side += 2) {
    double from = fabs(run->s[side] - s) > fabs(run->s[side] - run->s[1]) ? run->s[1] : run->s[side], root;
    if (find_root(search, r, i, NUMERATOR, from, s, &root))
      status = km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, root, 0.0}, error);
  }
  return status;
}

/* Finds an extremum bracketed by the last three samples of a run (sign 1: minimum, -1: maximum), or a pole where d
 * touches 0. */
static km_status find_extremum(km_event_search *search, km_sweeper *r, int i, double sign, km_error *error) {
  const km_sample_run *run = &search->runs[i];
  function_on_interval q = {search, r, i, QUOTIENT, sign, false};
  gsl_function f = {evaluate_at, &q};
  double low = fmin(run->s[0], run->s[2]), high = fmax(run->s[0], run->s[2]);
  bool is_reversed = run->s[0] > run->s[2];
  double f_low = sign * run->f[is_reversed ? 2 : 0], f_high = sign * run->f[is_reversed ? 0 : 2];
  gsl_min_fminimizer *solver = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  if (!solver)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  bool found = gsl_min_fminimizer_set_with_values(solver, &f, run->s[1], sign * run->f[1], low, f_low, high, f_high) ==
               GSL_SUCCESS;
  for (int k = 0; found && k < MAX_ITERATIONS && !q.is_lost; ++k) {
    found = gsl_min_fminimizer_iterate(solver) == GSL_SUCCESS;
    double left = gsl_min_fminimizer_x_lower(solver), right = gsl_min_fminimizer_x_upper(solver);
    if (right - left <= extremum_tolerance * fmax(fabs(left), fabs(right)) + 1e-9 * (high - low))
      break;
  }
  double s = gsl_min_fminimizer_x_minimum(solver), value = sign * gsl_min_fminimizer_f_minimum(solver);
  gsl_min_fminimizer_free(solver);
  if (q.is_lost && !search->accepts_best_sample)
    return KM_OK;
  /* a denominator that touches 0 without a sign change */
  bool denominator_vanishes = !q.is_lost && km_event_search_probe(search, r, s) &&
                              vanishes(search->probe_d[i], search->d[0][i], search->d[1][i]);
  bool pole = denominator_vanishes && !vanishes(search->probe_n[i], search->n[0][i], search->n[1][i]);
  if (denominator_vanishes && !pole)
    return KM_OK; /* n and d vanish together: their quotient is rounding */
  km_event_kind kind = pole ? KM_EVENT_POLE : sign > 0.0 ? KM_EVENT_MINIMUM : KM_EVENT_MAXIMUM;
  km_status status = km_events_add(search->events, (km_event){kind, i, s, pole ? HUGE_VAL : value}, error);
  bool crosses_zero = !pole && search->ratios && value * run->f[1] < 0.0;
  return status || !crosses_zero ? status : find_zeros_beside_extremum(search, r, i, s, error);
}

/* Adds a sample to a run and finds the extremum that it completes. The first of equal samples counts, as on both
 * sides of an extremum. */
static km_status add_run_sample(km_event_search *search, km_sweeper *r, int i, double s, double f, bool *is_moved,
                                km_error *error) {
  km_sample_run *run = &search->runs[i];
  if (run->have > 0 && fabs(f - run->f[0]) <= constant_change * (fabs(f) + fabs(run->f[0])))
    return KM_OK;
  memmove(run->s + 1, run->s, 2 * sizeof *run->s);
  memmove(run->f + 1, run->f, 2 * sizeof *run->f);
  run->s[0] = s;
  run->f[0] = f;
  run->have = run->have < 3 ? run->have + 1 : 3;
  if (run->have < 3 || !search->extremes)
    return KM_OK;
  bool peak = run->f[1] > run->f[2] && run->f[1] > run->f[0], valley = run->f[1] < run->f[2] && run->f[1] < run->f[0];
  *is_moved = *is_moved || peak || valley;
  return peak || valley ? find_extremum(search, r, i, peak ? -1.0 : 1.0, error) : KM_OK;
}

/* Returns sample position k between s and a pole, from the farthest to the nearest, or (away) in reverse. */
static double pole_sample(double s, double pole, bool away, int k) {
  return pole + (s - pole) * ldexp(1.0, away ? k - POLE_SAMPLES : -1 - k);
}

/* Samples from s to a pole, or away from it: into the run of function i (-1: none), and by `between`. */
static km_status sample_towards_pole(km_event_search *search, km_sweeper *r, int i, double s, double pole, bool away,
                                     bool is_sampled, km_error *error) {
  km_status status = KM_OK;
  bool is_moved = false, extends_run = search->extremes && i >= 0, calls_between = search->between && !is_sampled;
  for (int k = 0; k < POLE_SAMPLES && (extends_run || calls_between) && !status; ++k) {
    double x = pole_sample(s, pole, away, k);
    if (!km_event_search_probe(search, r, x))
      continue;
    if (calls_between && !search->between(search->self, r, x))
      return km_fail(error, KM_MEMORY, "out of memory for a sweep");
    if (extends_run && isfinite(search->probe_n[i] / search->probe_d[i]))
      status = add_run_sample(search, r, i, x, search->probe_n[i] / search->probe_d[i], &is_moved, error);
  }
  return status;
}

km_status km_event_search_approach_pole(km_event_search *search, km_sweeper *r, double s, double pole, bool away,
                                        km_error *error) {
  return sample_towards_pole(search, r, -1, s, pole, away, false, error);
}

/* Samples both sides of a pole between the last two samples; the run ends at the pole and a new one begins. */
static km_status sample_around_pole(km_event_search *search, km_sweeper *r, int i, double pole, km_error *error) {
  km_status status = KM_OK;
  bool is_sampled = pole == search->sampled_pole;
  for (int away = 0; away < 2 && !status; ++away) {
    double s = search->s[away ? 0 : 1];
    if (s == pole)
      continue;
    if (away)
      search->runs[i].have = 0;
    status = sample_towards_pole(search, r, i, s, pole, away, is_sampled, error);
    if (!away)
      search->runs[i].have = 0;
  }
  search->sampled_pole = pole;
  return status;
}

/* Adds the event of a sample that is itself a zero or a pole of function i. */
static km_status add_event_at_sample(km_event_search *search, int i, km_error *error) {
  double n = search->n[0][i], d = search->d[0][i];
  bool is_zero = n == 0.0 && !(search->have > 1 && search->n[1][i] == 0.0);
  bool pole = d == 0.0 && !(search->have > 1 && search->d[1][i] == 0.0);
  if (!is_zero && !pole)
    return KM_OK;
  km_event_kind kind = n == 0.0 && d == 0.0 ? KM_EVENT_UNDEFINED : pole ? KM_EVENT_POLE : KM_EVENT_ZERO;
  return km_events_add(search->events, (km_event){kind, i, search->s[0], pole ? HUGE_VAL : 0.0}, error);
}

/* Finds zeros and poles of function i between the last two samples; *pole: its position, NaN if there is none. */
static km_status find_events_between(km_event_search *search, km_sweeper *r, int i, double *pole, km_error *error) {
  const double *n[2] = {&search->n[0][i], &search->n[1][i]}, *d[2] = {&search->d[0][i], &search->d[1][i]};
  km_status status = KM_OK;
  bool undefined = false;
  double root;
  if (*d[0] * *d[1] < 0.0 && find_root(search, r, i, DENOMINATOR, search->s[0], search->s[1], &root) &&
      vanishes(search->probe_d[i], *d[0], *d[1])) {
    undefined = vanishes(search->probe_n[i], *n[0], *n[1]);
    *pole = undefined ? *pole : root; /* n and d vanish together: the quotient is continuous, and rounding nearby */
    status = km_events_add(
        search->events, (km_event){undefined ? KM_EVENT_UNDEFINED : KM_EVENT_POLE, i, root, undefined ? 0.0 : HUGE_VAL},
        error);
  }
  if (*n[0] * *n[1] < 0.0 && !status && !undefined &&
      find_root(search, r, i, NUMERATOR, search->s[0], search->s[1], &root) &&
      vanishes(search->probe_n[i], *n[0], *n[1]))
    status = km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, root, 0.0}, error);
  return status;
}

/* Finds the events of function i at the newest sample and since the one before. */
static km_status find_events(km_event_search *search, km_sweeper *r, int i, bool *is_moved, km_error *error) {
  bool has_previous = search->have > 1 && isfinite(search->n[1][i]) && isfinite(search->d[1][i]);
  double n = search->n[0][i], d = search->d[0][i], pole = nan("");
  if (!isfinite(n) || !isfinite(d)) {
    search->runs[i].have = 0;
    return KM_OK;
  }
  if (!has_previous)
    search->runs[i].have = 0;
  km_status status = search->ratios ? add_event_at_sample(search, i, error) : KM_OK;
  if (has_previous && !status && search->ratios) {
    status = find_events_between(search, r, i, &pole, error);
    *is_moved = *is_moved || n * search->n[1][i] < 0.0 || d * search->d[1][i] < 0.0;
    if (d == 0.0 && search->d[1][i] != 0.0)
      pole = search->s[0];
    if (d != 0.0 && search->d[1][i] == 0.0)
      pole = search->s[1];
  }
  if (!isnan(pole) && !status) {
    *is_moved = true;
    status = sample_around_pole(search, r, i, pole, error);
  }
  return status || d == 0.0 ? status : add_run_sample(search, r, i, search->s[0], n / d, is_moved, error);
}

km_status km_event_search_sample(km_event_search *search, km_sweeper *r, double s, km_error *error) {
  if (!search->events)
    return KM_OK;
  if (search->have > 1 && (s - search->s[0]) * (search->s[0] - search->s[1]) <= 0.0)
    return KM_OK; /* this interval was searched before */
  double *n = search->n[1], *d = search->d[1];
  search->s[1] = search->s[0];
  search->n[1] = search->n[0];
  search->d[1] = search->d[0];
  search->s[0] = s;
  search->n[0] = n;
  search->d[0] = d;
  search->have = search->have < 2 ? search->have + 1 : 2;
  gsl_set_error_handler_off();
  evaluate(search, r, n, d);
  if (search->sampled)
    search->sampled(search->self, r);
  km_event_record_end_sample(search);
  bool is_moved = false;
  km_status status = KM_OK;
  for (int i = 0; i < search->count && !status; ++i)
    status = find_events(search, r, i, &is_moved, error);
  if (is_moved) {
    r->mover.restore(r->mover.self);
    if (r->substructure >= 0)
      km_motions_update(r->m, r->s, r->substructure);
  }
  if (!status && r->mover.pass && !r->mover.pass(r->mover.self))
    status = km_fail(error, KM_MEMORY, "out of memory for a sweep");
  return status;
}
