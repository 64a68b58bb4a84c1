/* One step of a driven continuation, and bridges over singular configurations.
 * s: scaled driver, t = dq/ds with t_driver = 1, h: step in s. Private to continuation/. */
#ifndef KM_CONTINUATION_DRIVER_STEP_H
#define KM_CONTINUATION_DRIVER_STEP_H

#include "continuation/driver_motion.h"

/* Result of an attempted step. */
typedef enum km_attempt {
  KM_ATTEMPT_ACCEPTED,
  KM_ATTEMPT_OPEN,      /* the loops do not close, or the configuration is singular */
  KM_ATTEMPT_TOO_LONG,  /* correction, angle or change of sign: the step may be on another branch */
  KM_ATTEMPT_AT_LIMIT,  /* a coordinate would exceed its limit */
  KM_ATTEMPT_DIVERGING, /* a slide diverges */
  KM_ATTEMPT_EXHAUSTED  /* step bound reached */
} km_attempt;

/* Steps below this length hardly advance (MOST_SHORT_ATTEMPTS); a sign change of det(pivot block) over such a step is a
 * branch point. */
static const double km_driver_motion_short_step = 1e-5;

/* Searches pivots and computes the tangent of the present configuration. False if it has no tangent. */
bool km_driver_motion_start(km_driver_motion *drive);
/* Returns a slide's displacement in substructure sizes; 0 for an angle. */
double km_driver_step_slide_position(const km_driver_motion *drive, int column);
/* Attempts one step h with at most correction_ratio |D move| of correction. The state returns if it is rejected;
 * *limit is then the coordinate at its limit or the diverging slide, if any. */
km_attempt km_driver_motion_advance(km_driver_motion *drive, double h, double correction_ratio, int *limit);

/* Longest step of the driver, scaled. */
double km_driver_motion_longest_step(const km_driver_motion *drive);
/* Attempts a step of at most *step towards `target`, at which the last one arrives exactly. *step becomes that of the
 * next attempt: half the step after a rejection, the same or twice as much after success, as the predictor's error
 * permits. */
km_attempt km_driver_motion_step_towards(km_driver_motion *drive, double target, double *step, int *limit);

/* Records the present configuration as the start of a bridge, if the rejected step h is as long as the nodes around a
 * singular configuration: it is then still away from the singular one. */
void km_singular_bridge_record(km_driver_motion *drive, double h);
/* Builds a bridge over the singular configuration near s, ahead of the motion in the direction side = ±1. Its centre
 * is s + lead h: lead is 0 if s itself is singular, less than 1 if s is the last regular value. True: the
 * configuration is on the bridge. False, with the state unchanged: no smooth motion crosses. O(100 steps). */
bool km_singular_bridge_build(km_driver_motion *drive, double s, double side, double lead);
/* Moves to s on the bridge, with the interpolated tangent. False, with the state unchanged, if the loops do not
 * close. */
bool km_singular_bridge_place(km_driver_motion *drive, double s);
/* Moves from the bridge to its end in the direction of `target`. False if that end has no tangent. */
bool km_singular_bridge_leave(km_driver_motion *drive, double target);
/* True if the present configuration is on the bridge and s inside it. */
bool km_singular_bridge_is_active(const km_driver_motion *drive, double s);

#endif
