/* The larger and the smaller of two numbers as processors take them: without fmax's care for what is no number, which costs
 * a call. */
#ifndef KM_BASE_EXTREMA_H
#define KM_BASE_EXTREMA_H

#include <math.h>

/* a > b ? a : b: b where one of them is no number. */
static inline double km_larger(double a, double b) {
  return a > b ? a : b;
}
/* a < b ? a : b: b where one of them is no number. */
static inline double km_smaller(double a, double b) {
  return a < b ? a : b;
}

/* The larger of two, or what is no number, once one of them is none. */
static inline double km_larger_or_nan(double a, double b) {
  return a <= b || isnan(b) ? b : a;
}

#endif
