/* All configurations of six hinges that reach an effector pose, in closed form, if three neighbouring axes are
 * concurrent or parallel (D. Pieper 1968; docs/theory.md 12.9). */
#ifndef KM_ARM_IK_SIX_REVOLUTE_IK_H
#define KM_ARM_IK_SIX_REVOLUTE_IK_H

#include "arm/arm.h"

enum { KM_SIX = 6, KM_SIX_MAX_SOLUTIONS = 32 };

typedef enum km_hinge_group { KM_GROUP_NONE, KM_GROUP_CONCURRENT, KM_GROUP_PARALLEL } km_hinge_group;

/* Axis of a hinge: unit direction and a point. */
typedef struct km_hinge {
  km_vec3 axis, point;
} km_hinge;

/* Six hinges at the configuration from which their angles are counted. */
typedef struct km_six_hinges {
  km_hinge hinges[KM_SIX];
  int column[KM_SIX];   /* columns of the arm */
  km_pose effector;     /* effector pose at that configuration */
  km_hinge_group group; /* group of the hinges first, first + 1, first + 2 */
  int first;
  km_vec3 centre; /* CONCURRENT: common point of the axes */
} km_six_hinges;

/* Reads the axes of the arm's six hinges at q[n], except the joint `fixed` (−1: none), and finds the first
 * concurrent or parallel group. False: not six hinges, or no group. The space is updated for q. */
bool km_six_hinges_find(const km_arm *arm, km_arm_space *space, const double *q, int fixed, km_six_hinges *out);

/* Computes the hinge angles, counted from that configuration, at which the effector reaches `target`: angles[at most
 * KM_SIX_MAX_SOLUTIONS], accurate to about √ε. Approximate solutions are included; Newton's method must verify them.
 * Returns their number; −1: solutions aren't isolated. */
int km_six_hinges_solve(const km_six_hinges *six, const km_pose *target, double (*angles)[KM_SIX]);

#endif
