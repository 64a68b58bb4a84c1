/* The points that NLopt asks one start of an optimisation for: each is a design like any other, so that a run that was
 * stopped goes the same way again over what the store has. */
#include "study/optimisation/optimisation_start.h"

#include "base/parallel.h"
#include "study/optimisation/goals.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Central differences: the cube root of the rounding, over the bounds. */
static const double difference = 6e-6;

int km_attempt_limits(const km_attempt *a) {
  const km_design_study *s = a->o->study;
  int count = a->between;
  for (int f = 0; f < s->figure_count; ++f)
    count += isfinite(s->figures[f]->low) + isfinite(s->figures[f]->high);
  return count;
}

/* A goal, from 0 at the end of the front where it is best to 1 at the other one. */
static double on_front(const km_attempt *a, int goal, const km_design_result *r) {
  return (km_design_goal_value(a->o->study, goal, r) - a->ideal[goal]) / a->range[goal];
}

/* What is to be least. NaN: the design has no answer. Between the ends of a front the second goal is, and the first one may be above it by
 * a limit that rises from point to point (Pascoletti and Serafini 1984): all is smooth, and every point of a front is reached, also of one
 * that isn't convex. A little of the first goal decides where the second is the same. */
static double objective(const km_attempt *a, const km_design_result *r) {
  const km_design_study *s = a->o->study;
  if (!km_design_has_answer(s, r))
    return nan("");
  return a->between ? on_front(a, 1, r) + 1e-3 * on_front(a, 0, r) : km_design_goal_value(s, a->goal, r);
}

bool km_attempt_knows(const km_attempt *a) {
  return a->worst > -DBL_MAX;
}

static void unscale(const km_attempt *a, const double *x, double *values) {
  const km_design_optimise *o = a->o->def;
  km_design_clear(a->o->study, values);
  for (int v = 0; v < o->variable_count; ++v) {
    const km_design_variable *at = &o->variables[v];
    double t = fmin(1.0, fmax(0.0, x[v]));
    values[at->parameter] = t <= 0.0 ? at->low : t >= 1.0 ? at->high : at->low + (at->high - at->low) * t;
  }
}

/* The store has one user at a time. */
typedef struct deposit {
  km_attempt *a;
  const double *points; /* [count × variables] scaled */
  int count;
} deposit;

static bool keep(km_attempt *a, const double *values) {
  size_t size = (size_t)a->o->study->def->parameter_count;
  void *data = a->values;
  if (!km_reserve(&data, &a->room, ((size_t)a->count + 1) * size, sizeof *values))
    return false;
  a->values = data;
  memcpy(a->values + (size_t)a->count++ * size, values, size * sizeof *values);
  return true;
}

static void look_up(void *context) {
  deposit *d = context;
  km_attempt *a = d->a;
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_evaluation_clear(&a->batch);
  for (int i = 0; i < d->count && !a->status; ++i) {
    unscale(a, d->points + i * a->o->def->variable_count, values);
    a->status = km_evaluation_add(&a->batch, values, &a->error);
    if (!a->status && !keep(a, values))
      a->status = km_fail(&a->error, KM_MEMORY, "out of memory for an optimisation");
  }
}

