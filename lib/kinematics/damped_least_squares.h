/* Levenberg-Marquardt closing of a substructure from a poor start (docs/theory.md 4.3). */
#ifndef KM_KINEMATICS_DAMPED_LEAST_SQUARES_H
#define KM_KINEMATICS_DAMPED_LEAST_SQUARES_H

#include "kinematics/state.h"

/* Minimises |e(q)|² + 1e-10 |δ|², δ the scaled step from the start, by Levenberg-Marquardt with trust region
 * (gsl_multifit_nlinear). Moves the state to the minimum, closed or not. Allocates. KM_MEMORY or KM_OK. */
km_status km_damped_least_squares(const km_mechanism *mechanism, km_state *state, int substructure, km_error *error);

#endif
