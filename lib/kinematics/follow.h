/* A motion that is being followed. Private to kinematics/. */
#ifndef KM_KINEMATICS_FOLLOW_H
#define KM_KINEMATICS_FOLLOW_H

#include "kinematics/state.h"
#include "kmech/follow.h"

struct km_follow {
  km_arena arena;
  const km_mechanism *mechanism;
  km_state *state;
  int substructure, freedom;
  double s, largest; /* arc length so far; the step that step control allows now */
  bool closed, ignore_limits;
  int limit;                            /* the coordinate whose limit ended the motion, -1 */
  double *t, *next_t, *move, *scratch;  /* [column] */
  double *last_t, *last_move, last_h;   /* the step before this pose; 0: none */
  double *origin_t, *near_t, *far_t, *branch_t;
  double *here, *origin, *near, *far, *branch_pose; /* saved poses */
  km_partition reference;               /* pivots of this pose */
  double g;                             /* see follow.c; at this pose with those pivots */
  km_branch_point branch;               /* passed during the last advance, if `branched` */
  bool branched;
};

/* Puts the state at the branch point that was passed last; `tangent` is that of the smooth motion there. Then
 * km_follow_turn or km_follow_go_on. */
void km_follow_at_branch(km_follow *follow, double *tangent);
/* Puts the state back to where the smooth motion has come to. */
void km_follow_go_on(km_follow *follow);
/* Continues from the branch point along another direction (scaled step). */
void km_follow_turn(km_follow *follow, const double *direction);

#endif
