/* Forces of a prescribed motion: what its drives, joints and the ground must bear. */
#ifndef KMECH_INVERSE_H
#define KMECH_INVERSE_H

#include "kmech/history.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A coordinate that goes on from its value at a constant rate. */
typedef struct km_constant_rate {
  int coordinate; /* which goes on */
  double rate;    /* the coordinate's unit per time unit */
} km_constant_rate;

/* Lists are borrowed. Beside these rates the model's own prescribed motions count. */
typedef struct km_inverse_def {
  const km_constant_rate *rates; /* what moves, and how fast */
  int rate_count;
  double until;                    /* the model's time unit */
  int steps;                       /* intervals between rows */
  const km_followed_frame *frames; /* whose origins are written down */
  int frame_count;
  bool reactions; /* of every joint, too */
  km_axes axes;   /* of the reactions */
  km_progress progress;
  void *context;
} km_inverse_def;

/* Rows over time as km_history_run's, without what integration gives, and with f. of every prescribed coordinate, the
 * force that drives it, and shaking.fx … tz: −Σ of the rates of all momenta about the inertial origin, which the ground
 * bears beside weights and loads. The prescribed motions must leave no freedom. KM_PARTIAL: the motion can't go on (a
 * dead point of the drive, a limit of a link's reach): the table ends there, and `why` says when. KM_USAGE: a freedom is
 * left, or none is prescribed. Free `*out` with km_history_free in any case. */
KM_API km_status km_inverse_run(const km_mechanism *mechanism, km_forces *forces, km_state *state,
                                const km_inverse_def *def, km_history *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
