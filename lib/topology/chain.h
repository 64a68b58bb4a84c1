/* Walking along the joints of a loop: what the steps of a program are made from. Shared with the poses in the inertial
 * frame. */
#ifndef KM_TOPOLOGY_CHAIN_H
#define KM_TOPOLOGY_CHAIN_H

#include "topology/mechanism.h"

/* Where a walk stands: a frame of the model, reached from a slot by a constant displacement. */
typedef struct km_chain_frame {
  int slot;
  km_pose displacement; /* from the slot, scaled */
  int frame;            /* the model's frame that the walk stands on */
  km_vec3 origin;       /* where on the base body slot positions are counted from, in that body's frame, unscaled */
} km_chain_frame;

/* The motions of a joint in the order in which a walk passes them: so many as it has, what is behind them isn't set. */
typedef struct km_joint_traversal {
  int count;
  km_motion motion[KM_MAX_MOTIONS];
  int coordinate[KM_MAX_MOTIONS];
  double sign;
  int entry, exit; /* frames */
} km_joint_traversal;

void km_joint_traverse(const km_model *model, int joint, bool against, km_joint_traversal *out);

/* Travel per radian of a helical motion, over `size`. */
static inline double km_pitch_per_radian(const km_model *model, int joint, double size) {
  return model->joints[joint].pitch / (2.0 * M_PI * size);
}

/* From frame `a` to frame `b` of the same body, lengths over `size`. */
km_pose km_frame_to_frame(const km_model *model, int a, int b, double size);

/* km_motion_pose, undone if sign < 0. */
km_pose km_motion_traversed(km_motion motion, double pitch, const double *value, double sign);

/* The unit twist of a motion along or about an axis through a point. */
static inline km_twist km_axis_twist(km_primitive primitive, double pitch, km_vec3 axis, km_vec3 point) {
  if (primitive == KM_PRISMATIC)
    return km_twist_prismatic(axis);
  km_twist t = km_twist_revolute(axis, point);
  if (primitive == KM_HELICAL)
    t.v = km_vec3_axpy(pitch, axis, t.v);
  return t;
}

/* The unit twist of a motion's coordinate k at a frame (a ball's about the frame's axis k). */
km_twist km_motion_twist(km_motion motion, double pitch, const km_pose *frame, int k);

#endif
