/* A set of remedies for a known finite mobility (theory 7.5). Private to the library. */
#ifndef KM_MOBILITY_REMEDIES_REMEDY_SET_H
#define KM_MOBILITY_REMEDIES_REMEDY_SET_H

#include "kmech/mobility.h"

/* Does km_remedy_set_find with the finite mobility; -1: it is unknown. `*out` is all 0 before. */
km_status km_remedy_set_find_with(const km_mechanism *mechanism, km_state *state, int finite_mobility,
                                  km_progress progress, void *context, km_remedy_set *out, km_error *error);

#endif
