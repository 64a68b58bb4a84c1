/* Finds a dependent column that no pivot shows: where entries differ much, LU of one column after the other may share a
 * vanishing singular value among several small pivots. Inverse iteration finds the smallest singular value of the block
 * of pivots and its right vector; with the vector's largest column behind the others, what is left of it is at most that value
 * over that entry (T. Chan, Rank revealing QR factorizations, 1987, for LU). */
#include "partition/sparse.h"

#include <math.h>

/* (LU)⁻ᵀ y, both by step. */
static void solve_transposed(const km_partition *p, double *y) {
  const km_sparse *s = p->sparse;
  for (int k = 0; k < p->rank; ++k) {
    const km_run *above = &s->upper[p->column[k]];
    for (int i = above->start; i < above->end; ++i)
      y[k] -= s->upper_store.value[i] * y[s->upper_store.index[i]];
    y[k] *= p->inverse[k];
  }
  for (int k = p->rank - 1; k >= 0; --k) {
    const km_run *below = &s->lower[p->column[k]];
    for (int i = below->start; i < below->end; ++i)
      y[k] -= s->lower_store.value[i] * y[s->step_of[s->lower_store.index[i]]];
  }
}

/* (LU)⁻¹ y, both by step. */
static void solve(const km_partition *p, double *y) {
  const km_sparse *s = p->sparse;
  for (int k = 0; k < p->rank; ++k) {
    const km_run *below = &s->lower[p->column[k]];
    for (int i = below->start; i < below->end && y[k] != 0.0; ++i)
      y[s->step_of[s->lower_store.index[i]]] -= s->lower_store.value[i] * y[k];
  }
  km_sparse_solve_upper(p, y);
}

/* Over its length, which is returned; 0 where that is no number. */
static double unit(double *y, int count) {
  double most = 0.0, sum = 0.0;
  for (int k = 0; k < count; ++k)
    most = fmax(most, fabs(y[k]));
  for (int k = 0; k < count && most > 0.0; ++k)
    sum += y[k] / most * (y[k] / most);
  double length = most * sqrt(sum);
  for (int k = 0; k < count && length > 0.0; ++k)
    y[k] /= length;
  return isfinite(length) ? length : 0.0;
}

int km_sparse_hidden(const km_partition *p, const bool *forced, double threshold) {
  double *y = p->work;
  int most = -1;
  for (int k = 0; k < p->rank; ++k)
    y[k] = k % 2 ? 1.0 : 1.0 + (double)(k % 7) / 8.0; /* any vector with no symmetry of mechanisms */
  solve_transposed(p, y);
  if (!(unit(y, p->rank) > 0.0))
    return -1;
  solve(p, y); /* once is enough: so small a value stands out by the square of its digits */
  double inverse = unit(y, p->rank);
  for (int k = 0; k < p->rank; ++k)
    if (!km_sparse_is_given(p, forced, p->column[k]) && (most < 0 || fabs(y[k]) > fabs(y[most])))
      most = k;
  bool hidden = most >= 0 && inverse * threshold * fabs(y[most]) >= 1.0; /* 1/inverse: its singular value */
  return hidden ? p->column[most] : -1;
}