static void put(void *context) {
  deposit *d = context;
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

static void tell_progress(km_attempt *a) {
  km_optimisation *o = a->o;
  int done = atomic_fetch_add(&o->evaluations, a->batch.count) + a->batch.count;
  if (km_thread_mark() == o->caller && o->progress && !o->progress(o->context, fmin(1.0, (double)done / o->total)))
    atomic_store(&o->stopped, true);
  if (atomic_load(&o->stopped) && !a->status)
    a->status = km_fail(&a->error, KM_CANCELLED, "stopped after %d designs; what was answered is stored", done);
}

/* Asks for points[count × variables]. False: the attempt ends, also where they would be more than a start may have. */
static bool ask(km_attempt *a, const double *points, int count) {
  deposit d = {a, points, count};
  if (a->count + count > a->o->def->evaluations) {
    nlopt_force_stop(a->optimiser);
    return false;
  }
  km_serially(look_up, &d);
  if (!a->status && !a->o->compute && is_missing(a)) {
    a->count -= count; /* they weren't answered yet */
    a->status = KM_NO_RESULT;
  }
  if (!a->status && a->o->compute) {
    km_evaluation_compute(&a->batch);
    km_serially(put, &d);
  }
  if (!a->status)
    tell_progress(a);
  if (a->status)
    nlopt_force_stop(a->optimiser);
  return a->status == KM_OK;
}

/* Objective and slacks (≤ 0: kept) of answer i of the batch. A design that fails is worse than all before, and breaks
 * every limit as far as it goes. */
static double value_of(km_attempt *a, int i, double *slacks) {
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
      slacks[k++] = isfinite(x) ? (limits->low - x) / size : 1.0;
    if (isfinite(limits->high))
      slacks[k++] = isfinite(x) ? (x - limits->high) / size : 1.0;
  }
  if (a->between)
    slacks[k++] = isfinite(value) ? on_front(a, 0, &r) - on_front(a, 1, &r) - a->apart : 1.0;
  if (isfinite(value))
    a->worst = fmax(a->worst, value);
  else
    value = km_attempt_knows(a) ? a->worst + 1.0 + fabs(a->worst) : 1e6;
  return value;
}

static bool is_last(const km_attempt *a, unsigned n, const double *x) {
  return a->has_last && memcmp(a->last, x, n * sizeof *x) == 0;
}

/* The point and, where a gradient is wanted, those beside it, all at once. */
double km_attempt_evaluate(unsigned n, const double *x, double *gradient, void *context) {
  km_attempt *a = context;
  if (!gradient && is_last(a, n, x))
    return a->last_value;
  enum { MOST = 2 * KM_MAX_DESIGN_PARAMETERS + 1 };
  double points[MOST * KM_MAX_DESIGN_PARAMETERS], slacks[KM_MAX_ATTEMPT_LIMITS];
  int count = gradient ? 2 * (int)n + 1 : 1;
  for (int i = 0; i < count; ++i)
    memcpy(points + i * (int)n, x, n * sizeof *x);
  for (unsigned v = 0; gradient && v < n; ++v) { /* at a bound the difference goes to one side */
    points[(2 * v + 1) * n + v] = fmax(0.0, x[v] - difference);
    points[(2 * v + 2) * n + v] = fmin(1.0, x[v] + difference);
  }
  if (!ask(a, points, count))
    return km_attempt_knows(a) ? a->worst : 0.0;
  double value = value_of(a, 0, a->slack);
  for (unsigned v = 0; gradient && v < n; ++v) {
    double low = value_of(a, 2 * (int)v + 1, slacks), high = value_of(a, 2 * (int)v + 2, slacks);
    gradient[v] = (high - low) / (points[(2 * v + 2) * n + v] - points[(2 * v + 1) * n + v]);
  }
  memcpy(a->last, x, n * sizeof *x);
  a->last_value = value;
  a->has_last = true;
  return value;
}

/* NLopt asks for the constraints where it has just asked for the objective, or has not yet. */
void km_attempt_constrain(unsigned m, double *result, unsigned n, const double *x, double *gradient, void *context) {
  km_attempt *a = context;
  double low[KM_MAX_ATTEMPT_LIMITS], high[KM_MAX_ATTEMPT_LIMITS], points[3 * KM_MAX_DESIGN_PARAMETERS];
  if (!is_last(a, n, x))
    km_attempt_evaluate(n, x, NULL, a);
  memcpy(result, a->slack, m * sizeof *result);
  for (unsigned v = 0; gradient && v < n && !a->status; ++v) {
    memcpy(points, x, n * sizeof *x);
    memcpy(points + n, x, n * sizeof *x);
    points[v] = fmax(0.0, x[v] - difference);
    points[n + v] = fmin(1.0, x[v] + difference);
    if (!ask(a, points, 2))
      return;
    value_of(a, 0, low);
    value_of(a, 1, high);
    for (unsigned k = 0; k < m; ++k)
      gradient[k * n + v] = (high[k] - low[k]) / (points[n + v] - points[v]);
  }
}
