/* Where frames are and how they move.
 *
 * Rates are those of all coordinates of the model, in radians and the model's length unit per unit of time, whatever
 * the model's angle unit; twists are (vx vy vz wx wy wz): the velocity of the frame's origin and its body's angular
 * velocity in radians, along the inertial axes. So Jᵀ (force; torque) is a force in each joint, of angles per radian.
 */
#ifndef KMECH_FRAMES_H
#define KMECH_FRAMES_H

#include "kmech/kinematics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Rotation by rows (its columns are the frame's axes), and the origin's position in the model's length unit, both in
 * the inertial frame. */
typedef struct km_frame_pose {
  double R[9], p[3]; /* rotation; position */
} km_frame_pose;

/* The pose at p, turned from the inertial axes by the rotation vector turn[3]: about its direction by its length in
 * radians, right-handed. KM_USAGE: not finite. */
KM_API km_status km_frame_pose_make(const double p[3], const double turn[3], km_frame_pose *out, km_error *error);

/* The pose of a frame of the model. After km_poses_update. KM_USAGE. O(1). */
KM_API km_status km_frame_place(const km_mechanism *mechanism, const km_state *state, int frame, km_frame_pose *out,
                                km_error *error);

/* The twist of a frame at rates[coordinate], which must be rates that the loops allow: those of km_drive_tangent,
 * km_follow_tangent, km_lever_rates, or a column of km_motions_basis. After km_poses_update. KM_USAGE. O(depth). */
KM_API km_status km_frame_twist(const km_mechanism *mechanism, const km_state *state, int frame, const double *rates,
                                double twist[6], km_error *error);

/* J[6 × coordinate count], column-major: the twist per unit rate of each coordinate on the way from the inertial frame
 * to the body along the spanning tree, 0 for all others and for held ones (thesis (33)-(34)). With loops the rates
 * aren't free: the twists that the frame can have are J N, N by km_motions_basis. After km_poses_update. KM_USAGE.
 * O(coordinates). */
KM_API km_status km_frame_jacobian(const km_mechanism *mechanism, const km_state *state, int frame, double *J,
                                   km_error *error);

/* inverse = Λ⁻¹ = J N (Nᵀ M N)⁻¹ (J N)ᵀ [6 × 6]: the twist per time that a wrench (f; τ) at the frame's origin gives it from rest,
 * beside what else acts (O. Khatib, A unified approach for motion and force control, 1987; N lets the loops keep closed).
 * M has the bodies' masses and the rotors' inertias. In one over mass, over mass × length, over mass × length² of the
 * model; symmetric, singular where the frame can't move. 1/Λ⁻¹_ii is the mass that a push along axis i feels. After
 * km_poses_update and km_mobility_update. KM_MODEL: a free motion moves no mass; KM_USAGE; KM_MEMORY.
 * O(bodies · freedom · (depth + freedom)). */
KM_API km_status km_frame_inverse_inertia(const km_mechanism *mechanism, const km_state *state, int frame,
                                          double inverse[36], km_error *error);

#ifdef __cplusplus
}
#endif
#endif
