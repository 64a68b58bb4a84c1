/* Objectives of a configuration on a path: path control, manipulability, least singular value, limit distance, joint
 * travel, rate margin, clearance (docs/theory.md 12.5). */
#include "arm/tracking/objective.h"

bool km_objective_by_mean(const km_objective *objective) {
  return km_objective_single(objective) == KM_PATH_CONTROL || km_objective_needs_forces(objective);
}

static double smallest_entry(const double *path, int n) {
  double least = fabs(path[0]);
  for (int i = 1; i <= n; ++i)
    least = fabs(path[i]) < least ? fabs(path[i]) : least;
  return least;
}

double km_objective_rate_margin(const km_arm *a, const double *rates) {
  double least = 1.0;
  for (int k = 0; k < a->n; ++k)
    if (a->rate[k] < (double)INFINITY)
      least = fmin(least, 1.0 - fabs(rates[k]) / a->rate[k]);
  return least;
}

/* Rate margin at the minimum-norm rates that follow the path: path[k]/z · speed. */
static double rate_margin(const km_arm *a, const double *path, double speed) {
  double rates[KM_ARM_MAX_JOINTS], z = path[a->n];
  for (int k = 0; k < a->n; ++k)
    rates[k] = z > 0.0 ? path[k] / z * speed : (double)INFINITY;
  return km_objective_rate_margin(a, rates);
}

void km_objective_values(const km_arm *a, km_arm_space *s, const double *q, const double *path, double speed,
                         const km_objective *wanted, double *values) {
  bool use[KM_OBJECTIVES];
  for (int k = 0; k < KM_OBJECTIVES; ++k) {
    use[k] = !wanted || wanted->weight[k] != 0.0;
    values[k] = 0.0;
  }
  if (use[KM_PATH_CONTROL])
    values[KM_PATH_CONTROL] = smallest_entry(path, a->n);
  if (use[KM_MANIPULABILITY] || use[KM_SINGULAR_VALUE]) {
    double sigma[KM_ARM_ROWS], product = 1.0;
    km_arm_singular_values(a, s, sigma);
    for (int r = 0; r < a->rows; ++r)
      product *= sigma[r];
    values[KM_MANIPULABILITY] = product;
    values[KM_SINGULAR_VALUE] = sigma[a->rows - 1];
  }
  if (use[KM_LIMIT_DISTANCE])
    values[KM_LIMIT_DISTANCE] = km_arm_limit_distance(a, q);
  if (use[KM_JOINT_TRAVEL])
    values[KM_JOINT_TRAVEL] = path[a->n];
  if (use[KM_RATE_MARGIN])
    values[KM_RATE_MARGIN] = rate_margin(a, path, speed);
  if (use[KM_BODY_CLEARANCE] && s->state)
    values[KM_BODY_CLEARANCE] = km_arm_clearance(a, s, q);
}

double km_objective_sum(const km_objective *objective, const double *values) {
  double sum = 0.0;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (objective->weight[k] != 0.0)
      sum += objective->weight[k] * values[k];
  return sum;
}
