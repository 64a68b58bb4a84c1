/* Compares two configurations as assembly modes. Private to kinematics/. */
#ifndef KM_KINEMATICS_MODE_IDENTITY_H
#define KM_KINEMATICS_MODE_IDENTITY_H

#include "kinematics/state.h"

/* What tells the place of a body. */
typedef enum km_body_identity {
  KM_BODY_POSE,   /* position and orientation */
  KM_BODY_LINE,   /* a rod: its joints lie on one line, about which its turn is passive */
  KM_BODY_POINT,  /* its joints lie at one point: a crosspiece, whose turn between fixed neighbours is passive */
  KM_BODY_PASSIVE /* half of a strut: nothing */
} km_body_identity;

typedef struct km_body_placement {
  km_body_identity identity;
  km_vec3 point, direction; /* of the line or the point, in the body */
} km_body_placement;

/* What tells the places of a mechanism's bodies: places[body count]. False when out of memory. O(joints). */
bool km_body_placements(const km_mechanism *mechanism, km_body_placement *places);
/* True if all bodies have the same place, to `tolerance` in radians and in lengths over `size`. a, b: [body count]
 * poses in the inertial frame. O(bodies + joints). */
bool km_is_same_mode(const km_mechanism *mechanism, const km_body_placement *places, const km_pose *a, const km_pose *b,
                     double size, double tolerance);

#endif
