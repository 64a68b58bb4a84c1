/* Friction by what presses joints' surfaces together, in a motion. Private to analysis/. */
#ifndef KM_HISTORY_DYNAMIC_FRICTION_H
#define KM_HISTORY_DYNAMIC_FRICTION_H

#include "dynamics/dynamics.h"

typedef struct km_dynamic_friction km_dynamic_friction;

/* Makes joints' coefficients of friction act in `dynamics`: −μ r N s along each coordinate, N the normal force on each
 * of its surfaces at the present accelerations (friction_surfaces.h), r the way that they slide in a unit of it, s the share that acts
 * at the surfaces' speed. What presses depends on the friction: both are found together, by iteration. `*out`
 * is NULL where no joint has a coefficient; it borrows `dynamics` and is freed before it. KM_MEMORY. */
km_status km_dynamic_friction_create(km_dynamics *dynamics, km_dynamic_friction **out, km_error *error);
void km_dynamic_friction_free(km_dynamic_friction *rubbing);

#endif
