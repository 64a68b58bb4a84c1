/* The joint types and their primitive motions. */
#include "model/joint_type.h"

#include <string.h>

#define R(axis)                                                                                                        \
  { KM_REVOLUTE, axis }
#define T(axis)                                                                                                        \
  { KM_PRISMATIC, axis }

static const km_joint_kind kinds[KM_JOINT_TYPES] = {
    [KM_RX] = {"Rx", 1, 1, {R(0)}},
    [KM_RY] = {"Ry", 1, 1, {R(1)}},
    [KM_RZ] = {"Rz", 1, 1, {R(2)}},
    [KM_TX] = {"Tx", 1, 1, {T(0)}},
    [KM_TY] = {"Ty", 1, 1, {T(1)}},
    [KM_TZ] = {"Tz", 1, 1, {T(2)}},
    [KM_RIGID] = {"rigid", 0, 0, {{0}}},
    [KM_SPHERICAL] = {"spherical", 3, 1, {{KM_BALL, 0}}},
    [KM_FLOAT] = {"float", 6, 4, {T(0), T(1), T(2), {KM_BALL, 0}}},
    [KM_CYLINDRICAL] = {"cylindrical", 2, 2, {T(2), R(2)}},
    [KM_UNIVERSAL] = {"universal", 2, 2, {R(0), R(1)}},
    [KM_PLANAR] = {"planar", 3, 3, {T(0), T(1), R(2)}},
    [KM_SCREW] = {"screw", 1, 1, {{KM_HELICAL, 2}}},
};

const km_joint_kind *km_joint_kind_of(km_joint_type type) {
  return &kinds[type];
}

int km_joint_type_find(const char *word) {
  if (strcmp(word, "revolute") == 0)
    return KM_RZ;
  if (strcmp(word, "prismatic") == 0)
    return KM_TX;
  for (int type = 0; type < KM_JOINT_TYPES; ++type)
    if (strcmp(kinds[type].word, word) == 0)
      return type;
  return -1;
}

int km_primitive_freedom(km_primitive primitive) {
  return primitive == KM_BALL ? 3 : 1;
}

bool km_joint_is_length(km_joint_type type, int k) {
  const km_joint_kind *kind = &kinds[type];
  return k < kind->motion_count && kind->motions[k].primitive == KM_PRISMATIC;
}

km_dimension km_joint_dimension(km_joint_type type, int k) {
  return km_joint_is_length(type, k) ? (km_dimension){.length = 1} : (km_dimension){.angle = 1};
}

static km_vec3 along(int axis, double length) {
  return (km_vec3){axis == 0 ? length : 0.0, axis == 1 ? length : 0.0, axis == 2 ? length : 0.0};
}

km_pose km_motion_pose(km_motion motion, double pitch, const double *value) {
  km_pose x = km_pose_identity();
  switch (motion.primitive) {
  case KM_PRISMATIC:
    x.p = along(motion.axis, value[0]);
    break;
  case KM_HELICAL:
    x.p = along(motion.axis, pitch * value[0]); /* fall through */
  case KM_REVOLUTE:
    x.R = km_rotation_about_axis(&x.R, motion.axis, cos(value[0]), sin(value[0]));
    break;
  case KM_BALL:
    x.R = km_quaternion_rotation(km_quaternion_exp(km_vec3_from_array(value)));
    break;
  }
  return x;
}

int km_joint_axis(km_joint_type type) {
  const km_joint_kind *kind = km_joint_kind_of(type);
  int axis = -1;
  for (int k = kind->motion_count - 1; k >= 0; --k)
    if (kind->motions[k].primitive == KM_PRISMATIC)
      axis = kind->motions[k].axis;
  for (int k = kind->motion_count - 1; k >= 0; --k)
    if (kind->motions[k].primitive == KM_REVOLUTE || kind->motions[k].primitive == KM_HELICAL)
      axis = kind->motions[k].axis;
  return axis;
}
