/* Hidden dependence: a dependent column that no pivot shows (docs/theory.md 3.6).
 *
 *   y = (L U)⁻¹ (L U)⁻ᵀ start:   σ_min ≈ |(L U)⁻ᵀ start| / |y|,   y its right singular vector
 *
 * LU by columns can share a vanishing singular value among several small pivots. The column with the largest entry of y
 * is postponed: its remainder is then at most σ_min over that entry (T. Chan 1987, for LU). Rows are treated alike by
 * the left singular vector. */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>

/* y <- (L U)⁻ᵀ y, by step. */
static void solve_pivot_block_transposed(const km_factor *p, double *y) {
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

/* y <- (L U)⁻¹ y over all steps of the pivot block; column singletons come first and have no entries in L. */
static void solve_pivot_block(const km_factor *p, double *y) {
  const km_sparse *s = p->sparse;
  for (int k = s->singleton_count; k < p->rank; ++k) {
    const km_entry_range *below = &s->lower[p->column[k]];
    for (int i = below->start; i < below->end && y[k] != 0.0; ++i)
      y[s->step_of[s->lower_store.index[i]]] -= s->lower_store.value[i] * y[k];
  }
  km_sparse_solve_upper(p, y);
}

/* Inverse iteration: right vector of the pivot block's smallest singular value, by step, into `work`. False if the
 * value is above the threshold, or no column has a sufficient entry. *largest_step: step of the largest entry among
 * columns that are not preset. */
static bool find_singular_vector(const km_factor *p, const bool *forced, double threshold, int *largest_step) {
  static const double start[] = {1.0, 1.25,  1.375, 1.0,
                                 1.5, 1.125, 1.75}; /* a pattern without the symmetries of
                                                                            * mechanisms */
  enum { STARTS = sizeof start / sizeof *start };
  double *y = p->work;
  *largest_step = -1;
  for (int k = 0, i = 0; k < p->rank; ++k, i = i + 1 < STARTS ? i + 1 : 0)
    y[k] = start[i];
  solve_pivot_block_transposed(p, y);
  double first = sqrt(km_pair_dot(y, y, p->rank));
  solve_pivot_block(p, y); /* one iteration suffices: it amplifies so small a value by its inverse square */
  double length = sqrt(km_pair_dot(y, y, p->rank));
  if (!(length * threshold >= first && first > 0.0 && isfinite(length))) /* first / length is the singular value */
    return false;
  for (int k = 0; k < p->rank; ++k)
    if (!km_sparse_is_preset(p, forced, p->column[k]) && (*largest_step < 0 || fabs(y[k]) > fabs(y[*largest_step])))
      *largest_step = k;
  return *largest_step >= 0 && fabs(y[*largest_step]) * threshold >= first;
}

int km_sparse_hidden_column(const km_factor *p, const bool *forced, double threshold) {
  int largest_step;
  return find_singular_vector(p, forced, threshold, &largest_step) ? p->column[largest_step] : -1;
}

/* True if each row is more than the threshold away from the span of the others. y: left vector; `square`: sum of
 * squares of its products with the columns of the pivot block. The distance of a row is about |Jᵀ y| over its entry of
 * y. */
static bool are_rows_independent(const km_factor *p, const double *matrix, const bool *forced, double threshold,
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

/* Row with the largest entry of the left singular vector, if the rows are dependent. */
int km_sparse_hidden_row(const km_factor *p, const double *matrix, const bool *forced, double threshold) {
  int largest_step;
  double *y = p->work;
  if (!find_singular_vector(p, forced, threshold, &largest_step))
    return -1;
  double square = km_pair_dot(y, y, p->rank);
  solve_pivot_block_transposed(p, y);
  if (are_rows_independent(p, matrix, forced, threshold, y, square))
    return -1;
  largest_step = 0;
  for (int k = 1; k < p->rank; ++k)
    largest_step = fabs(y[k]) > fabs(y[largest_step]) ? k : largest_step;
  return p->row[largest_step];
}
