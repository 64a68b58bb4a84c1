/* Traversal of joints, and constant displacements between frames. */
#include "topology/chain.h"

/* Motions of a joint in the order and sense of traversal. */
void km_joint_traverse(const km_model *model, int joint, bool is_reversed, km_joint_traversal *out) {
  const km_model_joint *def = &model->joints[joint];
  const km_joint_kind *kind = km_joint_kind_of(def->type);
  out->count = kind->motion_count;
  out->sign = is_reversed ? -1.0 : 1.0;
  out->entry = def->frame[is_reversed];
  out->exit = def->frame[!is_reversed];
  int coordinate = def->first_coordinate;
  for (int i = 0; i < kind->motion_count; ++i) {
    int index = is_reversed ? kind->motion_count - 1 - i : i;
    out->motion[index] = kind->motions[i];
    out->coordinate[index] = coordinate;
    coordinate += km_primitive_freedom(kind->motions[i].primitive);
  }
}

/* X_a⁻¹ X_b of two frames of one body. */
km_pose km_frame_to_frame(const km_model *model, int a, int b, double size) {
  const km_pose *x = &model->frames[a].pose, *y = &model->frames[b].pose;
  km_rotation inverse = km_rotation_inverse(&x->R);
  return (km_pose){km_rotation_product(&inverse, &y->R),
                   km_vec3_scale(1.0 / size, km_rotate(&inverse, km_vec3_sub(y->p, x->p)))};
}

km_pose km_motion_traversed(km_motion motion, double pitch, const double *value, double sign) {
  km_pose x = km_motion_pose(motion, pitch, value);
  return sign < 0.0 ? km_pose_inverse(&x) : x;
}

km_twist km_motion_twist(km_motion motion, double pitch, const km_pose *frame, int k) {
  return km_axis_twist(motion.primitive, pitch, frame->R.axis[motion.primitive == KM_BALL ? k : motion.axis], frame->p);
}
