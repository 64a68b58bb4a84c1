/* Poses to come back to, and derivatives of accelerations. Private to dynamics/. */
#ifndef KM_DYNAMICS_LINEARISATION_H
#define KM_DYNAMICS_LINEARISATION_H

#include "dynamics/dynamics.h"
#include "kmech/dynamics.h"

/* A state to come back to, with its independent coordinates. */
typedef struct km_rest_pose {
  km_arena arena;
  int freedom;
  double step;          /* of differences, radians or characteristic lengths */
  int *independent;     /* [freedom] coordinates */
  double *q, *rate;     /* [coordinate] */
  double *acceleration; /* [coordinate] workspace */
  km_quaternion *ball;
} km_rest_pose;

/* After an evaluation. False when out of memory. */
bool km_poise_take(const km_dynamics *dynamics, const km_state *state, km_rest_pose *out);
void km_poise_restore(const km_rest_pose *poise, const km_mechanism *mechanism, km_state *state);
void km_poise_free(km_rest_pose *poise);

/* Adds to a coordinate, radians or the model's length; of a ball a turn about that axis of its parent frame. */
void km_nudge(const km_mechanism *mechanism, km_state *state, int coordinate, double by);

/* K_ij: derivative of the acceleration of independent coordinate i by independent coordinate j, at rest or not.
 * work[2 freedom], K[freedom²] column-major. False where an evaluation fails. */
bool km_stiffness_of_accelerations(km_dynamics *dynamics, km_state *state, const km_rest_pose *poise, double *work,
                                   double *K);

#endif
