/* Welford's recurrence on scaled numbers. */
#include "base/statistics/running_moments.h"

#include <math.h>
#include <stdbool.h>

/* Numbers up to 2^400 in units of the first one: their squares and the sum of a billion of these stay below 2^1024. */
static const double largest_scaled = 0x1p400;

double km_moments_scaled(const km_moments *m, double x) {
  return ldexp(x, -m->exponent);
}

/* Chooses the unit by the first number that isn't 0, and again by a number that is much larger. */
static double choose_exponent(km_moments *m, double x) {
  int before = m->exponent;
  bool first = m->mean == 0.0 && m->squares == 0.0;
  if (x == 0.0 || !(first || fabs(km_moments_scaled(m, x)) > largest_scaled))
    return 1.0;
  m->exponent = ilogb(x);
  double factor = first ? 1.0 : ldexp(1.0, before - m->exponent);
  m->mean *= factor;
  m->squares *= factor * factor;
  return factor;
}

double km_moments_add(km_moments *m, double x) {
  double factor = choose_exponent(m, x);
  double scaled = km_moments_scaled(m, x), before = scaled - m->mean;
  m->count += 1.0;
  m->mean += before / m->count;
  m->squares += before * (scaled - m->mean);
  return factor;
}

double km_moments_mean(const km_moments *m) {
  return ldexp(m->mean, m->exponent);
}

double km_moments_deviation(const km_moments *m) {
  return m->count > 1.0 ? ldexp(sqrt(m->squares / (m->count - 1.0)), m->exponent) : nan("");
}
