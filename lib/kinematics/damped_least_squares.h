/* Damped least squares from a poor start, for Newton to polish. */
#ifndef KM_KINEMATICS_DAMPED_LEAST_SQUARES_H
#define KM_KINEMATICS_DAMPED_LEAST_SQUARES_H

#include "kinematics/state.h"

/* Levenberg-Marquardt (gsl_multifit_nlinear) on the substructure's errors, with a faint pull to the start.
 * Moves the state to where the errors are least; allocates. KM_MEMORY or KM_OK, converged or not. */
km_status km_damped_least_squares(const km_mechanism *mechanism, km_state *state, int substructure, km_error *error);

#endif
