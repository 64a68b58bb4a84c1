/* The motions that meet at a branch point. Private to kinematics/ and analysis/. */
#ifndef KM_LOCAL_BIFURCATION_H
#define KM_LOCAL_BIFURCATION_H

#include "kinematics/state.h"
#include "kmech/continuation.h"

/* Where several motions meet at the state's pose: those that differ in more than their sense, as unit directions
 * (scaled steps) into directions[KM_MAX_BRANCHES × columns]. Returns their number, 0 at a regular pose, -1 when out of
 * memory; of many freedoms those that a few starts find; the state stays, with its pivots searched afresh. */
int km_branch_directions(const km_mechanism *mechanism, km_state *state, int substructure, double *directions);

/* How a branch point was left. */
typedef struct km_branch_exit {
  int branch_count; /* that meet there; 0 at a regular pose, where the state stays; -1 when out of memory */
  bool
      has_further_freedoms; /* more freedoms than one are left on the motion that was taken: on the way back it would miss the branch point */
} km_branch_exit;

/* At a branch point no direction is the mechanism's own: a short step leads onto the motion that moves the coordinate
 * most, from where the branch point can be passed smoothly. Where more freedoms than one are left on that motion, it is the
 * shortest found: the step ends at the closed pose closest to the branch point that has the coordinate moved by `way` (of the
 * model's unit) at most, to that side. */
km_branch_exit km_branch_depart(const km_mechanism *mechanism, km_state *state, int coordinate, double way);

#endif
