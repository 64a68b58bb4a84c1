/* Initial poses of the bodies, at the initial displacements of the joints. */
#ifndef KM_MODEL_INITIAL_POSES_H
#define KM_MODEL_INITIAL_POSES_H

#include "model/model.h"

/* Pose of the child frame in the parent frame at the joint's coordinates q: radians, lengths; a ball's rotation
 * vector. */
km_pose km_model_joint_motion(const km_model *model, int joint, const double *q);
/* Pose of the child frame in the parent frame at the initial displacements. */
km_pose km_model_start_motion(const km_model *model, int joint);
/* Computes the poses of all bodies along the first chain of joints to each. Bodies of drawn assemblies, and
 * unconnected ones, coincide with the inertial frame. False when out of memory. */
bool km_model_start_poses(const km_model *model, km_pose *pose);

#endif
