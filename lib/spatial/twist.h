/* Twists ξ = (v; ω), linear part first, taken at the origin of the frame in which they are expressed (docs/theory.md
 * 1.2). The power of a wrench is wᵀξ. */
#ifndef KM_SPATIAL_TWIST_H
#define KM_SPATIAL_TWIST_H

#include "spatial/pose.h"

typedef struct km_twist {
  km_vec3 v, w; /* linear velocity (of the body point at the origin), angular velocity */
} km_twist;

/* Unit twists (joint Jacobians, (33)-(34)): revolute about, prismatic along, `axis`. */
static inline km_twist km_twist_revolute(km_vec3 axis, km_vec3 point) {
  return (km_twist){km_vec3_cross(point, axis), axis};
}
static inline km_twist km_twist_prismatic(km_vec3 axis) {
  return (km_twist){axis, {0, 0, 0}};
}

static inline km_twist km_twist_axpy(double s, km_twist a, km_twist b) {
  return (km_twist){km_vec3_axpy(s, a.v, b.v), km_vec3_axpy(s, a.w, b.w)};
}

/* Velocity v + ω × x of the body point x, and its acceleration v̇ + ω̇ × x + ω × (v + ω × x); A is the rate of V. */
static inline km_vec3 km_point_velocity(km_twist V, km_vec3 x) {
  return km_vec3_add(V.v, km_vec3_cross(V.w, x));
}
static inline km_vec3 km_point_acceleration(km_twist V, km_twist A, km_vec3 x) {
  return km_vec3_add(A.v, km_vec3_add(km_vec3_cross(A.w, x), km_vec3_cross(V.w, km_point_velocity(V, x))));
}

/* Adjoint: transforms a twist to the parent frame, v' = R v + p × (R ω), ω' = R ω. */
static inline km_twist km_twist_transform(const km_pose *x, km_twist a) {
  km_vec3 w = km_rotate(&x->R, a.w);
  return (km_twist){km_vec3_add(km_rotate(&x->R, a.v), km_vec3_cross(x->p, w)), w};
}

/* Lie bracket [a, b] = ad(a) b. */
static inline km_twist km_twist_bracket(km_twist a, km_twist b) {
  return (km_twist){km_vec3_add(km_vec3_cross(a.w, b.v), km_vec3_cross(a.v, b.w)), km_vec3_cross(a.w, b.w)};
}

/* Lie bracket of planar twists (v_x, v_y, ω). */
static inline km_vec3 km_planar_bracket(km_vec3 a, km_vec3 b) {
  return (km_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, 0.0};
}

/* Angle below which series are exact to 1e-16. */
#define KM_SERIES_ANGLE 1e-3

/* Logarithm of a displacement: the constant twist that produces it in unit time. Closure errors are small
 * displacements. */
static inline km_twist km_twist_log(const km_pose *x) {
  const km_vec3 *a = x->R.axis;
  /* sin θ times the unit vector of the rotation, from the skew-symmetric part of R */
  km_vec3 w = {0.5 * (a[1].z - a[2].y), 0.5 * (a[2].x - a[0].z), 0.5 * (a[0].y - a[1].x)};
  double sine2 = km_vec3_dot(w, w), c; /* v = p − ½ ω×p + c ω×(ω×p), c = (1 − (θ/2) cot(θ/2)) / θ² */
  if (sine2 < KM_SERIES_ANGLE * KM_SERIES_ANGLE && a[0].x + a[1].y + a[2].z > 2.0) {
    w = km_vec3_scale(1.0 + sine2 * (1.0 / 6.0) + sine2 * sine2 * (3.0 / 40.0), w);
    c = 1.0 / 12.0 + km_vec3_dot(w, w) * (1.0 / 720.0);
  } else {
    w = km_quaternion_log(km_rotation_quaternion(&x->R));
    double angle2 = km_vec3_dot(w, w), angle = sqrt(angle2);
    c = (1.0 - 0.5 * angle * cos(0.5 * angle) / sin(0.5 * angle)) / angle2;
  }
  km_vec3 wp = km_vec3_cross(w, x->p);
  return (km_twist){km_vec3_axpy(c, km_vec3_cross(w, wp), km_vec3_axpy(-0.5, wp, x->p)), w};
}

#endif
