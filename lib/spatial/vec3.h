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
static inline void km_vec3_write(km_vec3 a, double out[3]) {
  out[0] = a.x;
  out[1] = a.y;
  out[2] = a.z;
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

/* Unit vector along ±a, with the sign by which its largest component is positive. */
static inline km_vec3 km_vec3_upright(km_vec3 a) {
  double largest = fabs(a.x) > fmax(fabs(a.y), fabs(a.z)) ? a.x : fabs(a.y) > fabs(a.z) ? a.y : a.z;
  return km_vec3_scale(copysign(1.0 / km_vec3_norm(a), largest), a);
}

#endif
