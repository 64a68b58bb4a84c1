/* The motions that meet at a branch point. Private to analysis/. */
#ifndef KM_ANALYSIS_BRANCHES_H
#define KM_ANALYSIS_BRANCHES_H

#include "kinematics/state.h"

enum { KM_MOST_BRANCHES = 16 };

/* Where several motions meet at the state's pose: those that differ in more than their sense, as unit directions
 * (scaled steps) into directions[KM_MOST_BRANCHES × columns]. Returns their number, 0 at a regular pose; the state
 * stays, with its pivots searched afresh. */
int km_branch_directions(const km_mechanism *mechanism, km_state *state, int substructure, double *directions);

#endif
