/* Bodies in the inertial frame. */
#ifndef KM_KINEMATICS_POSES_H
#define KM_KINEMATICS_POSES_H

#include "kinematics/state.h"
#include "kmech/kinematics.h"

/* Twist of a body against the next one towards the inertial frame, expressed in the inertial frame and taken
 * at its origin, from the rates of all coordinates (radians, model's length). After km_poses_update. */
km_twist km_body_twist(const km_mechanism *mechanism, const km_state *state, int body, const double *rates);

#endif
