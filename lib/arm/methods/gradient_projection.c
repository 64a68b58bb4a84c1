/* Gradient projection: the path-control column plus the objective's gradient in the null space, q̇ = J⁺ξ + k (I −
 * J⁺J) ∇H (A. Liégeois 1977; docs/theory.md 12.5).
 *
 *   tan_phi_j = k dH/dc_j,  central difference along pose-control column c_j;  |tan_phi| <= tan(angle) */
#include "arm/methods/method.h"

typedef struct gradient_search {
  double tan_phi[KM_ARM_MAX_JOINTS];
  km_path_node probe;
} gradient_search;

/* Objective at a small distance along a pose-control column. The configuration leaves the path by the square of the
 * distance. */
static double objective_along(km_tracking_run *run, gradient_search *c, int sample, const km_path_node *node,
                              const double *column, double distance) {
  static const km_step_choice greedy_choice = {0};
  double q[KM_ARM_MAX_JOINTS];
  for (int k = 0; k < run->arm->n; ++k)
    q[k] = node->q[k] + distance * column[k];
  km_tracker_compute_node(&run->tracker, &run->space, sample, q, &greedy_choice, &c->probe);
  return c->probe.value;
}

/* tan φ along the gradient of the objective by central differences, shortened to tan(angle). */
static void choose(void *context, km_tracking_run *run, int sample, const km_path_node *node, km_step_choice *choice) {
  static const double h = 1e-4;
  gradient_search *c = context;
  const km_method *method = &run->plan->method;
  double size = 0.0;
  for (int j = 0; j < run->arm->freedom; ++j) {
    const double *column = node->self + j * run->arm->n;
    double slope =
        (objective_along(run, c, sample, node, column, h) - objective_along(run, c, sample, node, column, -h)) /
        (2.0 * h);
    c->tan_phi[j] = method->gain * slope;
    size += c->tan_phi[j] * c->tan_phi[j];
  }
  double most = tan(method->angle);
  for (int j = 0; j < run->arm->freedom && size > most * most; ++j)
    c->tan_phi[j] *= most / sqrt(size);
  choice->tan_phi = c->tan_phi;
}

km_status km_method_gradient(km_tracking_run *run, km_error *error) {
  static const km_step_choice greedy_choice = {0};
  gradient_search c;
  if (!km_path_node_create(run->arm, &run->arena, &c.probe))
    return km_fail(error, KM_MEMORY, "out of memory for a track");
  return km_run_steps(run, &greedy_choice, choose, &c, error);
}
