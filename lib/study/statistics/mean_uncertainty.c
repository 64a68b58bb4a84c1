/* Kish's design effect of a sample whose designs share parameters within rows (docs/theory.md 13.3).
 *
 *   effect = variance of the row sums / variance of as many independent designs,  between 1 and the width of a row */
#include "study/statistics/mean_uncertainty.h"

#include <math.h>

void km_rows_add(km_rows *r, double value) {
  if (r->count == 0.0)
    r->from = value;
  r->n += 1.0;
  r->x += value - r->from;
  r->count += 1.0;
  r->total += value - r->from;
}

void km_rows_scale(km_rows *r, double factor) {
  if (factor == 1.0)
    return;
  r->from *= factor;
  r->x *= factor;
  r->nx *= factor;
  r->xx *= factor * factor;
  r->total *= factor;
}

void km_rows_next(km_rows *r) {
  r->rows += r->n > 0.0;
  r->nn += r->n * r->n;
  r->nx += r->n * r->x;
  r->xx += r->x * r->x;
  r->n = r->x = 0.0;
}

/* Variance of the row sums over that of independent designs, clamped to 1 … width. */
double km_rows_effect(const km_rows *r, double squares) {
  if (r->width <= 1.0 || !(squares > 0.0))
    return 1.0;
  double mean = r->total / r->count, of_rows = r->xx - 2.0 * mean * r->nx + mean * mean * r->nn;
  double effect = of_rows * r->rows / (r->rows - 1.0) / (squares * r->count / (r->count - 1.0));
  return fmax(1.0, fmin(effect, r->width));
}
