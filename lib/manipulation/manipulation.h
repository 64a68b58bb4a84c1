/* A hand and what it remembers of its way. Private to analysis/. */
#ifndef KM_MANIPULATION_MANIPULATION_H
#define KM_MANIPULATION_MANIPULATION_H

#include "kinematics/state.h"
#include "kmech/continuation.h"

struct km_manipulation {
  km_arena arena;
  const km_mechanism *mechanism;
  km_state *state;
  km_driver_motion *drive; /* of the joint that was pulled last; NULL: none */
  int driven;              /* its coordinate */
  /* Of pulled points. */
  int *ways, way_count; /* substructures on the way from the inertial frame to the body */
  bool *on_way;         /* [substructure] */
  int *rank;            /* [substructure] the largest rank so far: less is a singular pose */
  bool *left;           /* [substructure] a branch point that it started from has been left */
  km_vec3 *column;      /* [coordinate] velocity of the point over L, per unit of D q̇ */
  double *A;            /* [3 × freedoms] the same in the basis, column by column */
  double *w;            /* [freedoms] */
  double *z;            /* [coordinate] the step, D δq */
  double *barrier;      /* [coordinate × …] grows: rows of limits that are pushed against, orthonormal */
  size_t barrier_room;  /* doubles in `barrier` */
  bool *blocked;        /* [coordinate] at its limit, and pushed against */
  int blocking;         /* the last of them; -1: none */
  double *saved_q;      /* [coordinate] */
  km_quaternion *saved_ball;
};

/* Keeps the coordinates, and brings them back. */
void km_manipulation_save(km_manipulation *hand);
void km_manipulation_restore(km_manipulation *hand);

#endif
