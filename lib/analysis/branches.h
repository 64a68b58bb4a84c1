/* The motions that meet at a branch point. Private to analysis/. */
#ifndef KM_ANALYSIS_BRANCHES_H
#define KM_ANALYSIS_BRANCHES_H

#include "kinematics/state.h"

/* Real motions through the state's pose, different up to their sense: unit directions (scaled steps) into
 * directions[most × columns]. Returns their number; the state stays. */
int km_branch_directions(const km_mechanism *mechanism, km_state *state, int substructure, double *directions,
                         int most);

#endif
