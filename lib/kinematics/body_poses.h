/* Bodies in the inertial frame. */
#ifndef KM_KINEMATICS_BODY_POSES_H
#define KM_KINEMATICS_BODY_POSES_H

#include "kinematics/state.h"
#include "kmech/mechanism.h"

/* Twist of a body against the next one towards the inertial frame, expressed in the inertial frame and taken
 * at its origin, from the rates of all coordinates (radians, model's length). After km_poses_compute. */
km_twist km_body_twist(const km_mechanism *mechanism, const km_state *state, int body, const double *rates);

/* The bodies that a substructure carries, where its base stands; what hangs on them stays behind. */
void km_poses_compute_in(const km_mechanism *mechanism, km_state *state, int substructure);

/* The twist of a coordinate's unit rate, child against parent in the user's sense, in the inertial frame at its
 * origin; lengths in the model's unit. After km_poses_compute. */
km_twist km_coordinate_twist(const km_mechanism *mechanism, const km_state *state, int coordinate);
/* Poses of all bodies in the inertial frame moved to `origin`: near the mechanism they keep their digits.
 * pose[body count]. */
void km_poses_about(const km_mechanism *mechanism, const km_state *state, km_vec3 origin, km_pose *pose);
/* The same about the origin of a body near the mechanism, which is returned. */
km_vec3 km_poses_about_mechanism(const km_mechanism *mechanism, const km_state *state, km_pose *pose);
/* km_coordinate_twist about that origin. */
km_twist km_coordinate_twist_about(const km_mechanism *mechanism, const km_state *state, const km_pose *pose,
                                   int coordinate);
/* Of every coordinate: twist[coordinate count]. */
void km_twists_about(const km_mechanism *mechanism, const km_state *state, const km_pose *pose, km_twist *twist);
/* A pose as the public record. */
void km_pose_write(const km_pose *pose, km_frame_pose *out);
/* The frame that a joint starts from (its parent frame), in the inertial frame. */
km_pose km_joint_pose(const km_mechanism *mechanism, const km_state *state, int joint);

#endif
