/* Stashes the partition of a configuration and restores it. Private to local/. */
#ifndef KM_LOCAL_PARTITION_STASH_H
#define KM_LOCAL_PARTITION_STASH_H

#include "kinematics/state.h"

/* Replaces the state's partition of a large substructure by a second one with the same pivots until
 * km_factor_unstash, so that the factorisation of the configuration need not be repeated. Without memory, and for
 * small substructures, nothing changes. */
void km_factor_stash(km_state *state, int substructure);
void km_factor_unstash(km_state *state, int substructure);

#endif
