/* Optimisation of designs by NLopt, from one or several starts, and along the front of two goals (docs/theory.md
 * 13.6).
 *
 *   min f(x)  subject to  limits of figures as constraints ≤ 0;   x scaled to [0, 1] by the bounds
 *   algorithms without constraints run inside an augmented Lagrangian */
#include "study/optimisation/optimisation.h"

#include "base/parallel.h"
#include "study/optimisation/goals.h"
#include "study/optimisation/optimisation_start.h"
#include "study/statistics/sampler.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Sets objective, bounds, constraints and tolerances of NLopt. */
static bool configure(km_attempt *a, nlopt_opt o) {
  unsigned limits = (unsigned)km_attempt_limits(a);
  double tolerances[KM_MAX_ATTEMPT_LIMITS];
  for (unsigned k = 0; k < limits; ++k)
    tolerances[k] = 1e-9;
  return nlopt_set_min_objective(o, km_attempt_evaluate, a) > 0 && nlopt_set_lower_bounds1(o, 0.0) > 0 &&
         nlopt_set_upper_bounds1(o, 1.0) > 0 && nlopt_set_maxeval(o, a->o->def->evaluations) > 0 &&
         nlopt_set_xtol_rel(o, 0.0) > 0 && nlopt_set_xtol_abs1(o, a->o->def->tolerance) > 0 &&
         (limits == 0 || nlopt_add_inequality_mconstraint(o, limits, km_attempt_constrain, a, tolerances) > 0);
}

/* Creates the inner optimiser; it stops by the change of the variables, or after 200 points per variable. */
static nlopt_opt create_inner(const km_attempt *a, nlopt_algorithm algorithm) {
  int n = a->o->def->variable_count;
  nlopt_opt o = nlopt_create(algorithm, (unsigned)n);
  if (o && nlopt_set_xtol_rel(o, 0.0) > 0 && nlopt_set_xtol_abs1(o, fmax(1e-9, a->o->def->tolerance)) > 0 &&
      nlopt_set_maxeval(o, 200 * n) > 0)
    return o;
  nlopt_destroy(o);
  return NULL;
}

/* Attaches the inner optimiser, which NLopt copies. */
static bool attach_inner(nlopt_opt outer, nlopt_opt inner) {
  bool good = inner && nlopt_set_local_optimizer(outer, inner) > 0;
  nlopt_destroy(inner);
  return good;
}

/* Completes an algorithm by the local one that it restarts, if it needs one. */
static nlopt_opt create_algorithm(const km_attempt *a, nlopt_opt o) {
  if (!o || !a->o->algorithm->local || attach_inner(o, create_inner(a, NLOPT_LN_BOBYQA)))
    return o;
  nlopt_destroy(o);
  return NULL;
}

/* Creates the optimiser: the algorithm, inside an augmented Lagrangian if it handles no constraints. */
static nlopt_opt create_optimiser(km_attempt *a) {
  const km_algorithm *algorithm = a->o->algorithm;
  unsigned n = (unsigned)a->o->def->variable_count;
  bool wrapped = !algorithm->constraints && km_attempt_limits(a) > 0;
  nlopt_opt o = wrapped ? nlopt_create(NLOPT_AUGLAG, n) : create_algorithm(a, nlopt_create(algorithm->id, n));
  if (o && configure(a, o) && (!wrapped || attach_inner(o, create_algorithm(a, create_inner(a, algorithm->id)))))
    return o;
  nlopt_destroy(o);
  return NULL;
}

