/* Stored configurations, and derivatives of accelerations by finite differences. Private to dynamics/. */
#ifndef KM_DYNAMICS_LINEARISATION_H
#define KM_DYNAMICS_LINEARISATION_H

#include "dynamics/dynamics.h"
#include "kmech/dynamics.h"

/* Stored configuration and rates with the independent coordinates, to be restored after differences. */
typedef struct km_stored_configuration {
  km_arena arena;
  int freedom;
  double step;          /* step of differences, radians or characteristic lengths */
  int *independent;     /* [freedom] coordinates */
  double *q, *rate;     /* [coordinate] */
  double *acceleration; /* [coordinate] work array */
  km_quaternion *ball;
} km_stored_configuration;

/* Stores the state; requires an evaluation. False: out of memory. */
bool km_stored_configuration_create(const km_dynamics *dynamics, const km_state *state, km_stored_configuration *out);
void km_stored_configuration_restore(const km_stored_configuration *stored, const km_mechanism *mechanism,
                                     km_state *state);
void km_stored_configuration_free(km_stored_configuration *stored);

/* Adds an increment to a coordinate, radians or the model's length unit; for a ball, a rotation about that axis of
 * its parent frame. */
void km_coordinate_shift(const km_mechanism *mechanism, km_state *state, int coordinate, double by);

/* Computes K_ij = ∂a_i/∂u_j of the independent coordinates by central differences. work[2 freedom], K[freedom²]
 * column-major. False: an evaluation failed. */
bool km_stiffness_of_accelerations(km_dynamics *dynamics, km_state *state, const km_stored_configuration *stored,
                                   double *work, double *K);

#endif
