/* Manipulation of a joint or a point (theory 4.14): data. Private to manipulation/. */
#ifndef KM_MANIPULATION_MANIPULATION_H
#define KM_MANIPULATION_MANIPULATION_H

#include "kinematics/state.h"
#include "kmech/continuation.h"

struct km_manipulation {
  km_arena arena;
  const km_mechanism *mechanism;
  km_state *state;
  km_driver_motion *drive; /* motion of the joint manipulated last; NULL: none */
  int driven;              /* its coordinate */
  /* Data of manipulated points. */
  int *substructures, substructure_count_on_path; /* substructures on the path from the inertial frame to the body */
  bool *is_on_path;                               /* [substructure] */
  int *tree, tree_count;                          /* free coordinates of that path outside loops */
  int *rank;                                      /* [substructure] regular rank: a lower one is singular */
  bool *has_left_branch_point;                    /* [substructure] the branch point at its start was left */
  km_vec3 *column;                                /* [coordinate] velocity of the point over L, per unit of D q̇ */
  double *A;                                      /* [3 × freedoms] velocities in the basis, column by column */
  double *w;                                      /* [freedoms] */
  double *z;                                      /* [coordinate] the step D δq */
  bool *blocked;                                  /* [coordinate] its limit is active */
  int blocking;                                   /* coordinate of the last active limit; -1: none */
  double *saved_q;                                /* [coordinate] */
  km_quaternion *saved_ball;
};

/* Checks the arguments of a pull: KM_USAGE. */
km_status km_manipulation_check(const km_manipulation *manipulation, double most, const km_manipulation_step *out,
                                km_error *error);
/* Save and restore all coordinates. */
void km_manipulation_save(km_manipulation *manipulation);
void km_manipulation_restore(km_manipulation *manipulation);

#endif
