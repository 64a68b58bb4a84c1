/* Vectors over the complex numbers: products have no conjugate, so the transpose inverts a rotation. Private to
 * space/. */
#ifndef KM_SPACE_COMPLEX_COMPLEX_VECTORS_H
#define KM_SPACE_COMPLEX_COMPLEX_VECTORS_H

#include "space/complex/complex_closure.h"

static inline km_complex km_complex_dot(const km_complex *a, const km_complex *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* out = a × b; out may be a or b. */
static inline void km_complex_cross(const km_complex *a, const km_complex *b, km_complex *out) {
  km_complex x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  out[0] = x;
  out[1] = y;
  out[2] = z;
}

static inline void km_complex_narrow(const km_wide *a, int count, km_complex *out) {
  for (int k = 0; k < count; ++k)
    out[k] = (km_complex)a[k];
}

/* out = R a; out must not be a. */
static inline void km_wide_rotate(km_wide (*R)[3], const km_wide *a, km_wide *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = a[0] * R[0][k] + a[1] * R[1][k] + a[2] * R[2][k];
}

/* out = Rᵀ a; out must not be a. */
static inline void km_wide_rotate_back(km_wide (*R)[3], const km_wide *a, km_wide *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = R[k][0] * a[0] + R[k][1] * a[1] + R[k][2] * a[2];
}

#endif
