/* Comparison of configurations as assembly modes (docs/theory.md 4.13). */
#ifndef KM_KINEMATICS_MODE_IDENTITY_H
#define KM_KINEMATICS_MODE_IDENTITY_H

#include "kinematics/state.h"

/* Part of a body's pose that distinguishes assembly modes. */
typedef enum km_body_identity {
  KM_BODY_POSE,   /* position and orientation */
  KM_BODY_LINE,   /* rod: its joints lie on one line; its rotation about the line is passive */
  KM_BODY_POINT,  /* crosspiece: its joints lie at one point; its rotation between fixed neighbours is passive */
  KM_BODY_PASSIVE /* half of a strut: none of it */
} km_body_identity;

typedef struct km_body_placement {
  km_body_identity identity;
  km_vec3 point, direction; /* point of the line, or the point; direction of the line; in the body's frame */
} km_body_placement;

/* Finds the distinguishing part of each body's pose: placements[body count]. False when out of memory. O(joints). */
bool km_body_placements(const km_mechanism *mechanism, km_body_placement *placements);
/* True if all bodies agree in the distinguishing part of their poses, to `tolerance` in radians and in lengths over
 * `size`. a, b: poses[body count] in the inertial frame. O(bodies + joints). */
bool km_is_same_mode(const km_mechanism *mechanism, const km_body_placement *placements, const km_pose *a,
                     const km_pose *b, double size, double tolerance);

/* Substructure with loops and the most coordinates; -1: none. */
int km_mode_substructure(const km_mechanism *mechanism);

#endif
