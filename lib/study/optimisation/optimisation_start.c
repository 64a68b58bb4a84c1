/* Objective and constraints of one start of an optimisation, as NLopt requests them (docs/theory.md 13.6). Each
 * point is a design of the study, so a stopped run repeats the same points from the store.
 *
 *   front: min f_2 + 1e-3 f_1  subject to  f_1 − f_2 ≤ a,  goals scaled to 0 … 1   (A. Pascoletti and P. Serafini 1984)
 *   gradients: central differences of 6e-6 in scaled variables */
#include "study/optimisation/optimisation_start.h"

#include "base/parallel.h"
#include "study/optimisation/goals.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Step of central differences in scaled variables: cube root of the rounding error. */
static const double difference = 6e-6;

int km_attempt_limits(const km_attempt *a) {
  const km_design_study *s = a->o->study;
  int count = a->between;
  for (int f = 0; f < s->figure_count; ++f)
    count += isfinite(s->figures[f]->low) + isfinite(s->figures[f]->high);
  return count;
}

/* Goal scaled by the front's ends: 0 where it is best, 1 at the other end. */
static double scaled_goal(const km_attempt *a, int goal, const km_design_result *r) {
  return (km_design_goal_value(a->o->study, goal, r) - a->ideal[goal]) / a->range[goal];
}

/* Objective; NaN: the design has no answer. Points between the ends of a front minimise the second goal with the
 * constraint f_1 − f_2 ≤ a (A. Pascoletti and P. Serafini 1984). This is smooth and reaches every point of the
 * front, also non-convex parts. A small multiple of the first goal decides ties. */
static double objective(const km_attempt *a, const km_design_result *r) {
  const km_design_study *s = a->o->study;
  if (!km_design_has_answer(s, r))
    return nan("");
  return a->between ? scaled_goal(a, 1, r) + 1e-3 * scaled_goal(a, 0, r) : km_design_goal_value(s, a->goal, r);
}

bool km_attempt_has_value(const km_attempt *a) {
  return a->worst > -DBL_MAX;
}

static void unscale_point(const km_attempt *a, const double *x, double *values) {
  const km_design_optimise *o = a->o->def;
  km_design_clear(a->o->study, values);
  for (int v = 0; v < o->variable_count; ++v) {
    const km_design_variable *at = &o->variables[v];
    double t = fmin(1.0, fmax(0.0, x[v]));
    values[at->parameter] = t <= 0.0 ? at->low : t >= 1.0 ? at->high : at->low + (at->high - at->low) * t;
  }
}

/* Access to the store, which is serialised. */
typedef struct store_access {
  km_attempt *a;
  const double *points; /* [count × variables] scaled */
  int count;
} store_access;

static bool add_point(km_attempt *a, const double *values) {
  size_t size = (size_t)a->o->study->def->parameter_count;
  void *data = a->values;
  if (!km_reserve(&data, &a->capacity, ((size_t)a->count + 1) * size, sizeof *values))
    return false;
  a->values = data;
  memcpy(a->values + (size_t)a->count++ * size, values, size * sizeof *values);
  return true;
}

/* Adds points to the batch, with their answers from the store. */
static void add_points(void *context) {
  store_access *d = context;
  km_attempt *a = d->a;
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_evaluation_clear(&a->batch);
  for (int i = 0; i < d->count && !a->status; ++i) {
    unscale_point(a, d->points + i * a->o->def->variable_count, values);
    a->status = km_evaluation_add(&a->batch, values, &a->error);
    if (!a->status && !add_point(a, values))
      a->status = km_fail(&a->error, KM_MEMORY, "out of memory for an optimisation");
  }
}

static void store_points(void *context) {
  store_access *d = context;
  d->a->status = km_evaluation_store(&d->a->batch, &d->a->error);
  if (!d->a->status)
    d->a->status = km_store_commit(d->a->o->study->store, &d->a->error);
}

static bool is_missing(const km_attempt *a) {
  for (int i = 0; i < a->batch.count; ++i)
    for (int q = 0; q < a->o->study->def->question_count; ++q)
      if (a->batch.answers[i][q].outcome == KM_DESIGN_MISSING)
        return true;
  return false;
}

static void report_progress(km_attempt *a) {
  km_optimisation *o = a->o;
  int done = atomic_fetch_add(&o->evaluations, a->batch.count) + a->batch.count;
  if (km_thread_mark() == o->caller && o->progress && !o->progress(o->context, fmin(1.0, (double)done / o->total)))
    atomic_store(&o->stopped, true);
  if (atomic_load(&o->stopped) && !a->status)
    a->status = km_fail(&a->error, KM_CANCELLED, "stopped after %d designs; what was answered is stored", done);
}

