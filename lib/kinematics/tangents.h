/* The tangents of a substructure at one pose, and which of them are real: those that a motion follows. Private to
 * kinematics/ and analysis/. */
#ifndef KM_KINEMATICS_TANGENTS_H
#define KM_KINEMATICS_TANGENTS_H

#include "kinematics/second_order.h"

#include <stdint.h>

enum { KM_STARTS_PER_FREEDOM = 40 };

typedef struct km_tangents {
  const km_mechanism *m;
  km_state *s;
  int index;
  const km_substructure *sub;
  km_second_order conditions;
  double *pose, *last; /* saved coordinates */
  double *x, *move, *work;
  double *a; /* [freedom] a tangent by its share of each column of Z */
  uint64_t random;
} km_tangents;

/* At the state's pose, which `pose` keeps. False when out of memory. */
bool km_tangents_make(km_tangents *tangents, const km_mechanism *mechanism, km_state *state, int substructure,
                      km_arena *arena);
/* -1 … 1, always the same sequence. */
double km_tangents_uniform(km_tangents *tangents);
void km_tangents_normalise(double *a, int freedom);
/* Scaled unit direction D⁻¹Z a. */
void km_tangents_direction(const km_tangents *tangents, const double *a, double *x);
/* Follows a tangent from the pose, `sign` ahead or back, by predicting each step from the last: the arc length to which
 * the loops could be closed, up to `length`. The state is left at the end. */
double km_tangents_follow(km_tangents *tangents, const double *a, double sign, double length);
/* Can it be followed a short way, ahead and back? */
bool km_tangents_is_real(km_tangents *tangents, const double *a);
/* Are the basis vectors and as many random combinations of them all real? */
bool km_tangents_all_real(km_tangents *tangents);
/* A random tangent that meets the second order and is real, into `a`; false if the start leads to none. */
bool km_tangents_random(km_tangents *tangents);

#endif
