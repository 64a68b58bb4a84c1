/* The partition of a pose, kept while others are tried. Private to kinematics/ and analysis/. */
#ifndef KM_LOCAL_PARTITION_STASH_H
#define KM_LOCAL_PARTITION_STASH_H

#include "kinematics/state.h"

/* From here on the state's partition of a large substructure is another one, which begins with the same pivots, until
 * km_state_take_back: what was found at the pose needn't be found there again. Without memory for it, and of small ones, it stays. */
void km_state_set_aside(km_state *state, int substructure);
void km_state_take_back(km_state *state, int substructure);

#endif
