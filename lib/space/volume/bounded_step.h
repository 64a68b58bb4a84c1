/* Damped least-squares step with bounds, by active rows from the free step on (as D. Goldfarb, A. Idnani 1983, but
 * without their step lengths).
 *
 *   min ½ |A w − d|² + ½ ε |w|²   subject to   N w <= s
 *   active rows S:   (H  N_Sᵀ; N_S  0) (w; λ) = (Aᵀ d; s_S),   H = Aᵀ A + ε I,   λ >= 0 */
#ifndef KM_SPACE_BOUNDED_STEP_H
#define KM_SPACE_BOUNDED_STEP_H

#include "base/memory.h"

#include <stdbool.h>

typedef struct km_bounded_step {
  int rows, columns; /* size of A; columns <= most_columns */
  int bound_count;   /* <= most_bounds */
  int most_columns, most_bounds;
  double *A;              /* [rows × columns], column-major */
  double *bound;          /* [bound][columns] rows of N */
  double *slack;          /* [bound] s; negative: the step must go back at least so far */
  double *w;              /* [columns] the step */
  double *matrix, *right; /* [(2 most_columns)²], [2 most_columns] workspace */
  double *solution;       /* [2 most_columns] */
  int *pivot, *active;    /* [2 most_columns], [most_columns] */
  bool *is_active;        /* [bound] */
} km_bounded_step;

/* Allocates for matrices of up to 3 rows. False when out of memory. */
bool km_bounded_step_create(km_bounded_step *step, int most_columns, int most_bounds, km_arena *arena);
/* Finds w. False if the active rows depend on each other, more bounds are exceeded than columns, or rounding keeps the
 * method from ending: a step within the bounds may exist then. O(active · columns³). */
bool km_bounded_step_find(km_bounded_step *step, const double *d, double epsilon);
/* |d|² − |d − A w|²: what the step takes from the square of the distance. */
double km_bounded_step_decrease(const km_bounded_step *step, const double *d);

#endif