/* Start point: the definition's for the first start, random within the bounds for the others. */
static void start_point(const km_attempt *a, double *x) {
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

/* Finds a start point with an answer: failing designs count as worse than the worst known value, so a first value is
 * needed. Random points are tried, up to half of the start's designs. */
static void find_start(km_attempt *a, double *x) {
  const km_design_optimise *o = a->o->def;
  const int n = o->variable_count, most = o->evaluations / 2;
  start_point(a, x);
  km_attempt_evaluate((unsigned)n, x, NULL, a);
  for (int k = 1; k < most && !km_attempt_has_value(a) && !a->status; ++k) {
    for (int v = 0; v < n; ++v)
      x[v] = km_random_at(o->seed, (uint64_t)a->number, (uint64_t)(v + k * n));
    km_attempt_evaluate((unsigned)n, x, NULL, a);
  }
  if (!km_attempt_has_value(a))
    start_point(a, x);
}

/* Runs one start: start point, then NLopt. */
static void run_attempt(km_attempt *a) {
  double x[KM_MAX_DESIGN_PARAMETERS], least;
  a->worst = -DBL_MAX;
  a->optimiser = create_optimiser(a);
  if (!a->optimiser) {
    a->status = km_fail(&a->error, KM_MEMORY, "out of memory for an optimisation");
    return;
  }
  find_start(a, x);
  nlopt_srand(a->o->def->seed * 1000003u + (unsigned long)a->number + 1u);
  if (!a->status && nlopt_optimize(a->optimiser, x, &least) == NLOPT_OUT_OF_MEMORY && !a->status)
    a->status = km_fail(&a->error, KM_MEMORY, "out of memory for an optimisation");
  nlopt_destroy(a->optimiser);
  a->optimiser = NULL;
}

static void run_one(void *context, int index) {
  km_attempt *a = (km_attempt *)context + index;
  if (!a->status)
    run_attempt(a);
}

/* Runs several starts in parallel; with one start, the threads share the points of its gradients. */
static km_status run_attempts(km_optimisation *o, km_attempt *attempts, int count, int jobs, km_error *error) {
  km_status status = KM_OK;
  int each = count == 1 ? jobs : 1;
  for (int i = 0; i < count; ++i) {
    attempts[i].o = o;
    attempts[i].status =
        km_evaluation_open(&attempts[i].batch, o->study, each, 2 * o->def->variable_count + 1, &attempts[i].error);
  }
  km_parallel_for(count, count == 1 ? 1 : jobs, run_one, attempts);
  for (int i = 0; i < count; ++i) {
    km_evaluation_close(&attempts[i].batch);
    o->study->ended_early = o->study->ended_early || attempts[i].status == KM_NO_RESULT;
    if (attempts[i].status && attempts[i].status != KM_NO_RESULT && !status)
      status = km_fail(error, attempts[i].status, "%s", attempts[i].error.text);
  }
  return status;
}

/* Appends the designs of a start to the study's trail. */
static bool add_to_trail(km_design_study *s, const km_attempt *a) {
  size_t size = (size_t)s->def->parameter_count, count = (size_t)s->trail.count, more = (size_t)a->count;
  void *values = s->trail.values, *starts = s->trail.starts;
  if (!km_reserve(&values, &s->trail.value_capacity, (count + more) * size, sizeof(double)))
    return false;
  s->trail.values = values;
  if (!km_reserve(&starts, &s->trail.start_capacity, count + more, sizeof(int)))
    return false;
  s->trail.starts = starts;
  if (more)
    memcpy(s->trail.values + count * size, a->values, more * size * sizeof(double));
  for (size_t i = 0; i < more; ++i)
    s->trail.starts[count + i] = a->number;
  s->trail.count += a->count;
  return true;
}

/* Appends the designs of all starts and frees them. */
static km_status collect_trails(km_design_study *s, km_attempt *attempts, int count, km_status status,
                                km_error *error) {
  for (int i = 0; i < count; ++i) {
    if (!add_to_trail(s, &attempts[i]) && !status)
      status = km_fail(error, KM_MEMORY, "out of memory for an optimisation");
    km_free(attempts[i].values);
  }
  km_free(attempts);
  return status;
}

/* Best design for one goal: an end of the front, as the values of both goals. */
static bool find_front_end(const km_design_study *s, int goal, double out[2]) {
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

/* Computes a front: each goal alone for its ends, then points between them. */
static km_status run_front(km_optimisation *o, int jobs, km_error *error) {
  km_attempt *ends = KM_NEW(km_attempt, 2);
  if (!ends)
    return km_fail(error, KM_MEMORY, "out of memory for an optimisation");
  for (int g = 0; g < 2; ++g) {
    ends[g].number = g;
    ends[g].goal = g;
  }
  km_status status = run_attempts(o, ends, 2, jobs, error);
  status = collect_trails(o->study, ends, 2, status, error);
  double first[2], second[2];
  if (status || !find_front_end(o->study, 0, first) || !find_front_end(o->study, 1, second))
    return status;
  int count = o->def->starts;
  km_attempt *between = KM_NEW(km_attempt, (size_t)count);
  if (!between)
    return km_fail(error, KM_MEMORY, "out of memory for an optimisation");
  for (int i = 0; i < count; ++i) {
    between[i].number = i + 2;
    between[i].between = true;
    between[i].max_difference = 2.0 * (i + 1.0) / (count + 1.0) - 1.0;
    between[i].ideal[0] = first[0];
    between[i].ideal[1] = second[1];
    between[i].range[0] = fmax(second[0] - first[0], 1e-300);
    between[i].range[1] = fmax(first[1] - second[1], 1e-300);
  }
  status = run_attempts(o, between, count, jobs, error);
  return collect_trails(o->study, between, count, status, error);
}

/* Runs all starts of an optimisation with one goal. */
static km_status run_starts(km_optimisation *o, int jobs, km_error *error) {
  int count = o->def->starts;
  km_attempt *attempts = KM_NEW(km_attempt, (size_t)count);
  if (!attempts)
    return km_fail(error, KM_MEMORY, "out of memory for an optimisation");
  for (int i = 0; i < count; ++i) {
    attempts[i].number = i;
  }
  km_status status = run_attempts(o, attempts, count, jobs, error);
  return collect_trails(o->study, attempts, count, status, error);
}

km_status km_optimise_run(km_design_study *s, int jobs, bool compute, km_progress progress, void *context,
                          km_error *error) {
  const km_design_optimise *def = s->def->optimise;
  km_optimisation o = {.study = s,
                       .def = def,
                       .algorithm = km_algorithm_find(def->algorithm),
                       .compute = compute,
                       .progress = progress,
                       .context = context,
                       .caller = km_thread_mark(),
                       .total = def->evaluations * (def->starts + (def->goal_count == 2 ? 2 : 0))};
  s->trail.count = 0;
  km_status status = def->goal_count == 2 ? run_front(&o, jobs, error) : run_starts(&o, jobs, error);
  km_status stored = km_store_commit(s->store, status ? NULL : error);
  return status ? status : stored;
}
