/* Vectors of three components, inline and by value. */
#ifndef KM_SPATIAL_VEC3_H
#define KM_SPATIAL_VEC3_H

#include <math.h>

#define T        double
#define FN(name) km_##name
#include "spatial/vec3_body.h"
#undef T
#undef FN

static inline km_vec3 km_vec3_from_array(const double a[3]) {
  return (km_vec3){a[0], a[1], a[2]};
}
static inline double km_vec3_norm(km_vec3 a) {
  return sqrt(km_vec3_dot(a, a));
}

/* A unit vector orthogonal to the unit vector `a`. */
static inline km_vec3 km_vec3_perpendicular(km_vec3 a) {
  km_vec3 other = fabs(a.x) < 0.6 ? (km_vec3){1, 0, 0} : (km_vec3){0, 1, 0};
  km_vec3 b = km_vec3_cross(a, other);
  return km_vec3_scale(1.0 / km_vec3_norm(b), b);
}

#endif
