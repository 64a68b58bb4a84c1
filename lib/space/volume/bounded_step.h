/* Damped least-squares step with bounds, by the dual method of active sets (D. Goldfarb, A. Idnani 1983).
 *
 *   min ½ |A w − d|² + ½ ε |w|²   subject to   N w <= s
 *   start      : H w = Aᵀ d,   H = Aᵀ A + ε I,   no active rows S
 *   bound n, s exceeded:   (H  N_Sᵀ; N_S  0) (z; y) = (−n; 0),   w += t z,   λ_S += t y,   λ += t
 *   t          : the less of (n·w − s)/(−n·z), where the bound is met and becomes active, and of λ_a/(−y_a), y_a < 0,
 *                where an active row is released; the first is infinite if n depends on the active rows
 *   Each t increases the dual objective, so that no set returns: the method ends with the step, or with t infinite,
 *   which proves that no step satisfies all bounds. */
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
  int active_count;       /* active bounds: <= columns, as their rows are independent */
  double *lambda;         /* [active] their multipliers */
  double *matrix, *right; /* [(2 most_columns)²], [2 most_columns] workspace */
  double *solution;       /* [2 most_columns] */
  int *pivot, *active;    /* [2 most_columns], [most_columns] */
  bool *is_active;        /* [bound] */
} km_bounded_step;

/* Allocates for matrices of up to 3 rows. False when out of memory. */
bool km_bounded_step_create(km_bounded_step *step, int most_columns, int most_bounds, km_arena *arena);
/* Finds w; ε is the larger of `damping` and 1e-8 |A|². False if the bounds exclude each other; to rounding, which also
 * ends a set that returns. O(active · columns³). */
bool km_bounded_step_find(km_bounded_step *step, const double *d, double damping);
/* |d|² − |d − A w|²: what the step takes from the square of the distance. */
double km_bounded_step_decrease(const km_bounded_step *step, const double *d);

#endif
