#include "arm/objective.h"

#include <string.h>

static const char *const words[KM_OBJECTIVES] = {"path-control",   "manipulability", "singular-value",
                                                 "limit-distance", "joint-travel",   "rate-margin"};

static bool known(km_objective_kind kind) {
  return (unsigned)kind < KM_OBJECTIVES;
}

const char *km_objective_word(km_objective_kind kind) {
  if (!known(kind))
    return "";
  return words[kind];
}

int km_objective_find(const char *word) {
  if (!word)
    return -1;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (strcmp(words[k], word) == 0)
      return k;
  return -1;
}

km_objective km_objective_of(km_objective_kind kind) {
  km_objective objective = {{0}};
  if (known(kind))
    objective.weight[kind] = 1.0;
  return objective;
}

/* The only kind with weight 1 and no other, -1: a sum. */
static int single(const km_objective *objective) {
  int found = -1, count = 0;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (objective->weight[k] != 0.0) {
      found = k;
      ++count;
    }
  return count == 1 && objective->weight[found] == 1.0 ? found : -1;
}

const char *km_objective_name(const km_objective *objective) {
  if (!objective)
    return "";
  int kind = single(objective);
  return kind < 0 ? "weighted" : words[kind];
}

bool km_objective_by_mean(const km_objective *objective) {
  return single(objective) == KM_PATH_CONTROL;
}

static double smallest_entry(const double *path, int n) {
  double least = fabs(path[0]);
  for (int i = 1; i <= n; ++i)
    least = fmin(least, fabs(path[i]));
  return least;
}

double km_objective_rate_margin(const km_arm *a, const double *rates) {
  double least = 1.0;
  for (int k = 0; k < a->n; ++k)
    if (a->rate[k] < (double)INFINITY)
      least = fmin(least, 1.0 - fabs(rates[k]) / a->rate[k]);
  return least;
}

/* At the least rates that follow the path. */
static double rate_margin(const km_arm *a, const double *path, double speed) {
  double rates[KM_ARM_MOST], z = path[a->n];
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
}

double km_objective_sum(const km_objective *objective, const double *values) {
  double sum = 0.0;
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (objective->weight[k] != 0.0)
      sum += objective->weight[k] * values[k];
  return sum;
}
