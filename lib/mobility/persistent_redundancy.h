/* Which left null vectors of a pose last along the motion. Private to analysis/. */
#ifndef KM_MOBILITY_PERSISTENT_REDUNDANCY_H
#define KM_MOBILITY_PERSISTENT_REDUNDANCY_H

#include "mobility/left_null_space.h"

/* Which of the vectors at a pose are among those of a pose a short way along the motion too: lasting[local_count +
 * whole_count]. `local` are those of single loops, six entries each. KM_MEMORY, without a text; KM_IO: SPQR isn't
 * installed, and a large substructure needs it. */
km_status km_persistent_redundancy_find(const km_left_space *space, const km_left_null *null, const double *local,
                                        const km_left_null *nearby, bool *lasting, km_error *error);

#endif
