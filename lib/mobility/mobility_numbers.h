/* Mobility numbers of single substructures, for sweeps; ranks without numbers. */
#ifndef KM_MOBILITY_MOBILITY_NUMBERS_H
#define KM_MOBILITY_MOBILITY_NUMBERS_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

/* Updates the motions of a substructure from the partition that its last closing left. If a driver forced a badly
 * conditioned partition, pivots are searched again without it. */
void km_motions_update(const km_mechanism *mechanism, km_state *state, int substructure);

/* Does km_motions_update and computes the mobility numbers. */
void km_numbers_update(const km_mechanism *mechanism, km_state *state, int substructure);

/* Does km_mobility_compute without the mobility numbers, which keep their values. `basis`: use of the null space. */
void km_ranks_update(const km_mechanism *mechanism, km_state *state, km_factor_basis basis, km_mobility *out);

/* Returns KM_MEMORY if a partition of the state or its basis had no memory; its pivots are then invalid and searched
 * by the next call. */
km_status km_mobility_check_memory(const km_mechanism *mechanism, km_state *state);

#endif
