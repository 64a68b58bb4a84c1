/* Motions without inertia. Private to analysis/. */
#ifndef KM_MOBILITY_MASSLESS_MOTIONS_H
#define KM_MOBILITY_MASSLESS_MOTIONS_H

#include "kinematics/state.h"

/* Can the substructure move without moving any mass? Then a simulation has no equation for that motion. The generalised
 * masses of its free motions, Nᵀ M N, are singular there. At a pose whose mobility and body poses are up to date.
 * KM_MEMORY. O(bodies · depth · freedom + freedom³). */
km_status km_moves_no_mass(const km_mechanism *mechanism, km_state *state, int substructure, bool *inert,
                           km_error *error);

#endif
