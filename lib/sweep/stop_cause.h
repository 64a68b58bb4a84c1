/* Why a driver can go no further. Private to analysis/. */
#ifndef KM_SWEEP_STOP_CAUSE_H
#define KM_SWEEP_STOP_CAUSE_H

#include "kinematics/state.h"

/* At a dead point of the driver, a coordinate of the substructure: "links a and b of loop 1 are in line (joints B, C, D)", or
 * the joints whose axes have become dependent. The caller frees it (km_free); NULL where the substructure is large, or when out
 * of memory. O(rows³). */
char *km_stop_cause(const km_mechanism *mechanism, km_state *state, int substructure, int driver);

#endif
