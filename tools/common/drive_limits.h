/* Warnings about actuator forces beyond the limits of the drives. */
#ifndef KT_COMMON_DRIVE_LIMITS_H
#define KT_COMMON_DRIVE_LIMITS_H

#include "common/pose.h"
#include "kmech/statics.h"

/* Warns where an actuator's force is more than its joint's max_force. `where`: " at 3 rad", or "". */
void kt_report_drive(const kt_common *common, const char *name, const kt_pose *pose, const km_port *actuator,
                     double force, const char *where);

#endif
