/* Wrenches w = (f; τ): a force, and the moment about the origin of the frame in which they are expressed
 * (docs/theory.md 1.2). */
#ifndef KM_SPATIAL_WRENCH_H
#define KM_SPATIAL_WRENCH_H

#include "spatial/twist.h"

typedef struct km_wrench {
  km_vec3 f, t; /* force, moment about the origin */
} km_wrench;

/* Wrench of a force at `point` and a couple. */
static inline km_wrench km_wrench_at(km_vec3 force, km_vec3 couple, km_vec3 point) {
  return (km_wrench){force, km_vec3_add(couple, km_vec3_cross(point, force))};
}

static inline km_wrench km_wrench_axpy(double s, km_wrench a, km_wrench b) { /* s a + b */
  return (km_wrench){km_vec3_axpy(s, a.f, b.f), km_vec3_axpy(s, a.t, b.t)};
}

/* Power wᵀξ; both about one origin. */
static inline double km_wrench_power(km_wrench w, km_twist h) {
  return km_vec3_dot(w.f, h.v) + km_vec3_dot(w.t, h.w);
}

/* Wrench with its moment about `point` instead of the origin. */
static inline km_wrench km_wrench_about(km_wrench w, km_vec3 point) {
  return (km_wrench){w.f, km_vec3_sub(w.t, km_vec3_cross(point, w.f))};
}

/* Wrench in the axes of a rotated frame, Rᵀ w. */
static inline km_wrench km_wrench_rotate_back(const km_rotation *axes, km_wrench w) {
  return (km_wrench){km_rotate_back(axes, w.f), km_rotate_back(axes, w.t)};
}

#endif
