/* Method `global`: tan φ along the path is piecewise linear between knots. The values at the knots are optimised by
 * NLopt: controlled random search from greedy's track, then Subplex from the best (docs/theory.md 12.5). A track
 * that ends early has a cost that decreases with its length. */
#include "arm/methods/method.h"

#include <nlopt.h>
#include <string.h>

typedef struct problem {
  km_tracking_run *run;
  const double *x; /* [knots × freedom] tan φ at the knots */
  double tan_phi[KM_ARM_MAX_JOINTS];
  double best_cost;
  double best[KM_METHOD_KNOTS * KM_ARM_MAX_JOINTS];
  nlopt_opt opt;
  km_status status;
  km_error *error;
  int tried;
} problem;

/* tan φ at a sample: linear interpolation between the knots. */
static void choose(void *context, km_tracking_run *run, int sample, const km_path_node *node, km_step_choice *choice) {
  problem *p = context;
  (void)node;
  const int knots = run->plan->method.knots, freedom = run->arm->freedom;
  const km_path_point *points = run->plan->path->points;
  double at = points[sample].s / points[run->plan->path->samples - 1].s * (knots - 1);
  int k = at < knots - 1 ? (int)at : knots - 2;
  for (int j = 0; j < freedom; ++j)
    p->tan_phi[j] = p->x[k * freedom + j] + (at - k) * (p->x[(k + 1) * freedom + j] - p->x[k * freedom + j]);
  choice->tan_phi = p->tan_phi;
}

/* Cost for NLopt: minus the score of a complete track; a track that ends early costs more than any complete one,
 * less the farther it goes. */
static double objective_cost(unsigned count, const double *x, double *gradient, void *context) {
  static const km_step_choice greedy_choice = {0};
  static const double partial_cost = 1e100; /* exceeds any objective; the searches compare costs only */
  problem *p = context;
  (void)gradient;
  p->x = x;
  km_tracking_run *run = p->run;
  const km_track_plan *plan = run->plan;
  p->status = km_run_try(run, &greedy_choice, choose, p);
  double value = (double)INFINITY;
  if (p->status == KM_OK)
    value = -km_run_rounded(km_run_score(run, km_run_evaluate(run)));
  else if (p->status == KM_PARTIAL)
    value = partial_cost * (2.0 - (double)run->reached / plan->path->samples);
  else
    nlopt_force_stop(p->opt);
  if (value < p->best_cost) {
    p->best_cost = value;
    memcpy(p->best, x, count * sizeof *x);
  }
  if (!(plan->progress ? plan->progress(plan->context, fmin(1.0, (double)++p->tried / plan->method.evaluations))
                       : true)) {
    p->status = km_fail(p->error, KM_CANCELLED, "cancelled");
    nlopt_force_stop(p->opt);
  }
  return value;
}

/* Runs one algorithm of NLopt from the best knots so far, |tan φ| bounded by the method's angle. */
static bool run_optimiser(problem *p, nlopt_algorithm algorithm, int evaluations) {
  const km_method *method = &p->run->plan->method;
  unsigned count = (unsigned)(method->knots * p->run->arm->freedom);
  double most = tan(method->angle), x[KM_METHOD_KNOTS * KM_ARM_MAX_JOINTS], value;
  p->opt = nlopt_create(algorithm, count);
  if (!p->opt)
    return false;
  memcpy(x, p->best, count * sizeof *x);
  nlopt_set_min_objective(p->opt, objective_cost, p);
  nlopt_set_lower_bounds1(p->opt, -most);
  nlopt_set_upper_bounds1(p->opt, most);
  nlopt_set_maxeval(p->opt, evaluations);
  nlopt_set_population(p->opt, 3 * count);
  nlopt_set_initial_step1(p->opt, 0.3 * most);
  nlopt_result result = nlopt_optimize(p->opt, x, &value);
  nlopt_destroy(p->opt);
  p->opt = NULL;
  return result != NLOPT_OUT_OF_MEMORY;
}

/* Controlled random search, then Subplex, each with half of the evaluations; writes the best track. */
km_status km_method_global(km_tracking_run *run, km_error *error) {
  static const km_step_choice greedy_choice = {0};
  const km_method *method = &run->plan->method;
  if (run->arm->freedom == 0)
    return km_method_greedy(run, error);
  problem p = {.run = run, .best_cost = (double)INFINITY, .error = error};
  nlopt_srand(run->plan->seed);
  bool is_ok = run_optimiser(&p, NLOPT_GN_CRS2_LM, method->evaluations / 2);
  if (is_ok && p.status != KM_CANCELLED)
    is_ok = run_optimiser(&p, NLOPT_LN_SBPLX, method->evaluations - method->evaluations / 2);
  if (!is_ok)
    return km_fail(error, KM_MEMORY, "out of memory for the optimisation");
  if (p.status != KM_OK && p.status != KM_PARTIAL)
    return p.status;
  p.x = p.best;
  return km_run_steps(run, &greedy_choice, choose, &p, error);
}
