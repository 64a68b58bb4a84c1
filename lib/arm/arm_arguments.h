/* Argument checks of the public functions of arms: values, poses, methods. */
#ifndef KM_ARM_ARM_ARGUMENTS_H
#define KM_ARM_ARM_ARGUMENTS_H

#include "arm/arm.h"
#include "base/arguments.h"
#include "kmech/arm.h"

/* Returns KM_USAGE if a value of q[n] is not finite. */
km_status km_check_arm_values(const km_arm *arm, const double *q, km_error *error);
/* Returns KM_USAGE if the position is not finite or R is not a rotation matrix to 1e-6. */
km_status km_check_pose(const km_frame_pose *pose, km_error *error);
/* Returns KM_USAGE if a setting is out of its range. */
km_status km_check_method(const km_arm *arm, const km_method *method, km_error *error);

#endif
