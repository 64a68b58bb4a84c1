/* The kinematic model of a mechanism with changed joint types (theory 7.5). Private to the library. */
#ifndef KM_MOBILITY_REMEDIES_CHANGED_MODEL_H
#define KM_MOBILITY_REMEDIES_CHANGED_MODEL_H

#include "kmech/mobility.h"

/* Creates a model with the bodies, frames, joints, couplings and holds of the mechanism and the joints of `set`
 * changed, which starts at the configuration values[coordinate count] (file's units). Masses, forces and shapes are
 * left out. The caller frees `*out`. KM_USAGE: a change isn't an option of its joint; KM_MEMORY. */
km_status km_changed_model(const km_mechanism *mechanism, const double *values, const km_remedy_set *set,
                           km_model **out, km_error *error);

#endif
