/* Traversal of joints along a chain: motions of a joint in either sense, frames and unit twists. Shared by loop
 * programs and forward kinematics. */
#ifndef KM_TOPOLOGY_CHAIN_H
#define KM_TOPOLOGY_CHAIN_H

#include "topology/mechanism.h"

/* A frame of the model at the present end of a chain, reached from a slot by a constant displacement. */
typedef struct km_chain_frame {
  int slot;
  km_pose displacement; /* displacement from the slot, scaled */
  int frame;            /* frame of the model at the end of the chain */
  km_vec3 origin;       /* origin of slot positions on the base body, in that body's frame, unscaled */
} km_chain_frame;

/* Motions of a joint in the order of traversal; elements from `count` on are not set. */
typedef struct km_joint_traversal {
  int count;
  km_motion motion[KM_MAX_MOTIONS];
  int coordinate[KM_MAX_MOTIONS];
  double sign;
  int entry, exit; /* frames at which the traversal enters and leaves the joint */
} km_joint_traversal;

void km_joint_traverse(const km_model *model, int joint, bool is_reversed, km_joint_traversal *out);

/* Travel per radian of a helical motion, over `size`. */
static inline double km_pitch_per_radian(const km_model *model, int joint, double size) {
  return model->joints[joint].pitch / (2.0 * M_PI * size);
}

/* From frame `a` to frame `b` of the same body, lengths over `size`. */
km_pose km_frame_to_frame(const km_model *model, int a, int b, double size);

/* Displacement of a motion, km_motion_pose; inverted if sign < 0. */
km_pose km_motion_traversed(km_motion motion, double pitch, const double *value, double sign);

/* Unit twist of a motion along or about an axis through a point (docs/theory.md 2.1). */
static inline km_twist km_axis_twist(km_primitive primitive, double pitch, km_vec3 axis, km_vec3 point) {
  if (primitive == KM_PRISMATIC)
    return km_twist_prismatic(axis);
  km_twist t = km_twist_revolute(axis, point);
  if (primitive == KM_HELICAL)
    t.v = km_vec3_axpy(pitch, axis, t.v);
  return t;
}

/* Unit twist of coordinate k of a motion at a frame (of a ball motion about the frame's axis k). */
km_twist km_motion_twist(km_motion motion, double pitch, const km_pose *frame, int k);

#endif
