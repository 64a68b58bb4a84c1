/* What is good about a pose on the path. */
#ifndef KM_ARM_TRACKING_OBJECTIVE_H
#define KM_ARM_TRACKING_OBJECTIVE_H

#include "arm/arm.h"
#include "kmech/arm.h"

/* At the pose where `space` stands (Jacobian, path column), with its path-control column path[n + 1]: every
 * objective with a weight, or all of them for NULL, into values[KM_OBJECTIVES]; the others 0. `speed` is dσ/dt. */
void km_objective_values(const km_arm *arm, km_arm_space *space, const double *q, const double *path, double speed,
                         const km_objective *wanted, double *values);

/* min over rated joints of 1 − |rate|/(what it may), at joint rates [n]. */
double km_objective_rate_margin(const km_arm *arm, const double *rates);

/* Σ weight · value. */
double km_objective_sum(const km_objective *objective, const double *values);
/* Over a path its min counts; of path-control, whose min tends to 0 with the steps, the mean. */
bool km_objective_by_mean(const km_objective *objective);

#endif
