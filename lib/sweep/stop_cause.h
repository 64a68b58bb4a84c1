/* Cause of a dead point of the driver (theory 10.5). Private to sweep/. */
#ifndef KM_SWEEP_STOP_CAUSE_H
#define KM_SWEEP_STOP_CAUSE_H

#include "kinematics/state.h"

/* Describes the cause of a dead point of the driver, a coordinate of the substructure: "links a and b of loop 1 are
 * in line (joints B, C, D)", or the joints whose axes have become dependent. The caller frees the text (km_free);
 * NULL for a large substructure or without memory. O(rows³). */
char *km_stop_cause(const km_mechanism *mechanism, km_state *state, int substructure, int driver);

#endif
