/* Mean and standard deviation in one pass, without overflow. Private to the library. */
#ifndef KM_BASE_STATISTICS_RUNNING_MOMENTS_H
#define KM_BASE_STATISTICS_RUNNING_MOMENTS_H

/* Sums over x / 2^exponent, so that no square overflows or vanishes. Start from {0}.
 *
 *   mean    = Σ x / count                in 2^exponent
 *   squares = Σ (x − mean)²              in 4^exponent
 *
 * by B. P. Welford's recurrence (Technometrics 4, 1962). A power of two changes no digit of a sum. */
typedef struct km_moments {
  int exponent;
  double count, mean, squares;
} km_moments;

/* Adds a finite number. Returns the factor by which the sums of the numbers before were multiplied, a power of two. */
double km_moments_add(km_moments *moments, double x);
/* The number in the unit of the sums, x / 2^exponent. */
double km_moments_scaled(const km_moments *moments, double x);
double km_moments_mean(const km_moments *moments);
/* √(squares / (count − 1)); NaN for fewer than two numbers. Infinite where it exceeds the largest double. */
double km_moments_deviation(const km_moments *moments);

#endif
