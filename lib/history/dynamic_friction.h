/* Joint friction by reactions during a motion. Private to history/. */
#ifndef KM_HISTORY_DYNAMIC_FRICTION_H
#define KM_HISTORY_DYNAMIC_FRICTION_H

#include "dynamics/dynamics.h"

typedef struct km_dynamic_friction km_dynamic_friction;

/* Lets friction coefficients of joints act in `dynamics`: −μ r N s along each coordinate, with N the normal force on
 * each of its surfaces at the present accelerations (friction_surfaces.h), r the slip arm, s the share at the slip
 * speed. Normal forces and friction are solved by fixed-point iteration. `*out` is NULL if no joint has a
 * coefficient; it borrows `dynamics` and is freed before it. KM_MEMORY. */
km_status km_dynamic_friction_create(km_dynamics *dynamics, km_dynamic_friction **out, km_error *error);
void km_dynamic_friction_free(km_dynamic_friction *friction);

#endif
