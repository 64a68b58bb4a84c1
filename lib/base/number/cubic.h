/* Cubics: c(u) = c0 + c1 u + c2 u² + c3 u³. */
#ifndef KM_BASE_CUBIC_H
#define KM_BASE_CUBIC_H

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

#endif
