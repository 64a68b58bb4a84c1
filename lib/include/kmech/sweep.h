/* Moving a mechanism by one driven coordinate. */
#ifndef KMECH_SWEEP_H
#define KMECH_SWEEP_H

#include "kmech/kinematics.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What ends a motion. */
typedef enum km_stop {
  KM_STOP_NONE,     /* the whole range was reached */
  KM_STOP_TOGGLE,   /* the driver can't move its substructure any further */
  KM_STOP_LIMIT,    /* a joint is at its limit */
  KM_STOP_GAVE_OUT, /* too many steps: a target millions of steps away, or angles whose rounding drowns the motion */
  KM_STOP_AWAY      /* a slide leaves without bound: the mechanism reaches the end only at infinity */
} km_stop;

/* How far a motion came. */
typedef struct km_reach {
  km_stop stop;     /* why it came no further */
  double position;  /* of the driver, model's unit: the target, or the located end (to 1e-9 or better) */
  int substructure; /* KM_STOP_TOGGLE, KM_STOP_AWAY: that which stops; -1 none */
  int coordinate;   /* KM_STOP_LIMIT: the coordinate at its limit; KM_STOP_AWAY: the slide; -1 none */
} km_reach;

/* A motion of one driver from an assembled pose, along one branch. */
typedef struct km_drive km_drive;

/* Prepares to drive `coordinate` of an assembled state; the state must outlive the drive and is moved by it.
 * Limits end the motion, but with
 * `ignore_limits`. KM_USAGE if the coordinate is held or a component of a ball joint. The caller frees `*out`. */
KM_API km_status km_drive_create(const km_mechanism *mechanism, km_state *state, int coordinate, bool ignore_limits,
                                 km_drive **out, km_error *error);
KM_API void km_drive_free(km_drive *drive);

/* Moves the driver to `target` (model's unit), exactly; the other coordinates close the loops and, where more
 * than one freedom is left, move least. Steps are controlled by the tangent, so that the branch is kept: the
 * result doesn't depend on how a range is cut into targets (with one freedom to 1e-8, with more to 1e-4). Where the
 * target is out of reach, stops at the located end. The state is closed to 1e-12 at return; mobility numbers of the
 * driven substructure may be stale. Never allocates. */
KM_API km_reach km_drive_to(km_drive *drive, double target);

/* The direction of motion at the present pose: rates of all coordinates per unit rate of the driver, in the
 * engine's units (radians, model's length). rates[coordinate count]. False at a toggle of the driver. */
KM_API bool km_drive_tangent(km_drive *drive, double *rates);

/* Keeps where the drive stands, and brings it back there exactly, as if it had never left. */
KM_API void km_drive_mark(km_drive *drive);
KM_API void km_drive_return(km_drive *drive);

/* How many singular poses (branch points) the drive has passed, on the smooth motion. */
KM_API int km_drive_crossings(const km_drive *drive);

/* Compiles the model and brings it to a pose: assembled at the file's pose, then moved along its branch, one
 * coordinate after the other, until all `holds` and `sets` have their values. Held coordinates stay rigid in
 * the mechanism that comes out, set ones are free again. Limits don't count. KM_MODEL: the file's own pose can't
 * be closed; KM_NO_RESULT: a value can't be reached (with the end that was located); KM_USAGE: a rotation vector
 * is held or set only in part. The caller frees both. */
KM_API km_status km_reach_pose(const km_model *model, const km_hold *holds, int hold_count, const km_hold *sets,
                               int set_count, km_mechanism **mechanism, km_state **state, km_error *error);

/* Moves an assembled state to a pose of its own mechanism in the same way: along its branch, one coordinate after the
 * other, until every `set` has its value. What the mechanism holds stays. The mechanism stays the same, and after a
 * failure the state does too. KM_NO_RESULT, KM_USAGE as above. */
KM_API km_status km_state_reach(const km_mechanism *mechanism, km_state *state, const km_hold *sets, int set_count,
                                km_error *error);

#ifdef __cplusplus
}
#endif
#endif
