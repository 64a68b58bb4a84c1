/* Greedy, and in the null space up the objective's slope: q̇ = J⁺ξ + k (I − J⁺J)∇H (Liégeois 1977). */
#include "arm/methods/method.h"

typedef struct climber {
  double tilt[KM_ARM_MOST];
  km_node probe;
} climber;

/* The objective a short way along a pose-control column; the way leaves the path by the square of it. */
static double beside(km_entry_range *run, climber *c, int sample, const km_node *node, const double *column,
                     double way) {
  static const km_step_choice plain = {0};
  double q[KM_ARM_MOST];
  for (int k = 0; k < run->arm->n; ++k)
    q[k] = node->q[k] + way * column[k];
  km_tracker_begin(&run->walk, &run->space, sample, q, &plain, &c->probe);
  return c->probe.value;
}

static void choose(void *context, km_entry_range *run, int sample, const km_node *node, km_step_choice *way) {
  static const double h = 1e-4;
  climber *c = context;
  const km_method *method = &run->plan->method;
  double size = 0.0;
  for (int j = 0; j < run->arm->freedom; ++j) {
    const double *column = node->self + j * run->arm->n;
    double slope = (beside(run, c, sample, node, column, h) - beside(run, c, sample, node, column, -h)) / (2.0 * h);
    c->tilt[j] = method->gain * slope;
    size += c->tilt[j] * c->tilt[j];
  }
  double most = tan(method->angle);
  for (int j = 0; j < run->arm->freedom && size > most * most; ++j)
    c->tilt[j] *= most / sqrt(size);
  way->tilt = c->tilt;
}

km_status km_method_gradient(km_entry_range *run, km_error *error) {
  static const km_step_choice plain = {0};
  climber c;
  if (!km_node_create(run->arm, &run->arena, &c.probe))
    return km_fail(error, KM_MEMORY, "out of memory for a track");
  return km_run_steps(run, &plain, choose, &c, error);
}
