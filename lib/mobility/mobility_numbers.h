/* Mobility numbers of one substructure at a time, for sweeps; ranks alone. */
#ifndef KM_MOBILITY_MOBILITY_NUMBERS_H
#define KM_MOBILITY_MOBILITY_NUMBERS_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

/* What moves in a substructure, by the partition that its last closure left. Where a driver forced a badly conditioned partition,
 * pivots are searched again without it. */
void km_motions_update(const km_mechanism *mechanism, km_state *state, int substructure);

/* The same with its mobility numbers. */
void km_numbers_update(const km_mechanism *mechanism, km_state *state, int substructure);

/* km_mobility_compute without the mobility numbers, which it leaves as they are. */
void km_ranks_update(const km_mechanism *mechanism, km_state *state, km_mobility *out);

/* KM_MEMORY: a partition of the state, or its basis, found no memory. Its pivots are forgotten then, so that the next request searches
 * them anew. */
km_status km_mobility_memory(const km_mechanism *mechanism, km_state *state);

#endif
