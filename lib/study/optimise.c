/* Optimises designs by NLopt: every evaluation is a design like any other, so that a run that was stopped goes the same way
 * again over what the store has. Variables are scaled to 0 … 1 by their bounds. Figures' limits are constraints. */
#include "study/optimise.h"

#include "base/parallel.h"
#include "study/algorithms.h"
#include "study/ask.h"
#include "study/goals.h"
#include "study/sampler.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Central differences: the cube root of the rounding, over the bounds. */
static const double difference = 6e-6;

/* The thread that called the library tells the progress. */
static _Thread_local bool is_caller;

typedef struct optimisation {
  km_design_study *study;
  const km_design_optimise *def;
  const km_algorithm *algorithm;
  bool compute;
  km_progress progress;
  void *context;
  atomic_int evaluations; /* of all starts */
  atomic_bool stopped;
  int total;
} optimisation;

/* One start. */
typedef struct attempt {
  optimisation *o;
  int number;
  double weight; /* of the first of two goals; < 0: the goal `goal` alone */
  int goal;
  double ideal[2], range[2]; /* of the front's ends */
  km_batch batch;
  nlopt_opt optimiser;
  double *values; /* [count × parameters] what was asked for */
  size_t room;
  int count;
  double worst;                             /* objective so far; a design that fails is worse than that */
  double slack[2 * KM_MOST_DESIGN_FIGURES]; /* of the point that was asked last */
  double last[KM_MOST_DESIGN_PARAMETERS];   /* that point, scaled */
  double last_value;
  bool has_last;
  km_status status;
  km_error error;
} attempt;

static int limit_count(const km_design_study *s) {
  int count = 0;
  for (int f = 0; f < s->figure_count; ++f)
    count += isfinite(s->figures[f]->low) + isfinite(s->figures[f]->high);
  return count;
}

/* What is to be least. Of two goals Tchebycheff's scalarisation (Bowman 1976): it reaches every point of a front, also of
 * one that isn't convex. NaN: the design has no answer. */
static double objective(const attempt *a, const km_design_result *r) {
  const km_design_study *s = a->o->study;
  if (!km_design_has_answer(s, r))
    return nan("");
  if (a->weight < 0.0)
    return km_design_goal_value(s, a->goal, r);
  double f = (km_design_goal_value(s, 0, r) - a->ideal[0]) / a->range[0],
         g = (km_design_goal_value(s, 1, r) - a->ideal[1]) / a->range[1];
  return fmax(a->weight * f, (1.0 - a->weight) * g) + 1e-3 * (f + g);
}

static void unscale(const attempt *a, const double *x, double *values) {
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
  attempt *a;
  const double *points; /* [count × variables] scaled */
  int count;
} deposit;

static bool keep(attempt *a, const double *values) {
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
  attempt *a = d->a;
  double values[KM_MOST_DESIGN_PARAMETERS];
  km_batch_clear(&a->batch);
  for (int i = 0; i < d->count && !a->status; ++i) {
    unscale(a, d->points + i * a->o->def->variable_count, values);
    a->status = km_batch_add(&a->batch, values, &a->error);
    if (!a->status && !keep(a, values))
      a->status = km_fail(&a->error, KM_MEMORY, "out of memory for an optimisation");
  }
}

static void put(void *context) {
  deposit *d = context;
  d->a->status = km_batch_store(&d->a->batch, &d->a->error);
  if (!d->a->status)
    d->a->status = km_store_commit(d->a->o->study->store, &d->a->error);
}

static bool is_missing(const attempt *a) {
  for (int i = 0; i < a->batch.count; ++i)
    for (int q = 0; q < a->o->study->def->question_count; ++q)
      if (a->batch.answers[i][q].outcome == KM_DESIGN_MISSING)
        return true;
  return false;
}

static void tell_progress(attempt *a) {
  optimisation *o = a->o;
  int done = atomic_fetch_add(&o->evaluations, a->batch.count) + a->batch.count;
  if (is_caller && o->progress && !o->progress(o->context, fmin(1.0, (double)done / o->total)))
    atomic_store(&o->stopped, true);
  if (atomic_load(&o->stopped) && !a->status)
    a->status = km_fail(&a->error, KM_CANCELLED, "stopped after %d designs; what was answered is stored", done);
}

