/* Finds a dependent column that no pivot shows: where entries differ much, LU of one column after the other may share a
 * vanishing singular value among several small pivots. Inverse iteration finds the smallest singular value of the block
 * of pivots and its right vector; with the vector's largest column behind the others, what is left of it is at most that value
 * over that entry (T. Chan, Rank revealing QR factorizations, 1987, for LU). */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>

/* (LU)⁻ᵀ y, both by step. */
static void solve_transposed(const km_partition *p, double *y) {
  const km_sparse *s = p->sparse;
  for (int k = 0; k < p->rank; ++k) {
    const km_entry_range *above = &s->upper[p->column[k]];
    for (int i = above->start; i < above->end; ++i)
      y[k] -= s->upper_store.value[i] * y[s->upper_store.index[i]];
    y[k] *= p->inverse[k];
  }
  for (int k = p->rank - 1; k >= s->singleton_count; --k) {
    const km_entry_range *below = &s->lower[p->column[k]];
    for (int i = below->start; i < below->end; ++i)
      y[k] -= s->lower_store.value[i] * y[s->step_of[s->lower_store.index[i]]];
  }
}

/* (LU)⁻¹ y, both by step. */
static void solve(const km_partition *p, double *y) {
  const km_sparse *s = p->sparse;
  for (int k = s->singleton_count; k < p->rank; ++k) {
    const km_entry_range *below = &s->lower[p->column[k]];
    for (int i = below->start; i < below->end && y[k] != 0.0; ++i)
      y[s->step_of[s->lower_store.index[i]]] -= s->lower_store.value[i] * y[k];
  }
  km_sparse_solve_upper(p, y);
}

/* The right vector of the block's smallest singular value, by step, into the workspace; false: the value is above the
 * threshold, or no column has enough of the vector. *most: the step with the largest entry of a column that isn't given. */
static bool is_singular(const km_partition *p, const bool *forced, double threshold, int *most) {
  static const double start[] = {1.0, 1.25, 1.375, 1.0, 1.5, 1.125, 1.75}; /* no symmetry of mechanisms */
  enum { STARTS = sizeof start / sizeof *start };
  double *y = p->work;
  *most = -1;
  for (int k = 0, i = 0; k < p->rank; ++k, i = i + 1 < STARTS ? i + 1 : 0)
    y[k] = start[i];
  solve_transposed(p, y);
  double first = sqrt(km_sum_of_squares(y, p->rank));
  solve(p, y); /* once is enough: so small a value stands out by the square of its digits */
  double length = sqrt(km_sum_of_squares(y, p->rank));
  if (!(length * threshold >= first && first > 0.0 && isfinite(length))) /* first / length: the singular value */
    return false;
  for (int k = 0; k < p->rank; ++k)
    if (!km_sparse_is_preset(p, forced, p->column[k]) && (*most < 0 || fabs(y[k]) > fabs(y[*most])))
      *most = k;
  return *most >= 0 && fabs(y[*most]) * threshold >= first;
}

int km_sparse_hidden_column(const km_partition *p, const bool *forced, double threshold) {
  int most;
  return is_singular(p, forced, threshold, &most) ? p->column[most] : -1;
}

/* Does each row keep more than the threshold from what the others span? By the left vector y, of whose products with the columns
 * those in the block of pivots have the sum of squares `square`: a row is |Jᵀy| over its entry of y away from the others, about. */
static bool rows_stand_apart(const km_partition *p, const double *matrix, const bool *forced, double threshold,
                             const double *y, double square) {
  const km_sparse *s = p->sparse;
  for (int k = p->rank; k < p->columns; ++k) {
    int c = p->column[k];
    double sum = 0.0;
    for (int i = s->start[c]; i < s->start[c + 1] && !km_sparse_is_preset(p, forced, c); ++i)
      if (s->step_of[s->row[i]] >= 0)
        sum += matrix[i] * y[s->step_of[s->row[i]]];
    square += sum * sum;
  }
  return sqrt(square) > threshold * km_max_magnitude(y, p->rank);
}

int km_sparse_hidden_row(const km_partition *p, const double *matrix, const bool *forced, double threshold) {
  int most;
  double *y = p->work;
  if (!is_singular(p, forced, threshold, &most))
    return -1;
  double square = km_sum_of_squares(y, p->rank);
  solve_transposed(p, y);
  if (rows_stand_apart(p, matrix, forced, threshold, y, square))
    return -1;
  most = 0;
  for (int k = 1; k < p->rank; ++k)
    most = fabs(y[k]) > fabs(y[most]) ? k : most;
  return p->row[most];
}
