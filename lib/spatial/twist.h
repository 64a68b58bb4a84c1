/* Twists (screws) ξ = (v; ω) and wrenches (coscrews) w = (f; τ), linear part first, taken at the origin of
 * the frame they are expressed in; power = wᵀξ. */
#ifndef KM_SPATIAL_TWIST_H
#define KM_SPATIAL_TWIST_H

#include "spatial/pose.h"

typedef struct km_twist {
  km_vec3 v, w; /* linear (of the body point at the origin), angular */
} km_twist;

/* Unit twists (influence coefficients, (33)-(34)) of a revolute about, a prismatic along, `axis`. */
static inline km_twist km_twist_revolute(km_vec3 axis, km_vec3 point) {
  return (km_twist){km_vec3_cross(point, axis), axis};
}
static inline km_twist km_twist_prismatic(km_vec3 axis) {
  return (km_twist){axis, {0, 0, 0}};
}

static inline km_twist km_twist_axpy(double s, km_twist a, km_twist b) {
  return (km_twist){km_vec3_axpy(s, a.v, b.v), km_vec3_axpy(s, a.w, b.w)};
}

/* Adjoint: the same twist expressed in the parent frame. */
static inline km_twist km_twist_move(const km_pose *x, km_twist a) {
  km_vec3 w = km_rotate(&x->R, a.w);
  return (km_twist){km_vec3_add(km_rotate(&x->R, a.v), km_vec3_cross(x->p, w)), w};
}

/* Lie bracket [a, b] = ad(a) b. */
static inline km_twist km_twist_bracket(km_twist a, km_twist b) {
  return (km_twist){km_vec3_add(km_vec3_cross(a.w, b.v), km_vec3_cross(a.v, b.w)), km_vec3_cross(a.w, b.w)};
}

/* log of a displacement: the constant twist that produces it in unit time. */
static inline km_twist km_twist_log(const km_pose *x) {
  km_vec3 w = km_quaternion_log(km_rotation_quaternion(&x->R));
  double angle2 = km_vec3_dot(w, w), angle = sqrt(angle2);
  /* v = p − ½ ω×p + c ω×(ω×p), c = (1 − (θ/2) cot(θ/2)) / θ² */
  double c =
      angle < 1e-3 ? 1.0 / 12.0 + angle2 / 720.0 : (1.0 - 0.5 * angle * cos(0.5 * angle) / sin(0.5 * angle)) / angle2;
  km_vec3 wp = km_vec3_cross(w, x->p);
  return (km_twist){km_vec3_axpy(c, km_vec3_cross(w, wp), km_vec3_axpy(-0.5, wp, x->p)), w};
}

#endif
