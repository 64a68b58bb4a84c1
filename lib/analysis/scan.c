#include "analysis/scan.h"

#include "analysis/mobility.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <gsl/gsl_roots.h>
#include <string.h>

enum { MOST_ITERATIONS = 100 };

/* A function that changes less, relatively, is constant. */
static const double least_swing = 1e-9;

/* A value that exceeds its neighbours' by so much is a pole. */
static const double unbounded = 1e5;

bool km_scan_reserve(km_scan *scan, int count) {
  size_t n = (size_t)count;
  scan->count = count;
  scan->probe = KM_NEW(double, 4 * n);
  for (int i = 0; i < 3 && scan->probe; ++i)
    scan->f[i] = scan->probe + (size_t)(i + 1) * n;
  return scan->probe != NULL;
}

void km_scan_free(km_scan *scan) {
  km_free(scan->probe);
}

/* One function between two samples, as GSL sees it. */
typedef struct search {
  km_scan *scan;
  km_sweeper *r;
  int function;
  double sign;
  bool lost; /* a pose couldn't be reached */
} search;

static double at(double s, void *context) {
  search *q = context;
  if (!q->r->mover.probe(q->r->mover.self, s, q->r->rates)) {
    q->lost = true;
    return (double)NAN; /* ends the search */
  }
  if (q->r->substructure >= 0)
    km_numbers_update(q->r->m, q->r->s, q->r->substructure);
  q->scan->values(q->scan->self, q->r, q->scan->probe);
  double f = q->sign * q->scan->probe[q->function];
  return isfinite(f) ? f : 0.0; /* without a value: as good a place as any to look at */
}

static km_status add(km_scan *scan, km_event event, km_error *error) {
  void *items = scan->events->items;
  if (!km_reserve(&items, &scan->events->capacity, scan->events->count + 1, sizeof event))
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  scan->events->items = items;
  scan->events->items[scan->events->count++] = event;
  return KM_OK;
}

/* Beside a pole the function is larger than at either end of the interval, beside a zero smaller. */
static bool is_pole(search *q, double root, double low, double high) {
  double most = 2.0 * fmax(fabs(q->scan->f[0][q->function]), fabs(q->scan->f[1][q->function]));
  double aside = 1e-4 * (high - low);
  return fabs(at(fmax(root - aside, low), q)) > most || fabs(at(fmin(root + aside, high), q)) > most;
}

/* Between the last two samples function i changes its sign: at a zero, or across a pole. */
static km_status find_zero(km_scan *scan, km_sweeper *r, int i, km_error *error) {
  search q = {scan, r, i, 1.0, false};
  gsl_function f = {at, &q};
  double low = fmin(scan->s[0], scan->s[1]), high = fmax(scan->s[0], scan->s[1]);
  gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
  if (!solver)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  double root = low;
  bool found = gsl_root_fsolver_set(solver, &f, low, high) == GSL_SUCCESS;
  for (int k = 0; found && k < MOST_ITERATIONS && !q.lost; ++k) {
    found = gsl_root_fsolver_iterate(solver) == GSL_SUCCESS;
    root = gsl_root_fsolver_root(solver);
    double left = gsl_root_fsolver_x_lower(solver), right = gsl_root_fsolver_x_upper(solver);
    if (right - left <= 1e-13 * (fabs(left) + fabs(right)) + 1e-15)
      break;
  }
  gsl_root_fsolver_free(solver);
  if (!found || q.lost)
    return KM_OK;
  bool pole = is_pole(&q, root, low, high);
  return q.lost ? KM_OK
                : add(scan, (km_event){pole ? KM_EVENT_POLE : KM_EVENT_ZERO, i, root, pole ? HUGE_VAL : 0.0}, error);
}

