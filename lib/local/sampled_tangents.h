/* The tangents of a substructure with many freedoms or loops: single ones, chosen at random, without a basis of them. Private
 * to kinematics/ and analysis/. */
#ifndef KM_LOCAL_SAMPLED_TANGENTS_H
#define KM_LOCAL_SAMPLED_TANGENTS_H

#include "local/second_order_columns.h"
#include "local/tangent_cone.h"

typedef struct km_sampled_tangents {
  km_tangents *f;                     /* the pose, and following directions from it */
  km_second_order_columns conditions; /* where `built` */
  bool has_conditions;
  int starts, max_starts; /* directions that were sought, and how many may be */
  double *x, *projection; /* [columns] the direction found last, unit and scaled; workspace */
} km_sampled_tangents;

/* Takes out of the scaled step x what the loops don't allow to first order, and gives the rest length 1; returns the length that
 * it had. The partition is that of the state's Jacobian. part[columns]. */
double km_tangent_project(const km_mechanism *mechanism, km_state *state, int substructure, double *x, double *part);

/* Is that so much that no basis is tried? A single tangent is always tried as it is. */
bool km_tangents_are_many(const km_tangents *tangents);

/* For tangents that were made. False when out of memory. Free in any case. */
bool km_sampled_tangents_create(km_sampled_tangents *many, km_tangents *tangents);
void km_sampled_tangents_free(km_sampled_tangents *many);

/* A random direction of the null space into x. Where all tangents but few were unreal, it would be: the real ones are a
 * closed algebraic cone, and a random direction lies in none but the whole. The state is at the pose. */
bool km_sampled_tangents_draw(km_sampled_tangents *many);
/* The same, and where the second order shows that it isn't real, one that meets the second order, sought from a start that is
 * nearly even. False where none was found, or memory is out. */
bool km_sampled_tangents_draw_second_order(km_sampled_tangents *many);
/* Is every tangent real, by random directions? `length`: how far these were followed, ahead and back. */
bool km_sampled_tangents_all_finite(km_sampled_tangents *many, double *length);
/* The next direction that meets the second order and is real, into x, and how far it was followed, ahead and back; false: none
 * was found in the starts that are left, or memory is out. The state is left at the end of the way back. */
bool km_sampled_tangents_find_next(km_sampled_tangents *many, double *length);

#endif
