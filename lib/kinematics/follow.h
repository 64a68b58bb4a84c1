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
  bool *turns;                          /* [column] a hinge: full turns don't count */
  double *t, *next_t, *move, *scratch;  /* [column] */
  double *last_t, *last_move, last_h;   /* the step before this pose; 0: none */
  double *origin_t, *near_t, *far_t, *branch_t;
  double *here, *origin, *near, *far, *branch_pose; /* saved poses */
  km_partition reference;               /* pivots of this pose */
  double g;                             /* see follow.c; at this pose with those pivots */
  km_branch_point branches[KM_MOST_BRANCH_POINTS];
  int branch_count;
};

#endif
