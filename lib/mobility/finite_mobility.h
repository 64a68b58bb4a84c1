/* Finite mobility for known passive freedoms (theory 6.4). Private to the library. */
#ifndef KM_MOBILITY_FINITE_MOBILITY_H
#define KM_MOBILITY_FINITE_MOBILITY_H

#include "kmech/mobility.h"

/* As km_finite_mobility_find, for known passive freedoms. Requires *out = {0} and poses and ranks of the configuration,
 * which km_passive_freedoms_find leaves. */
km_status km_finite_mobility_find_with(const km_mechanism *mechanism, km_state *state,
                                       const km_passive_freedoms *passive, km_progress progress, void *context,
                                       km_finite_mobility *out, km_error *error);

#endif
