/* A serial arm in a mechanism: the chain of joints from the inertial frame to an effector frame. */
#ifndef KMECH_ARM_H
#define KMECH_ARM_H

#include "kmech/mechanism.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct km_arm km_arm;

/* What of the effector must follow: its whole pose (6 rows), its origin (3), or its origin and z axis (5). */
typedef enum km_task { KM_TASK_POSE, KM_TASK_POSITION, KM_TASK_AXIS } km_task;

/* The chain to `effector` (a frame of the model), joints passed in either sense, held and rigid joints rigid at the
 * state's values; other branches of the model don't matter. Lengths are scaled by L, the model's characteristic length
 * if its file gives one, else one metre. KM_USAGE: a joint on the way lies in a loop or a coupling, is a ball,
 * or there are fewer coordinates than the task has rows. The mechanism must outlive it. The caller frees `*out`. */
KM_API km_status km_arm_create(const km_mechanism *mechanism, const km_state *state, int effector, km_task task,
                               km_arm **out, km_error *error);
KM_API void km_arm_free(km_arm *arm);

KM_API int km_arm_coordinates(const km_arm *arm);
KM_API int km_arm_coordinate(const km_arm *arm, int column); /* the mechanism's coordinate of a column, base first */
KM_API double km_arm_length(const km_arm *arm);              /* L, in the model's length unit */

/* Largest speeds: value[n] in the model's angle or length unit per time unit, base first; NULL: none. KM_USAGE if
 * one isn't greater than 0. */
KM_API km_status km_arm_set_rates(km_arm *arm, const double *values, int count, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
