/* Maximum and minimum by one instruction. fmax and fmin treat NaN specially, at the cost of a call. */
#ifndef KM_BASE_EXTREMA_H
#define KM_BASE_EXTREMA_H

#include <math.h>

/* The maximum of a and b; it is b if one of them is NaN. */
static inline double km_larger(double a, double b) {
  return a > b ? a : b;
}
/* The minimum of a and b; it is b if one of them is NaN. */
static inline double km_smaller(double a, double b) {
  return a < b ? a : b;
}

/* The maximum; NaN if one of them is NaN. */
static inline double km_larger_or_nan(double a, double b) {
  return a <= b || isnan(b) ? b : a;
}

#endif