/* Evaluates points[count × variables]. False: the start ends, also at its largest number of designs. */
static bool evaluate_points(km_attempt *a, const double *points, int count) {
  store_access d = {a, points, count};
  if (a->count + count > a->o->def->evaluations) {
    nlopt_force_stop(a->optimiser);
    return false;
  }
  km_serially(add_points, &d);
  if (!a->status && !a->o->compute && is_missing(a)) {
    a->count -= count; /* they have no answers yet */
    a->status = KM_NO_RESULT;
  }
  if (!a->status && a->o->compute) {
    km_evaluation_compute(&a->batch);
    km_serially(store_points, &d);
  }
  if (!a->status)
    report_progress(a);
  if (a->status)
    nlopt_force_stop(a->optimiser);
  return a->status == KM_OK;
}

/* Objective and constraint values (≤ 0: satisfied) of answer i of the batch. A failed design is worse than all
 * before and violates every limit. */
static double evaluate_answer(km_attempt *a, int i, double *constraints) {
  const km_design_study *s = a->o->study;
  km_design_result r;
  km_evaluation_result(&a->batch, i, &r);
  double value = objective(a, &r);
  int k = 0;
  for (int f = 0; f < s->figure_count; ++f) {
    const km_design_figure *limits = s->figures[f];
    double x = r.figures[f], size = isfinite(limits->low) && isfinite(limits->high) ? limits->high - limits->low : 0.0;
    size = size > 0.0 ? size
                      : fmax(1e-12, fmax(isfinite(limits->low) ? fabs(limits->low) : 0.0,
                                         isfinite(limits->high) ? fabs(limits->high) : 0.0));
    if (isfinite(limits->low))
      constraints[k++] = isfinite(x) ? (limits->low - x) / size : 1.0;
    if (isfinite(limits->high))
      constraints[k++] = isfinite(x) ? (x - limits->high) / size : 1.0;
  }
  if (a->between)
    constraints[k++] = isfinite(value) ? scaled_goal(a, 0, &r) - scaled_goal(a, 1, &r) - a->max_difference : 1.0;
  if (isfinite(value))
    a->worst = fmax(a->worst, value);
  else
    value = km_attempt_has_value(a) ? a->worst + 1.0 + fabs(a->worst) : 1e6;
  return value;
}

static bool is_last(const km_attempt *a, unsigned n, const double *x) {
  return a->has_last && memcmp(a->last, x, n * sizeof *x) == 0;
}

/* Objective of a point; for a gradient, with the points of central differences, as one batch. */
double km_attempt_evaluate(unsigned n, const double *x, double *gradient, void *context) {
  km_attempt *a = context;
  if (!gradient && is_last(a, n, x))
    return a->last_value;
  enum { MOST = 2 * KM_MAX_DESIGN_PARAMETERS + 1 };
  double points[MOST * KM_MAX_DESIGN_PARAMETERS], constraints[KM_MAX_ATTEMPT_LIMITS];
  int count = gradient ? 2 * (int)n + 1 : 1;
  for (int i = 0; i < count; ++i)
    memcpy(points + i * (int)n, x, n * sizeof *x);
  for (unsigned v = 0; gradient && v < n; ++v) { /* one-sided differences at a bound */
    points[(2 * v + 1) * n + v] = fmax(0.0, x[v] - difference);
    points[(2 * v + 2) * n + v] = fmin(1.0, x[v] + difference);
  }
  if (!evaluate_points(a, points, count))
    return km_attempt_has_value(a) ? a->worst : 0.0;
  double value = evaluate_answer(a, 0, a->constraint);
  for (unsigned v = 0; gradient && v < n; ++v) {
    double low = evaluate_answer(a, 2 * (int)v + 1, constraints),
           high = evaluate_answer(a, 2 * (int)v + 2, constraints);
    gradient[v] = (high - low) / (points[(2 * v + 2) * n + v] - points[(2 * v + 1) * n + v]);
  }
  memcpy(a->last, x, n * sizeof *x);
  a->last_value = value;
  a->has_last = true;
  return value;
}

/* Constraints of a point; NLopt requests them before or after the objective of the same point. */
void km_attempt_constrain(unsigned m, double *result, unsigned n, const double *x, double *gradient, void *context) {
  km_attempt *a = context;
  double low[KM_MAX_ATTEMPT_LIMITS], high[KM_MAX_ATTEMPT_LIMITS], points[3 * KM_MAX_DESIGN_PARAMETERS];
  if (!is_last(a, n, x))
    km_attempt_evaluate(n, x, NULL, a);
  memcpy(result, a->constraint, m * sizeof *result);
  for (unsigned v = 0; gradient && v < n && !a->status; ++v) {
    memcpy(points, x, n * sizeof *x);
    memcpy(points + n, x, n * sizeof *x);
    points[v] = fmax(0.0, x[v] - difference);
    points[n + v] = fmin(1.0, x[v] + difference);
    if (!evaluate_points(a, points, 2))
      return;
    evaluate_answer(a, 0, low);
    evaluate_answer(a, 1, high);
    for (unsigned k = 0; k < m; ++k)
      gradient[k * n + v] = (high[k] - low[k]) / (points[n + v] - points[v]);
  }
}
