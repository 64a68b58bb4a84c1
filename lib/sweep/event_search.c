/* Looks between the samples of a sweep for zeros, poles and extremes of functions n/d. */
#include "sweep/event_search.h"

#include "mobility/mobility_numbers.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <gsl/gsl_roots.h>
#include <string.h>

/* A pole is approached by halving the distance: to 2⁻¹⁶ of it. */
enum { MOST_ITERATIONS = 100, APPROACHES = 16 };

/* A function that changes less, relatively, is constant. */
static const double least_swing = 1e-9;
/* How near to each other the bounds of an extreme come, relatively: Brent's steps are at least √ε long, because a function
 * changes by no more than rounding over less. */
static const double nearest = 4.0 * GSL_SQRT_DBL_EPSILON;
/* What of a smooth function is left at its own root, or at one that it shares; of its values beside it. */
static const double left_over = 1e-7;

bool km_event_search_reserve(km_event_search *scan, int count) {
  size_t n = (size_t)count;
  scan->count = count;
  scan->shown = nan("");
  scan->probe_n = KM_NEW(double, 6 * n);
  scan->runs = KM_NEW(km_entry_range, n);
  scan->first.n = KM_NEW(double, 4 * KM_ENDING * n);
  if (!scan->probe_n || !scan->runs || !scan->first.n)
    return false;
  scan->first.d = scan->first.n + KM_ENDING * n;
  scan->last.n = scan->first.d + KM_ENDING * n;
  scan->last.d = scan->last.n + KM_ENDING * n;
  scan->probe_d = scan->probe_n + n;
  for (int i = 0; i < 2; ++i) {
    scan->n[i] = scan->probe_n + (size_t)(2 + i) * n;
    scan->d[i] = scan->probe_n + (size_t)(4 + i) * n;
  }
  return true;
}

