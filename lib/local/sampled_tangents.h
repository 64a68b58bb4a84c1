/* Tangents of a substructure with many freedoms or loops: random single directions without a basis (docs/theory.md
 * 5.5). */
#ifndef KM_LOCAL_SAMPLED_TANGENTS_H
#define KM_LOCAL_SAMPLED_TANGENTS_H

#include "local/second_order_columns.h"
#include "local/tangent_cone.h"

typedef struct km_sampled_tangents {
  km_tangents *f;                     /* configuration, and following of directions */
  km_second_order_columns conditions; /* if has_conditions */
  bool has_conditions;
  int starts, max_starts; /* number of starts, and its bound */
  double *x, *projection; /* [columns] direction found last, scaled, of unit length; workspace */
} km_sampled_tangents;

/* Projects the scaled step x onto the null space of J and normalises it, |D x| = 1. Returns the length before. The
 * partition belongs to the state's Jacobian. projection[columns] is workspace. */
double km_tangent_project(const km_mechanism *mechanism, km_state *state, int substructure, double *x,
                          double *projection);

/* True if random single tangents replace a basis, because the freedom or the number of rows is large. False for a
 * single freedom. */
bool km_tangents_are_many(const km_tangents *tangents);

/* Creates the sampler for created tangents. False when out of memory. Free it in any case. */
bool km_sampled_tangents_create(km_sampled_tangents *sample, km_tangents *tangents);
void km_sampled_tangents_free(km_sampled_tangents *sample);

/* Draws a random direction of the null space, into x. The finite tangents are a closed algebraic cone, and a random
 * direction lies in a proper subcone with probability 0. The state is at the configuration. */
bool km_sampled_tangents_draw(km_sampled_tangents *sample);
/* Draws a random direction; if it violates the second order, one that satisfies it is sought from a nearly uniform
 * start. False if none was found, or out of memory. */
bool km_sampled_tangents_draw_second_order(km_sampled_tangents *sample);
/* True if every tangent is finite, by random directions. `length`: length to which they were followed, ahead and
 * back. */
bool km_sampled_tangents_all_finite(km_sampled_tangents *sample, double *length);
/* Finds the next direction that satisfies the second order and is finite, into x, and its followed length. False if the
 * remaining starts find none, or out of memory. The state is left at the end of the curve back. */
bool km_sampled_tangents_find_next(km_sampled_tangents *sample, double *length);

#endif
