/* Persistent left null vectors. Private to mobility/. */
#ifndef KM_MOBILITY_PERSISTENT_REDUNDANCY_H
#define KM_MOBILITY_PERSISTENT_REDUNDANCY_H

#include "mobility/left_null_space.h"

/* Marks the vectors that are also left null vectors at a neighbouring configuration: persistent[local_count +
 * spanning_count]. KM_MEMORY, without a text; KM_IO: SPQR is not installed, and a large substructure needs it. */
km_status km_persistent_redundancy_find(const km_left_space *space, const km_left_null *null,
                                        const km_left_null *neighbour, bool *persistent, km_error *error);

#endif
