/* Finite mobility for known passive freedoms (theory 6.4). Private to the library. */
#ifndef KM_MOBILITY_FINITE_MOBILITY_H
#define KM_MOBILITY_FINITE_MOBILITY_H

#include "kmech/mobility.h"

/* Does km_finite_mobility_find with the passive freedoms of the state's configuration. `*out` is all 0 before. */
km_status km_finite_mobility_find_with(const km_mechanism *mechanism, km_state *state,
                                       const km_passive_freedoms *passive, km_progress progress, void *context,
                                       km_finite_mobility *out, km_error *error);

#endif
