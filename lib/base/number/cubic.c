/* Distance from a curve of cubics (base/number/cubic.h). */
#include "base/number/cubic.h"

#include <math.h>

enum { MOST_NEWTON = 12 };

double km_cubic_distance(const double *c, int dimension, const double *place, double *u) {
  *u = 0.5;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double along = 0.0, rate = 0.0, square = 0.0;
    for (int k = 0; k < dimension; ++k) {
      double away = place[k] - km_cubic(c + 4 * k, *u), d = km_cubic_rate(c + 4 * k, *u);
      along += away * d;
      rate += d * d;
      square += away * away;
    }
    if (fabs(along) <= KM_CUBIC_END * rate) {
      bool is_beside = fabs(*u - 0.5) <= 0.5 + KM_CUBIC_END;
      *u = fmin(fmax(*u, 0.0), 1.0);
      return is_beside ? sqrt(square) : HUGE_VAL;
    }
    *u = fmin(fmax(*u + along / rate, -0.5), 1.5);
  }
  return HUGE_VAL;
}
