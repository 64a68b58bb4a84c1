/* Sums over the entries of a vector, in their order, and projections. */
#ifndef KM_BASE_NUMBER_VECTORS_H
#define KM_BASE_NUMBER_VECTORS_H

#include "base/extrema.h"

/* aᵀ b. */
static inline double km_dot(const double *a, const double *b, int count) {
  double sum = 0.0;
  for (int i = 0; i < count; ++i)
    sum += a[i] * b[i];
  return sum;
}

/* |a|₂. */
static inline double km_norm(const double *a, int count) {
  return sqrt(km_dot(a, a, count));
}

/* |a|_∞; NaN if an entry is NaN. */
static inline double km_max_norm(const double *a, int count) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i)
    largest = km_larger_or_nan(fabs(a[i]), largest);
  return largest;
}

/* v −= (uᵀ v) u: removes the part along a unit vector u. */
static inline void km_remove_projection(const double *u, double *v, int count) {
  double along = km_dot(u, v, count);
  for (int i = 0; i < count; ++i)
    v[i] -= along * u[i];
}

#endif
