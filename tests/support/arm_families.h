/* Families of random arms and paths with a truth of their own. Each member is made from its seed alone. A family's test
 * is true where the library keeps what it promises; else `why` says what went wrong. */
#ifndef KM_TESTS_ARM_FAMILIES_H
#define KM_TESTS_ARM_FAMILIES_H

#include "support/arms.h"

#include "base/text.h"

typedef enum arm_shape { ARM_GENERAL, ARM_MEETING, ARM_PARALLEL } arm_shape;

/* A random arm of n revolute joints whose axes first, first + 1, first + 2 intersect in a point or are parallel;
 * `roomy`: limits are wider than a turn, otherwise random or absent. Body "hand", frame "tool". */
fixture random_arm(randomness *r, int n, arm_shape shape, int first, bool limited, bool roomy);

/* An arm of n hinges by Denavit and Hartenberg's parameters, each {α, a, d}; limits ±limit[k], none where that is 0.
 * The base is turned by π about x if `hangs`. Bodies l0 … ln, frame "t". */
fixture dh_arm(const double (*dh)[3], int n, const double *limit, bool hangs);

/* The time of a path: each sample takes as long as the slower of the travel of the effector's origin and its turn, both
 * found from many poses; the lengths are those. */
bool family_path_times(uint64_t seed, char *why, size_t size);
/* Tracks that leave the workspace: no row breaks a rate or a limit, and what is named as the end is there. */
bool family_workspace_edge(uint64_t seed, char *why, size_t size);

/* Dynamic programming on a Kinova Gen3 with rate limits, past singular configurations and limits: its work is
 * bounded, its rows satisfy the constraints, and it completes paths that greedy completes. */
bool family_dp_work(uint64_t seed, char *why, size_t size);
/* Six hinges, of three kinds: every pose of the list reaches the target by the bodies' poses; with axes that meet or
 * are parallel the count is confirmed; and where it is, thousands of random starts of Newton's method find no other
 * pose. */
bool family_six_hinges(uint64_t seed, char *why, size_t size);
/* Seven hinges: where the count is confirmed, every pose that random starts find lies on a component of the list. */
bool family_seven_hinges(uint64_t seed, char *why, size_t size);
/* Seven revolute joints, some with limits wider than a turn: a self-motion has the same arcs from any of its
 * configurations, at any turn; and every solution of random starts, at every turn within the limits, lies on an arc
 * of the branches. */
bool family_turns(uint64_t seed, char *why, size_t size);

#endif
