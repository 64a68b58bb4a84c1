/* Single steps of a drive, and the singular poses that it passes. Predictor-corrector in the driver s: t = dq/ds (scaled, the driver's
 * entry 1), h is the step in s. Private to kinematics/. */
#ifndef KM_KINEMATICS_DRIVE_STEP_H
#define KM_KINEMATICS_DRIVE_STEP_H

#include "kinematics/drive.h"

/* Was a step taken, or what forbids it? */
typedef enum km_attempt {
  KM_ATTEMPT_ACCEPTED,
  KM_ATTEMPT_OPEN,     /* the loops don't close there */
  KM_ATTEMPT_BENT,     /* the step is too long to be on this motion for sure */
  KM_ATTEMPT_LIMITED,  /* a coordinate would pass its limit */
  KM_ATTEMPT_AWAY,     /* a slide leaves without bound */
  KM_ATTEMPT_EXHAUSTED /* too many steps, none of which leads on */
} km_attempt;

/* Below this length of a step almost nothing moves but what rounding lets through; and the distance from a singular pose at which it is
 * crossed. */
static const double km_drive_creeping = 1e-5, km_drive_crossing = 1e-3;
/* Residual that shows a pose found without Newton to be on the motion. */
static const double km_drive_closed = 1e-12;
/* A change of sign that stays below this step is a branch point. */
static const double km_drive_branch_width = 1e-5;

/* Pivots and tangent of the present pose, searched. False: it has no tangent. */
bool km_drive_start(km_drive *drive);
/* Where a slide is, in substructure sizes; 0 of an angle. */
double km_drive_slid(const km_drive *drive, int column);
/* Tries to advance by h. Restores the pose if refused; *limit is the coordinate that forbids it, where one does. */
km_attempt km_drive_advance(km_drive *drive, double h, double tightness, int *limit);

/* Passes a singular pose at `target` along the smooth branch, and stops there. False: it can't be passed so. */
bool km_drive_cross(km_drive *drive, double target, int *limit);
/* Where a step of h is refused that is long enough to tell poses apart, the present pose may still be away from what refuses it: it is
 * remembered for a leap. */
void km_drive_remember_place(km_drive *drive, double h);
/* Steps have become too short at a singular pose that is no toggle: many motions may meet there, between which short steps can't tell.
 * False, with the state where it was, if no step from a place before it leads over it. */
bool km_drive_leap_over(km_drive *drive, double target, int *limit);

#endif