void km_event_search_free(km_event_search *scan) {
  km_free(scan->probe_n);
  km_free(scan->runs);
  km_free(scan->first.n);
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

static void evaluate(const km_event_search *scan, km_sweeper *r, double *n, double *d) {
  if (r->substructure >= 0 && !r->rides)
    km_motions_update(r->m, r->s, r->substructure);
  for (int i = 0; i < scan->count; ++i)
    d[i] = 1.0;
  scan->values(scan->self, r, n, d);
}

bool km_event_search_visit(const km_event_search *scan, km_sweeper *r, double s) {
  r->rides = false; /* from here on the drive goes alone */
  if (!r->mover.probe(r->mover.self, s, r->rates))
    return false;
  evaluate(scan, r, scan->probe_n, scan->probe_d);
  return true;
}

typedef enum part { NUMERATOR, DENOMINATOR, QUOTIENT } part;

/* One function between two samples, as GSL sees it. */
typedef struct search {
  km_event_search *scan;
  km_sweeper *r;
  int function;
  part part;
  double sign;
  bool lost; /* a pose couldn't be reached, or has no value */
} search;

static double at(double s, void *context) {
  search *q = context;
  bool there = km_event_search_visit(q->scan, q->r, s);
  double n = q->scan->probe_n[q->function], d = q->scan->probe_d[q->function];
  double f = q->part == NUMERATOR ? n : q->part == DENOMINATOR ? d : n / d;
  q->lost = q->lost || !there || isnan(f);
  return q->lost ? (double)NAN : q->sign * f; /* NaN ends the search */
}

/* Between two places the part of function i changes its sign: where. False if it can't be told. The state is left at the root. */
static bool find_root(km_event_search *scan, km_sweeper *r, int i, part which, double from, double to, double *root) {
  search q = {scan, r, i, which, 1.0, false};
  gsl_function f = {at, &q};
  double low = fmin(from, to), high = fmax(from, to);
  *root = low;
  gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
  if (!solver)
    return false;
  bool found = gsl_root_fsolver_set(solver, &f, low, high) == GSL_SUCCESS;
  for (int k = 0; found && k < MOST_ITERATIONS && !q.lost; ++k) {
    found = gsl_root_fsolver_iterate(solver) == GSL_SUCCESS;
    *root = gsl_root_fsolver_root(solver);
    double left = gsl_root_fsolver_x_lower(solver), right = gsl_root_fsolver_x_upper(solver);
    if (right - left <= 1e-13 * (fabs(left) + fabs(right)) + 1e-15)
      break;
  }
  gsl_root_fsolver_free(solver);
  return found && !isnan(at(*root, &q));
}

/* Is so little of x left, where it was a and b beside? */
static bool vanishes(double x, double a, double b) {
  return fabs(x) <= left_over * fmax(fabs(a), fabs(b));
}

/* Function i has an extreme at s beyond 0, where the three samples about it are on one side: its zeros between them. */
static km_status find_zeros_about(km_event_search *scan, km_sweeper *r, int i, double s, km_error *error) {
  const km_entry_range *run = &scan->runs[i];
  km_status status = KM_OK;
  for (int side = 0; side < 3 && !status; side += 2) {
    double from = fabs(run->s[side] - s) > fabs(run->s[side] - run->s[1]) ? run->s[1] : run->s[side], root;
    if (find_root(scan, r, i, NUMERATOR, from, s, &root))
      status = km_events_add(scan->events, (km_event){KM_EVENT_ZERO, i, root, 0.0}, error);
  }
  return status;
}

/* The middle one of the last three samples of a run is the largest (sign -1: of -f, smallest) or smallest. */
static km_status find_extreme(km_event_search *scan, km_sweeper *r, int i, double sign, km_error *error) {
  const km_entry_range *run = &scan->runs[i];
  search q = {scan, r, i, QUOTIENT, sign, false};
  gsl_function f = {at, &q};
  double low = fmin(run->s[0], run->s[2]), high = fmax(run->s[0], run->s[2]);
  bool turned = run->s[0] > run->s[2];
  double f_low = sign * run->f[turned ? 2 : 0], f_high = sign * run->f[turned ? 0 : 2];
  gsl_min_fminimizer *solver = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  if (!solver)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  bool found = gsl_min_fminimizer_set_with_values(solver, &f, run->s[1], sign * run->f[1], low, f_low, high, f_high) ==
               GSL_SUCCESS;
  for (int k = 0; found && k < MOST_ITERATIONS && !q.lost; ++k) {
    found = gsl_min_fminimizer_iterate(solver) == GSL_SUCCESS;
    double left = gsl_min_fminimizer_x_lower(solver), right = gsl_min_fminimizer_x_upper(solver);
    if (right - left <= nearest * fmax(fabs(left), fabs(right)) + 1e-9 * (high - low))
      break;
  }
  double s = gsl_min_fminimizer_x_minimum(solver), value = sign * gsl_min_fminimizer_f_minimum(solver);
  gsl_min_fminimizer_free(solver);
  if (q.lost && !scan->best_counts)
    return KM_OK;
  /* A denominator that touches 0 without a change of sign. */
  bool flat = !q.lost && km_event_search_visit(scan, r, s) && vanishes(scan->probe_d[i], scan->d[0][i], scan->d[1][i]);
  bool pole = flat && !vanishes(scan->probe_n[i], scan->n[0][i], scan->n[1][i]);
  if (flat && !pole)
    return KM_OK; /* of two that vanish together the quotient is rounding */
  km_event_kind kind = pole ? KM_EVENT_POLE : sign > 0.0 ? KM_EVENT_MINIMUM : KM_EVENT_MAXIMUM;
  km_status status = km_events_add(scan->events, (km_event){kind, i, s, pole ? HUGE_VAL : value}, error);
  bool beyond = !pole && scan->ratios && value * run->f[1] < 0.0;
  return status || !beyond ? status : find_zeros_about(scan, r, i, s, error);
}

/* One more sample of a run. Of those that are alike, as two beside an extreme may be, the first one counts. */
static km_status take(km_event_search *scan, km_sweeper *r, int i, double s, double f, bool *moved, km_error *error) {
  km_entry_range *run = &scan->runs[i];
  if (run->have > 0 && fabs(f - run->f[0]) <= least_swing * (fabs(f) + fabs(run->f[0])))
    return KM_OK;
  memmove(run->s + 1, run->s, 2 * sizeof *run->s);
  memmove(run->f + 1, run->f, 2 * sizeof *run->f);
  run->s[0] = s;
  run->f[0] = f;
  run->have = run->have < 3 ? run->have + 1 : 3;
  if (run->have < 3 || !scan->extremes)
    return KM_OK;
  bool peak = run->f[1] > run->f[2] && run->f[1] > run->f[0], valley = run->f[1] < run->f[2] && run->f[1] < run->f[0];
  *moved = *moved || peak || valley;
  return peak || valley ? find_extreme(scan, r, i, peak ? -1.0 : 1.0, error) : KM_OK;
}

/* Place k of those between s and a pole, from the farthest to the nearest, or with `away` back again. */
static double place(double s, double pole, bool away, int k) {
  return pole + (s - pole) * ldexp(1.0, away ? k - APPROACHES : -1 - k);
}

/* The way from s to a pole, or away from it: function i takes its samples there, -1: none does, and `between` sees them. */
static km_status approach(km_event_search *scan, km_sweeper *r, int i, double s, double pole, bool away, bool seen,
                          km_error *error) {
  km_status status = KM_OK;
  bool moved = false, takes = scan->extremes && i >= 0, shows = scan->between && !seen;
  for (int k = 0; k < APPROACHES && (takes || shows) && !status; ++k) {
    double x = place(s, pole, away, k);
    if (!km_event_search_visit(scan, r, x))
      continue;
    if (shows && !scan->between(scan->self, r, x))
      return km_fail(error, KM_MEMORY, "out of memory for a sweep");
    if (takes && isfinite(scan->probe_n[i] / scan->probe_d[i]))
      status = take(scan, r, i, x, scan->probe_n[i] / scan->probe_d[i], &moved, error);
  }
  return status;
}

km_status km_event_search_add_row(km_event_search *scan, km_sweeper *r, double s, double pole, bool away,
                                  km_error *error) {
  return approach(scan, r, -1, s, pole, away, false, error);
}

/* Both sides of a pole between the last two samples, as far as they lie between them: a run ends there, another begins. */
static km_status pass_pole(km_event_search *scan, km_sweeper *r, int i, double pole, km_error *error) {
  km_status status = KM_OK;
  bool seen = pole == scan->shown;
  for (int away = 0; away < 2 && !status; ++away) {
    double s = scan->s[away ? 0 : 1];
    if (s == pole)
      continue;
    if (away)
      scan->runs[i].have = 0;
    status = approach(scan, r, i, s, pole, away, seen, error);
    if (!away)
      scan->runs[i].have = 0;
  }
  scan->shown = pole;
  return status;
}

/* The sample itself is a zero or a pole of function i. */
static km_status look_here(km_event_search *scan, int i, km_error *error) {
  double n = scan->n[0][i], d = scan->d[0][i];
  bool nil = n == 0.0 && !(scan->have > 1 && scan->n[1][i] == 0.0);
  bool pole = d == 0.0 && !(scan->have > 1 && scan->d[1][i] == 0.0);
  if (!nil && !pole)
    return KM_OK;
  km_event_kind kind = n == 0.0 && d == 0.0 ? KM_EVENT_UNDEFINED : pole ? KM_EVENT_POLE : KM_EVENT_ZERO;
  return km_events_add(scan->events, (km_event){kind, i, scan->s[0], pole ? HUGE_VAL : 0.0}, error);
}

/* Zeros and poles of function i between the last two samples; the pole's place, NaN if there is none. */
static km_status look_between(km_event_search *scan, km_sweeper *r, int i, double *pole, km_error *error) {
  const double *n[2] = {&scan->n[0][i], &scan->n[1][i]}, *d[2] = {&scan->d[0][i], &scan->d[1][i]};
  km_status status = KM_OK;
  bool undefined = false;
  double root;
  if (*d[0] * *d[1] < 0.0 && find_root(scan, r, i, DENOMINATOR, scan->s[0], scan->s[1], &root) &&
      vanishes(scan->probe_d[i], *d[0], *d[1])) {
    undefined = vanishes(scan->probe_n[i], *n[0], *n[1]);
    *pole = undefined ? *pole : root; /* of two that vanish together the quotient goes on, and is rounding close by */
    status = km_events_add(
        scan->events, (km_event){undefined ? KM_EVENT_UNDEFINED : KM_EVENT_POLE, i, root, undefined ? 0.0 : HUGE_VAL},
        error);
  }
  if (*n[0] * *n[1] < 0.0 && !status && !undefined && find_root(scan, r, i, NUMERATOR, scan->s[0], scan->s[1], &root) &&
      vanishes(scan->probe_n[i], *n[0], *n[1]))
    status = km_events_add(scan->events, (km_event){KM_EVENT_ZERO, i, root, 0.0}, error);
  return status;
}

static km_status look(km_event_search *scan, km_sweeper *r, int i, bool *moved, km_error *error) {
  bool before = scan->have > 1 && isfinite(scan->n[1][i]) && isfinite(scan->d[1][i]);
  double n = scan->n[0][i], d = scan->d[0][i], pole = nan("");
  if (!isfinite(n) || !isfinite(d)) {
    scan->runs[i].have = 0;
    return KM_OK;
  }
  if (!before)
    scan->runs[i].have = 0;
  km_status status = scan->ratios ? look_here(scan, i, error) : KM_OK;
  if (before && !status && scan->ratios) {
    status = look_between(scan, r, i, &pole, error);
    *moved = *moved || n * scan->n[1][i] < 0.0 || d * scan->d[1][i] < 0.0;
    if (d == 0.0 && scan->d[1][i] != 0.0)
      pole = scan->s[0];
    if (d != 0.0 && scan->d[1][i] == 0.0)
      pole = scan->s[1];
  }
  if (!isnan(pole) && !status) {
    *moved = true;
    status = pass_pole(scan, r, i, pole, error);
  }
  return status || d == 0.0 ? status : take(scan, r, i, scan->s[0], n / d, moved, error);
}

km_status km_event_search_sample(km_event_search *scan, km_sweeper *r, double s, km_error *error) {
  if (!scan->events)
    return KM_OK;
  if (scan->have > 1 && (s - scan->s[0]) * (scan->s[0] - scan->s[1]) <= 0.0)
    return KM_OK; /* the way to it has been seen */
  double *n = scan->n[1], *d = scan->d[1];
  scan->s[1] = scan->s[0];
  scan->n[1] = scan->n[0];
  scan->d[1] = scan->d[0];
  scan->s[0] = s;
  scan->n[0] = n;
  scan->d[0] = d;
  scan->have = scan->have < 2 ? scan->have + 1 : 2;
  gsl_set_error_handler_off();
  evaluate(scan, r, n, d);
  if (scan->sampled)
    scan->sampled(scan->self, r);
  km_event_keep_ending(scan);
  bool moved = false;
  km_status status = KM_OK;
  for (int i = 0; i < scan->count && !status; ++i)
    status = look(scan, r, i, &moved, error);
  if (moved) {
    r->mover.settle(r->mover.self);
    if (r->substructure >= 0)
      km_motions_update(r->m, r->s, r->substructure);
  }
  if (!status && r->mover.pass && !r->mover.pass(r->mover.self))
    status = km_fail(error, KM_MEMORY, "out of memory for a sweep");
  return status;
}
