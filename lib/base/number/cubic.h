/* Cubics: c(u) = c0 + c1 u + c2 u² + c3 u³. */
#ifndef KM_BASE_CUBIC_H
#define KM_BASE_CUBIC_H

#include <stdbool.h>

/* Places so far beyond an end, in u, count for it; so do corrections that end Newton's method. */
#define KM_CUBIC_END 1e-6

/* Coefficients of the cubic with the values a and b at u = 0 and 1, and the derivatives da and db there. */
static inline void km_cubic_hermite(double a, double da, double b, double db, double *c) {
  c[0] = a;
  c[1] = da;
  c[2] = 3.0 * (b - a) - 2.0 * da - db;
  c[3] = 2.0 * (a - b) + da + db;
}

/* A cubic and its derivative at u. */
static inline double km_cubic(const double *c, double u) {
  return c[0] + u * (c[1] + u * (c[2] + u * c[3]));
}

static inline double km_cubic_rate(const double *c, double u) {
  return c[1] + u * (2.0 * c[2] + u * 3.0 * c[3]);
}

/* Distance of place[dimension] from the curve of the cubics c[dimension × 4] over u = 0 … 1, at the foot u of its
 * perpendicular: Newton's method for the root of (place − c(u)) · c'(u), c'' left out. Infinite where the foot is
 * beyond the ends or not found. O(12 dimension). */
double km_cubic_distance(const double *c, int dimension, const double *place, double *u);

#endif
