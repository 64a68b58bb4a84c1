/* Massless free motions. Private to the library. */
#ifndef KM_MOBILITY_MASSLESS_MOTIONS_H
#define KM_MOBILITY_MASSLESS_MOTIONS_H

#include "kinematics/state.h"

/* Finds out whether the substructure has a free motion that moves no mass: Nᵀ M N is singular, and a simulation has
 * no equation for it. Mobility and body poses must be current. KM_MEMORY. Cost: O(bodies · depth · freedom +
 * freedom³). */
km_status km_has_massless_motion(const km_mechanism *mechanism, km_state *state, int substructure, bool *is_massless,
                                 km_error *error);

#endif