/* The middle one of the last three samples is the largest (sign -1: of -f, smallest) or smallest. */
static km_status find_extreme(km_scan *scan, km_sweeper *r, int i, double sign, km_error *error) {
  search q = {scan, r, i, sign, false};
  gsl_function f = {at, &q};
  double low = fmin(scan->s[0], scan->s[2]), high = fmax(scan->s[0], scan->s[2]);
  bool turned = scan->s[0] > scan->s[2];
  double f_low = sign * scan->f[turned ? 2 : 0][i], f_high = sign * scan->f[turned ? 0 : 2][i];
  gsl_min_fminimizer *solver = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  if (!solver)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  bool found = gsl_min_fminimizer_set_with_values(solver, &f, scan->s[1], sign * scan->f[1][i], low, f_low, high,
                                                  f_high) == GSL_SUCCESS;
  for (int k = 0; found && k < MOST_ITERATIONS && !q.lost; ++k) {
    found = gsl_min_fminimizer_iterate(solver) == GSL_SUCCESS;
    double left = gsl_min_fminimizer_x_lower(solver), right = gsl_min_fminimizer_x_upper(solver);
    if (right - left <= 1e-9 * (fabs(left) + fabs(right)))
      break;
  }
  double s = gsl_min_fminimizer_x_minimum(solver), value = sign * gsl_min_fminimizer_f_minimum(solver);
  gsl_min_fminimizer_free(solver);
  if (q.lost && !scan->best_counts)
    return KM_OK;
  double around = fabs(scan->f[0][i]) + fabs(scan->f[2][i]);
  km_event_kind kind = fabs(value) > unbounded * around ? KM_EVENT_POLE
                       : sign > 0.0                     ? KM_EVENT_MINIMUM
                                                        : KM_EVENT_MAXIMUM;
  return add(scan, (km_event){kind, i, s, kind == KM_EVENT_POLE ? HUGE_VAL : value}, error);
}

static bool is_zero(double f) {
  return f == 0.0;
}

/* A sample without a value: the function has a pole there. Where it has none at the first sample, the second tells. */
static km_status look_at_gap(km_scan *scan, int i, km_error *error) {
  bool now = isnan(scan->f[0][i]), before = scan->have > 1 && isnan(scan->f[1][i]);
  double s = now ? scan->s[0] : scan->s[1];
  bool gap = now ? scan->have > 1 && !before : before && scan->have == 2;
  return gap ? add(scan, (km_event){KM_EVENT_POLE, i, s, HUGE_VAL}, error) : KM_OK;
}

static km_status look(km_scan *scan, km_sweeper *r, int i, bool *probed, km_error *error) {
  double new = scan->f[0][i], old = scan->have > 1 ? scan->f[1][i] : nan("");
  km_status status = KM_OK;
  if (scan->zeros && is_zero(new) && !is_zero(old))
    status = add(scan, (km_event){KM_EVENT_ZERO, i, scan->s[0], 0.0}, error);
  if (scan->zeros && !status)
    status = look_at_gap(scan, i, error);
  bool crossed = new *old < 0.0;
  if (scan->zeros && crossed && !status) {
    *probed = true;
    status = find_zero(scan, r, i, error);
  }
  if (!scan->extremes || scan->have < 3 || status || crossed || !isfinite(new *old * scan->f[2][i]) ||
      old * scan->f[2][i] < 0.0)
    return status;
  double older = scan->f[2][i], grain = least_swing * (fabs(new) + fabs(old));
  if (old - new > grain && old - older > grain) {
    *probed = true;
    status = find_extreme(scan, r, i, -1.0, error);
  } else if (new - old > grain && older - old > grain) {
    *probed = true;
    status = find_extreme(scan, r, i, 1.0, error);
  }
  return status;
}

km_status km_scan_sample(km_scan *scan, km_sweeper *r, double s, km_error *error) {
  double *oldest = scan->f[2];
  memmove(scan->s + 1, scan->s, 2 * sizeof *scan->s);
  memmove(scan->f + 1, scan->f, 2 * sizeof *scan->f);
  scan->s[0] = s;
  scan->f[0] = oldest;
  scan->have = scan->have < 3 ? scan->have + 1 : 3;
  gsl_set_error_handler_off();
  if (r->substructure >= 0)
    km_numbers_update(r->m, r->s, r->substructure);
  scan->values(scan->self, r, scan->f[0]);
  bool probed = false;
  km_status status = KM_OK;
  for (int i = 0; i < scan->count && !status; ++i)
    status = look(scan, r, i, &probed, error);
  if (probed) {
    r->mover.settle(r->mover.self, s);
    if (r->substructure >= 0)
      km_numbers_update(r->m, r->s, r->substructure);
  }
  return status;
}
