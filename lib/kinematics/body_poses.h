/* Forward kinematics: poses and twists of bodies in the inertial frame (docs/theory.md 1.2, 2.1). */
#ifndef KM_KINEMATICS_BODY_POSES_H
#define KM_KINEMATICS_BODY_POSES_H

#include "kinematics/state.h"
#include "kmech/mechanism.h"

/* Twist of a body in the inertial frame, at its origin, from the rates of all coordinates (radians, model's length):
 * the sum of the joints' twists along the spanning tree. After km_poses_compute. */
km_twist km_body_twist(const km_mechanism *mechanism, const km_state *state, int body, const double *rates);

/* Updates the poses of the bodies whose tree joints belong to a substructure, from the pose of its base. Other bodies
 * are not updated. */
void km_poses_compute_in(const km_mechanism *mechanism, km_state *state, int substructure);

/* Unit twist of a coordinate, child relative to parent in the user's sense, in the inertial frame at its origin;
 * lengths in the model's unit. After km_poses_compute. */
km_twist km_coordinate_twist(const km_mechanism *mechanism, const km_state *state, int coordinate);
/* Poses of all bodies in the inertial axes about the point `origin`: pose[body count]. Close to the mechanism they keep
 * their digits. */
void km_poses_about(const km_mechanism *mechanism, const km_state *state, km_vec3 origin, km_pose *pose);
/* As km_poses_about, about the origin of the first moving body, which is returned. */
km_vec3 km_poses_about_mechanism(const km_mechanism *mechanism, const km_state *state, km_pose *pose);
/* Unit twist of a coordinate for given poses, about the origin of these poses. */
km_twist km_coordinate_twist_about(const km_mechanism *mechanism, const km_state *state, const km_pose *pose,
                                   int coordinate);
/* Unit twists of all coordinates for given poses: twist[coordinate count]. */
void km_twists_about(const km_mechanism *mechanism, const km_state *state, const km_pose *pose, km_twist *twist);
/* Converts a pose to the public structure. */
void km_pose_write(const km_pose *pose, km_frame_pose *out);
/* Pose of a joint's parent frame in the inertial frame. */
km_pose km_joint_pose(const km_mechanism *mechanism, const km_state *state, int joint);

/* Twist V of a body and its rate A = dV/dt, in the inertial frame at its origin. */
typedef struct km_body_motion {
  km_twist V, A;
} km_body_motion;

/* Motions of all bodies from rates and accelerations of all coordinates (radians, model's length): out[body count].
 * After km_poses_compute. O(coordinates). */
void km_body_motions(const km_mechanism *mechanism, const km_state *state, const double *rate,
                     const double *acceleration, km_body_motion *out);

#endif
