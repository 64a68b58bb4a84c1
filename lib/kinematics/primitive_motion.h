/* One primitive motion of a chain (docs/theory.md 2.1), shared by the loop programs and the equations of motion.
 *
 *   revolute : h = (p × a; a),          R <- R rot(a, q)
 *   prismatic: h = (a; 0),              p <- p + q a
 *   helical  : h = (p × a + P a; a),    both, with the travel P per radian
 *   ball     : h_k = (p × a_k; a_k),    R <- R rot(quaternion), a_k axes of the parent frame */
#ifndef KM_KINEMATICS_PRIMITIVE_MOTION_H
#define KM_KINEMATICS_PRIMITIVE_MOTION_H

#include "model/joint_type.h"
#include "spatial/sincos.h"
#include "spatial/twist.h"

/* Returns the pose after a motion from the frame X. `sign` is −1 for a reversed joint; `value` is the coordinate times
 * `sign`, a length in the unit of X; `pitch` is the travel per radian in that unit; `ball` is the quaternion of a ball
 * motion (else unused). h receives the signed unit twists, one per coordinate. */
static inline km_pose km_motion_step(km_motion motion, double sign, double pitch, double value,
                                     const km_quaternion *ball, km_pose X, km_twist *h) {
  km_vec3 axis = X.R.axis[motion.axis];
  double sine, cosine;
  switch (motion.primitive) {
  case KM_PRISMATIC:
    h[0] = km_twist_prismatic(km_vec3_scale(sign, axis));
    X.p = km_vec3_axpy(value, axis, X.p);
    break;
  case KM_REVOLUTE:
    h[0] = km_twist_revolute(km_vec3_scale(sign, axis), X.p);
    km_sincos(value, &sine, &cosine);
    X.R = km_rotation_about_axis(&X.R, motion.axis, cosine, sine);
    break;
  case KM_HELICAL:
    h[0] = km_twist_revolute(km_vec3_scale(sign, axis), X.p);
    h[0].v = km_vec3_axpy(sign * pitch, axis, h[0].v);
    X.p = km_vec3_axpy(value * pitch, axis, X.p);
    km_sincos(value, &sine, &cosine);
    X.R = km_rotation_about_axis(&X.R, motion.axis, cosine, sine);
    break;
  case KM_BALL: {
    /* Rates are about the axes of the joint's parent frame: the frame before the rotation, or after it if the joint is
     * reversed. */
    km_rotation turn = km_quaternion_rotation(sign > 0.0 ? *ball : km_quaternion_conjugate(*ball)), before = X.R;
    X.R = km_rotation_product(&X.R, &turn);
    const km_rotation *axes = sign > 0.0 ? &before : &X.R;
    for (int k = 0; k < 3; ++k)
      h[k] = km_twist_revolute(km_vec3_scale(sign, axes->axis[k]), X.p);
    break;
  }
  }
  return X;
}

#endif
