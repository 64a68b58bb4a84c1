/* Minimum-norm steps and rates in the metric D (docs/theory.md 3.5), and the choice of their equations. */
#ifndef KM_KINEMATICS_MINIMUM_NORM_STEP_H
#define KM_KINEMATICS_MINIMUM_NORM_STEP_H

#include "kinematics/state.h"

/* Number of null vectors that do not move the driver. */
static inline int km_count_free_motions(const km_factor *p, int driver) {
  return km_factor_freedom(p) - (driver >= 0 && !km_factor_has_forced_pivot(p));
}

/* Minimum-norm step: x <- x − D⁻¹ Z Zᵀ D x over the null vectors that do not move the driver (docs/theory.md 3.5). */
void km_minimum_norm_step(const km_mechanism *mechanism, km_state *state, int substructure, int driver, double *x);

/* Minimum-norm rates of an independent driver: t_driver = 1, J t = 0, |D t| minimal (docs/theory.md 3.5). */
void km_minimum_norm_rates(const km_mechanism *mechanism, km_state *state, int substructure, int driver, double *t);

/* (D a)·(D b) of two scaled steps. */
double km_step_dot(const km_mechanism *mechanism, const km_substructure *sub, const double *a, const double *b);
/* |D x| of a scaled step. */
double km_step_length(const km_mechanism *mechanism, const km_substructure *sub, const double *x);

#endif
