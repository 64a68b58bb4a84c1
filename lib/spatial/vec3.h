/* Vectors of three components, inline and by value. */
#ifndef KM_SPATIAL_VEC3_H
#define KM_SPATIAL_VEC3_H

#include <math.h>

typedef struct km_vec3 {
  double x, y, z;
} km_vec3;

static inline km_vec3 km_vec3_from_array(const double a[3]) {
  return (km_vec3){a[0], a[1], a[2]};
}
static inline km_vec3 km_vec3_add(km_vec3 a, km_vec3 b) {
  return (km_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline km_vec3 km_vec3_sub(km_vec3 a, km_vec3 b) {
  return (km_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline km_vec3 km_vec3_scale(double s, km_vec3 a) {
  return (km_vec3){s * a.x, s * a.y, s * a.z};
}
static inline km_vec3 km_vec3_axpy(double s, km_vec3 a, km_vec3 b) { /* s a + b */
  return (km_vec3){s * a.x + b.x, s * a.y + b.y, s * a.z + b.z};
}
static inline double km_vec3_dot(km_vec3 a, km_vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline km_vec3 km_vec3_cross(km_vec3 a, km_vec3 b) {
  return (km_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
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
