/* Where the bodies stand when every joint has the value that its coordinates start the assembly from. */
#ifndef KM_MODEL_INITIAL_POSES_H
#define KM_MODEL_INITIAL_POSES_H

#include "model/model.h"

/* X of the joint's child frame in its parent frame at those values. */
km_pose km_model_start_motion(const km_model *model, int joint);
/* Poses of all bodies in the inertial frame, along the first chain of joints that leads to each. A body of a drawn
 * assembly, or one that no chain leads to, stands where its frame is the inertial frame. False when out of memory. */
bool km_model_start_poses(const km_model *model, km_pose *pose);

#endif
