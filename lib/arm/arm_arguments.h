/* What public functions of arms ask of values, poses and methods. */
#ifndef KM_ARM_ARM_ARGUMENTS_H
#define KM_ARM_ARM_ARGUMENTS_H

#include "arm/arm.h"
#include "base/arguments.h"
#include "kmech/arm.h"

/* KM_USAGE unless all q[n] are finite. */
km_status km_check_arm_values(const km_arm *arm, const double *q, km_error *error);
/* KM_USAGE unless the position is finite and the rotation one, to 1e-6. */
km_status km_check_pose(const km_frame_pose *pose, km_error *error);
/* KM_USAGE: a setting is out of the range in which the method works. */
km_status km_check_method(const km_arm *arm, const km_method *method, km_error *error);

#endif
