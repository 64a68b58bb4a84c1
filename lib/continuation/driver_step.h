/* Single steps of a drive, and the singular poses that it passes. Predictor-corrector in the driver s: t = dq/ds
 * (scaled, the driver's entry 1), h is the step in s. Private to kinematics/. */
#ifndef KM_CONTINUATION_DRIVER_STEP_H
#define KM_CONTINUATION_DRIVER_STEP_H

#include "continuation/driver_motion.h"

/* Was a step taken, or what forbids it? */
typedef enum km_attempt {
  KM_ATTEMPT_ACCEPTED,
  KM_ATTEMPT_OPEN,     /* the loops don't close there */
  KM_ATTEMPT_BENT,     /* the step is too long to be on this motion for sure */
  KM_ATTEMPT_LIMITED,  /* a coordinate would pass its limit */
  KM_ATTEMPT_AWAY,     /* a slide leaves without bound */
  KM_ATTEMPT_EXHAUSTED /* too many steps, none of which leads on */
} km_attempt;

/* Below this length of a step almost nothing moves but what rounding lets through. */
static const double km_driver_motion_creeping = 1e-5;
/* Residual that shows a pose found without Newton to be on the motion. */
static const double km_driver_motion_closed = 1e-12;
/* A change of sign that stays below this step is a branch point. */
static const double km_driver_motion_branch_width = 1e-5;

/* Pivots and tangent of the present pose, searched. False: it has no tangent. */
bool km_driver_motion_start(km_driver_motion *drive);
/* Where a slide is, in substructure sizes; 0 of an angle. */
double km_driver_step_diverges(const km_driver_motion *drive, int column);
/* Tries to advance by h. Restores the pose if refused; *limit is the coordinate that forbids it, where one does. */
km_attempt km_driver_motion_advance(km_driver_motion *drive, double h, double tightness, int *limit);

/* Where a step of h is refused that is long enough to tell configurations apart, the present one may still be away
 * from what refuses it: a bridge is begun from there. */
void km_singular_bridge_record(km_driver_motion *drive, double h);
/* Builds a bridge over the singular configuration near driver value s, which lies ahead of the drive (`side`: 1 or
 * -1). Its centre is s + lead d: 0 where s itself is singular, less than 1 where s is the last regular value before
 * the stretch. True: the place is on the bridge. False, with the state where it was: no smooth motion leads over it.
 * O(100 steps). */
bool km_singular_bridge_build(km_driver_motion *drive, double s, double side, double lead);
/* Puts the drive at s on its bridge, with the motion's tangent. False, with the state where it was: the loops don't
 * close there. */
bool km_singular_bridge_place(km_driver_motion *drive, double s);
/* From a place on the bridge to its end towards `target`. False: that end has no tangent. */
bool km_singular_bridge_leave(km_driver_motion *drive, double target);
/* True if the place is on the drive's bridge and s is inside it. */
bool km_singular_bridge_is_active(const km_driver_motion *drive, double s);

#endif
