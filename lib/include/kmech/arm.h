/* A serial arm in a mechanism: the chain of joints from the inertial frame to an effector frame. */
#ifndef KMECH_ARM_H
#define KMECH_ARM_H

#include "kmech/frames.h"
#include "kmech/progress.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The chain, cut out of a mechanism. Immutable but for km_arm_set_rates. */
typedef struct km_arm km_arm;

/* What of the effector must follow: its whole pose (6 rows), its origin (3), or its origin and z axis (5). */
typedef enum km_task {
  KM_TASK_POSE,     /* position and rotation: 6 rows */
  KM_TASK_POSITION, /* the origin: 3 rows */
  KM_TASK_AXIS      /* the origin and the direction of the z axis: 5 rows */
} km_task;

/* The chain to `effector` (a frame of the model), joints passed in either sense, held and rigid joints rigid at the
 * state's values; other branches of the model don't matter. Lengths are scaled by L, the model's characteristic length
 * if its file gives one, else one metre. KM_USAGE: a joint on the way lies in a loop or a coupling, is a ball,
 * or there are fewer coordinates than rows of the task that motions can change. The mechanism must outlive it. The caller frees `*out`. */
KM_API km_status km_arm_create(const km_mechanism *mechanism, const km_state *state, int effector, km_task task,
                               km_arm **out, km_error *error);
KM_API void km_arm_free(km_arm *arm);

/* The number of its coordinates n; 0 without an arm. */
KM_API int km_arm_coordinates(const km_arm *arm);
KM_API int km_arm_coordinate(const km_arm *arm, int column); /* the mechanism's coordinate of a column, base first */
KM_API double km_arm_length(const km_arm *arm);              /* L, in the model's length unit */

KM_API int km_arm_rows(const km_arm *arm); /* of the task: 6, 5 or 3 */
/* To spare for it: coordinates − rows that its motions can change, which are fewer than the task's of an arm that moves in a
 * plane, for instance; 0 without an arm. */
KM_API int km_arm_freedom(const km_arm *arm);

/* Effector kinematics at q[n] (model's units, base first). The pose in the inertial frame; J[rows × n], column-major:
 * v of the effector's origin along the inertial axes, then of a pose ω along them, of an axis ω along the effector's x
 * and y, per unit rate in radians and the model's length unit. KM_USAGE: not finite; KM_MEMORY. O(n), and a workspace
 * is made. */
KM_API km_status km_arm_place(const km_arm *arm, const double *q, km_frame_pose *out, km_error *error);
KM_API km_status km_arm_jacobian(const km_arm *arm, const double *q, double *J, km_error *error);

/* Inverse kinematics: of all poses within the limits that reach `pose` the one nearest to near[n], both in the model's
 * units: by Newton's method from there, else of all branches that are found (km_ik_solutions_find; the same for the same
 * seed). KM_NO_RESULT: out of reach, or never within the limits; KM_DIVERGED, KM_CANCELLED, KM_MEMORY, KM_USAGE: then
 * q[n] stays as it is. */
KM_API km_status km_arm_solve(const km_arm *arm, const km_frame_pose *pose, const double *near, unsigned long seed,
                              km_progress progress, void *context, double *q, km_error *error);

/* Largest speeds: values[n] in the model's angle or length unit per time unit, base first; NULL: none. KM_USAGE if
 * one isn't greater than 0. */
KM_API km_status km_arm_set_rates(km_arm *arm, const double *values, int count, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
