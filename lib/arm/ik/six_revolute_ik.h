/* All poses of six hinges that reach a pose of the hand, in closed form, where three neighbouring axes meet in a point
 * or are parallel (Pieper 1968). */
#ifndef KM_ARM_IK_SIX_REVOLUTE_IK_H
#define KM_ARM_IK_SIX_REVOLUTE_IK_H

#include "arm/arm.h"

enum { KM_SIX = 6, KM_SIX_MOST = 32 };

typedef enum km_hinge_group { KM_GROUP_NONE, KM_GROUP_MEETING, KM_GROUP_PARALLEL } km_hinge_group;

/* A line that a hinge turns about, and the turn. */
typedef struct km_hinge {
  km_vec3 axis, point;
} km_hinge;

/* Six hinges at the pose from which their angles are counted. */
typedef struct km_six_hinges {
  km_hinge hinges[KM_SIX];
  int column[KM_SIX];   /* of the arm */
  km_pose hand;         /* there */
  km_hinge_group group; /* of the hinges first, first + 1, first + 2 */
  int first;
  km_vec3 centre; /* MEETING: where the axes meet */
} km_six_hinges;

/* The arm's six hinges at q[n], `held` (−1: none) staying where it is, and the first group of them that serves. False:
 * they aren't six hinges, or none does. The space stands at q then. */
bool km_six_hinges_find(const km_arm *arm, km_arm_space *space, const double *q, int held, km_six_hinges *out);

/* Turns of the hinges, counted from that pose, that bring the hand to `target`: turns[at most KM_SIX_MOST], to about
 * the root of rounding, with some beside them that nearly do: Newton's method tells. −1: they aren't single poses. */
int km_six_hinges_solve(const km_six_hinges *six, const km_pose *target, double (*turns)[KM_SIX]);

#endif
