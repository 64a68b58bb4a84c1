/* Branch points: directions of the branches, and departure along one of them (docs/theory.md 4.10). */
#ifndef KM_LOCAL_BIFURCATION_H
#define KM_LOCAL_BIFURCATION_H

#include "kinematics/state.h"
#include "kmech/continuation.h"

/* Directions of the branches at the state's configuration: confirmed tangents that differ in more than their sense, as
 * scaled unit directions[KM_MAX_BRANCHES × columns]. Returns their number; 0 at a regular configuration; -1 when out of
 * memory. Only a few starts are tried with many freedoms. The state stays, with its pivots searched again. */
int km_branch_directions(const km_mechanism *mechanism, km_state *state, int substructure, double *directions);

/* Result of a departure from a branch point. */
typedef struct km_branch_exit {
  int branch_count; /* number of branches; 0 at a regular configuration, where the state stays; -1 when out of memory */
  bool has_further_freedoms; /* more than one freedom remains on the branch, so that a motion back would miss the branch
                             * point */
} km_branch_exit;

/* Departs from a branch point by a short step along the branch that moves the coordinate fastest. If more than one
 * freedom remains on it, the branch with the shortest step is taken: the step ends at the closed configuration nearest
 * to the branch point with the coordinate moved by at most |driver_step| (the model's unit) in its sense. */
km_branch_exit km_branch_depart(const km_mechanism *mechanism, km_state *state, int coordinate, double driver_step);

#endif
