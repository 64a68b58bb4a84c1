/* The partition of a pose, kept while others are tried. Private to kinematics/ and analysis/. */
#ifndef KM_LOCAL_PARTITION_STASH_H
#define KM_LOCAL_PARTITION_STASH_H

#include "kinematics/state.h"

/* From here on the state's partition of a large substructure is another one, which begins with the same pivots, until
 * km_partition_unstash: what was found at the pose needn't be found there again. Without memory for it, and of small ones, it stays. */
void km_partition_stash(km_state *state, int substructure);
void km_partition_unstash(km_state *state, int substructure);

#endif