/* Asks for points[count × variables]. False: the attempt ends. */
static bool ask(attempt *a, const double *points, int count) {
  deposit d = {a, points, count};
  km_serially(look_up, &d);
  if (!a->status && !a->o->compute && is_missing(a)) {
    a->count -= count; /* they weren't answered yet */
    a->status = KM_NO_RESULT;
  }
  if (!a->status && a->o->compute) {
    km_batch_compute(&a->batch);
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
static double value_of(attempt *a, int i, double *slacks) {
  const km_design_study *s = a->o->study;
  km_design_result r;
  km_batch_result(&a->batch, i, &r);
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
  if (isfinite(value))
    a->worst = fmax(a->worst, value);
  else
    value = a->worst > -DBL_MAX ? a->worst + 1.0 + fabs(a->worst) : 1e6;
  return value;
}

/* The point and, where a gradient is wanted, those beside it, all at once. */
static double evaluate(unsigned n, const double *x, double *gradient, void *context) {
  attempt *a = context;
  enum { MOST = 2 * KM_MOST_DESIGN_PARAMETERS + 1 };
  double points[MOST * KM_MOST_DESIGN_PARAMETERS], slacks[2 * KM_MOST_DESIGN_FIGURES];
  int count = gradient ? 2 * (int)n + 1 : 1;
  for (int i = 0; i < count; ++i)
    memcpy(points + i * (int)n, x, n * sizeof *x);
  for (unsigned v = 0; gradient && v < n; ++v) { /* at a bound the difference goes to one side */
    points[(2 * v + 1) * n + v] = fmax(0.0, x[v] - difference);
    points[(2 * v + 2) * n + v] = fmin(1.0, x[v] + difference);
  }
  if (!ask(a, points, count))
    return a->worst > -DBL_MAX ? a->worst : 0.0;
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
static bool is_last(const attempt *a, unsigned n, const double *x) {
  return a->has_last && memcmp(a->last, x, n * sizeof *x) == 0;
}

static void constrain(unsigned m, double *result, unsigned n, const double *x, double *gradient, void *context) {
  attempt *a = context;
  double low[2 * KM_MOST_DESIGN_FIGURES], high[2 * KM_MOST_DESIGN_FIGURES], points[3 * KM_MOST_DESIGN_PARAMETERS];
  if (!is_last(a, n, x))
    evaluate(n, x, NULL, a);
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

static bool configure(attempt *a, nlopt_opt o) {
  unsigned limits = (unsigned)limit_count(a->o->study);
  double tolerances[2 * KM_MOST_DESIGN_FIGURES];
  for (unsigned k = 0; k < limits; ++k)
    tolerances[k] = 1e-9;
  return nlopt_set_min_objective(o, evaluate, a) > 0 && nlopt_set_lower_bounds1(o, 0.0) > 0 &&
         nlopt_set_upper_bounds1(o, 1.0) > 0 && nlopt_set_maxeval(o, a->o->def->evaluations) > 0 &&
         nlopt_set_xtol_rel(o, 0.0) > 0 && nlopt_set_xtol_abs1(o, a->o->def->tolerance) > 0 &&
         (limits == 0 || nlopt_add_inequality_mconstraint(o, limits, constrain, a, tolerances) > 0);
}

/* The algorithm itself, or inside what it needs around it. */
static nlopt_opt make_optimiser(attempt *a) {
  const km_algorithm *algorithm = a->o->algorithm;
  unsigned n = (unsigned)a->o->def->variable_count;
  bool wrapped = !algorithm->constraints && limit_count(a->o->study) > 0;
  nlopt_opt outer = nlopt_create(wrapped ? NLOPT_AUGLAG : algorithm->id, n);
  nlopt_opt inner = wrapped || algorithm->local ? nlopt_create(wrapped ? algorithm->id : NLOPT_LN_BOBYQA, n) : NULL;
  bool good = outer && configure(a, outer);
  if (inner) {
    good = good && nlopt_set_xtol_rel(inner, 0.0) > 0 &&
           nlopt_set_xtol_abs1(inner, fmax(1e-9, a->o->def->tolerance)) > 0 &&
           nlopt_set_maxeval(inner, 200 * (int)n) > 0 && nlopt_set_local_optimizer(outer, inner) > 0;
    nlopt_destroy(inner);
  }
  if (good || !outer)
    return outer;
  nlopt_destroy(outer);
  return NULL;
}

/* The first start is the definition's, the others are spread over the bounds. */
static void start_point(const attempt *a, double *x) {
  const km_design_optimise *o = a->o->def;
  for (int v = 0; v < o->variable_count; ++v) {
    const km_design_variable *at = &o->variables[v];
    double own = isnan(at->start) ? a->o->study->base[at->parameter] : at->start;
    bool inside = own >= at->low && own <= at->high;
    double first = inside ? (own - at->low) / (at->high - at->low) : 0.5;
    bool spread = o->goal_count == 1 && a->number > 0;
    x[v] = spread ? km_random_at(o->seed, (uint64_t)a->number, (uint64_t)v) : first;
  }
}

static void run_attempt(attempt *a) {
  double x[KM_MOST_DESIGN_PARAMETERS], least;
  a->worst = -DBL_MAX;
  a->optimiser = make_optimiser(a);
  if (!a->optimiser) {
    a->status = km_fail(&a->error, KM_MEMORY, "out of memory for an optimisation");
    return;
  }
  start_point(a, x);
  nlopt_srand(a->o->def->seed * 1000003u + (unsigned long)a->number + 1u);
  nlopt_optimize(a->optimiser, x, &least);
  nlopt_destroy(a->optimiser);
  a->optimiser = NULL;
}

static void run_one(void *context, int index) {
  attempt *a = (attempt *)context + index;
  if (!a->status)
    run_attempt(a);
}

/* Runs some attempts at once; with one, the points beside a point are what the threads share. */
static km_status run_attempts(optimisation *o, attempt *attempts, int count, int jobs, km_error *error) {
  km_status status = KM_OK;
  int each = count == 1 ? jobs : 1;
  for (int i = 0; i < count; ++i) {
    attempts[i].o = o;
    attempts[i].status =
        km_batch_open(&attempts[i].batch, o->study, each, 2 * o->def->variable_count + 1, &attempts[i].error);
  }
  is_caller = true;
  km_parallel_for(count, count == 1 ? 1 : jobs, run_one, attempts);
  is_caller = false;
  for (int i = 0; i < count; ++i) {
    km_batch_close(&attempts[i].batch);
    if (attempts[i].status && attempts[i].status != KM_NO_RESULT && !status)
      status = km_fail(error, attempts[i].status, "%s", attempts[i].error.text);
  }
  return status;
}

static bool add_to_trail(km_design_study *s, const attempt *a) {
  size_t size = (size_t)s->def->parameter_count, count = (size_t)s->trail.count, more = (size_t)a->count;
  void *values = s->trail.values, *starts = s->trail.starts;
  if (!km_reserve(&values, &s->trail.value_room, (count + more) * size, sizeof(double)))
    return false;
  s->trail.values = values;
  if (!km_reserve(&starts, &s->trail.start_room, count + more, sizeof(int)))
    return false;
  s->trail.starts = starts;
  if (more)
    memcpy(s->trail.values + count * size, a->values, more * size * sizeof(double));
  for (size_t i = 0; i < more; ++i)
    s->trail.starts[count + i] = a->number;
  s->trail.count += a->count;
  return true;
}

static km_status finish(km_design_study *s, attempt *attempts, int count, km_status status, km_error *error) {
  for (int i = 0; i < count; ++i) {
    if (!add_to_trail(s, &attempts[i]) && !status)
      status = km_fail(error, KM_MEMORY, "out of memory for an optimisation");
    km_free(attempts[i].values);
  }
  km_free(attempts);
  return status;
}

/* The best design of an end of the front, as both goals. */
static bool find_end(const km_design_study *s, int goal, double out[2]) {
  int best = -1;
  km_design_result r;
  for (int i = 0; i < s->trail.count; ++i) {
    if (km_design_study_result(s, i, &r, NULL) || !km_design_study_accepts(s, &r))
      continue;
    if (best < 0 || km_design_goal_value(s, goal, &r) < out[goal]) {
      best = i;
      out[0] = km_design_goal_value(s, 0, &r);
      out[1] = km_design_goal_value(s, 1, &r);
    }
  }
  return best >= 0;
}

/* First each goal alone, then points between the two ends. */
static km_status run_front(optimisation *o, int jobs, km_error *error) {
  attempt *ends = KM_NEW(attempt, 2);
  if (!ends)
    return km_fail(error, KM_MEMORY, "out of memory for an optimisation");
  for (int g = 0; g < 2; ++g) {
    ends[g].number = g;
    ends[g].goal = g;
    ends[g].weight = -1.0;
  }
  km_status status = run_attempts(o, ends, 2, jobs, error);
  status = finish(o->study, ends, 2, status, error);
  double first[2], second[2];
  if (status || !find_end(o->study, 0, first) || !find_end(o->study, 1, second))
    return status;
  int count = o->def->starts;
  attempt *between = KM_NEW(attempt, (size_t)count);
  if (!between)
    return km_fail(error, KM_MEMORY, "out of memory for an optimisation");
  for (int i = 0; i < count; ++i) {
    between[i].number = i + 2;
    between[i].weight = (i + 1.0) / (count + 1.0);
    between[i].ideal[0] = first[0];
    between[i].ideal[1] = second[1];
    between[i].range[0] = fmax(second[0] - first[0], 1e-300);
    between[i].range[1] = fmax(first[1] - second[1], 1e-300);
  }
  status = run_attempts(o, between, count, jobs, error);
  return finish(o->study, between, count, status, error);
}

static km_status run_starts(optimisation *o, int jobs, km_error *error) {
  int count = o->def->starts;
  attempt *attempts = KM_NEW(attempt, (size_t)count);
  if (!attempts)
    return km_fail(error, KM_MEMORY, "out of memory for an optimisation");
  for (int i = 0; i < count; ++i) {
    attempts[i].number = i;
    attempts[i].weight = -1.0;
  }
  km_status status = run_attempts(o, attempts, count, jobs, error);
  return finish(o->study, attempts, count, status, error);
}

km_status km_optimise_run(km_design_study *s, int jobs, bool compute, km_progress progress, void *context,
                          km_error *error) {
  const km_design_optimise *def = s->def->optimise;
  optimisation o = {.study = s,
                    .def = def,
                    .algorithm = km_algorithm_find(def->algorithm),
                    .compute = compute,
                    .progress = progress,
                    .context = context,
                    .total = def->evaluations * (def->starts + (def->goal_count == 2 ? 2 : 0))};
  s->trail.count = 0;
  km_status status = def->goal_count == 2 ? run_front(&o, jobs, error) : run_starts(&o, jobs, error);
  km_status stored = km_store_commit(s->store, status ? NULL : error);
  return status ? status : stored;
}
