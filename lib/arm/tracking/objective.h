/* Objectives of a configuration on a path; larger is better (docs/theory.md 12.5). */
#ifndef KM_ARM_TRACKING_OBJECTIVE_H
#define KM_ARM_TRACKING_OBJECTIVE_H

#include "arm/arm.h"
#include "kmech/arm.h"

/* Computes values[KM_OBJECTIVES] at q[n], for which `space` was updated, with its path-control column path[n + 1]:
 * all objectives with a weight in `wanted`, or all if NULL; the others, and those from inverse dynamics, are 0. `speed`
 * is dσ/dt. */
void km_objective_values(const km_arm *arm, km_arm_space *space, const double *q, const double *path, double speed,
                         const km_objective *wanted, double *values);

/* Least 1 − |rate|/(allowed rate) over the rated joints, at joint rates [n]; 1 without rated joints. */
double km_objective_rate_margin(const km_arm *arm, const double *rates);

/* Weighted sum Σ weight · value. */
double km_objective_sum(const km_objective *objective, const double *values);
/* True if an objective from inverse dynamics has a weight (joint_effort.h). */
static inline bool km_objective_needs_forces(const km_objective *objective) {
  return objective && (objective->weight[KM_EFFORT] != 0.0 || objective->weight[KM_RELATIVE_EFFORT] != 0.0 ||
                       objective->weight[KM_ENERGY] != 0.0 || objective->weight[KM_POSITIVE_WORK] != 0.0);
}
/* True if the value of a track is the mean over its samples: of path-control, whose minimum tends to 0 with the steps,
 * and of objectives from inverse dynamics, which are integrals over the time. The value of others is the minimum. */
bool km_objective_by_mean(const km_objective *objective);

#endif
