/* Singular values of a small matrix by one-sided Jacobi rotations (M. Hestenes 1958), without LAPACK's time of loading.
 *
 *   W = B V,  B [m × n], m >= n;   rotations of columns p, q of W and V until all |w_p · w_q| <= m ε |w_p| |w_q|,
 *            ε the rounding of a number; columns shorter than m ε |B| are rounding and aren't rotated
 *   tan 2θ = 2 w_p · w_q/(|w_p|² − |w_q|²);   s_k = |w_k|,  u_k = w_k/s_k
 *
 * Columns of U whose singular values are rounding complete the others to an orthonormal set. */
#include "linalg/dense/jacobi_svd.h"
#include "base/number/vectors.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_SWEEPS = 60 }; /* small matrices take about ten */

static void rotate(double *a, double *b, int count, double c, double s) {
  for (int i = 0; i < count; ++i) {
    const double x = a[i], y = b[i];
    a[i] = c * x - s * y;
    b[i] = s * x + c * y;
  }
}

/* Makes two columns of W orthogonal, with their squared lengths; false if they were, or if one is shorter than `least`,
 * which is rounding. */
static bool rotate_pair(int m, int n, double *W, double *V, double *squares, int p, int q, double least) {
  const double aa = squares[p], bb = squares[q], shorter = sqrt(fmin(aa, bb)), longer = sqrt(fmax(aa, bb));
  if (shorter <= least)
    return false;
  double *a = W + (size_t)p * (size_t)m, *b = W + (size_t)q * (size_t)m;
  const double ab = km_dot(a, b, m);
  if (!(fabs(ab) > m * DBL_EPSILON * shorter * longer))
    return false;
  const double z = (bb - aa) / (2.0 * ab), t = copysign(1.0, z) / (fabs(z) + sqrt(1.0 + z * z));
  const double c = 1.0 / sqrt(1.0 + t * t);
  rotate(a, b, m, c, c * t);
  rotate(V + (size_t)p * (size_t)n, V + (size_t)q * (size_t)n, n, c, c * t);
  squares[p] = km_dot(a, a, m);
  squares[q] = km_dot(b, b, m);
  return true;
}

/* Rotates the columns of W and V until those of W are orthogonal; false if they don't become so. */
static bool orthogonalise(int m, int n, double *W, double *V, double *squares) {
  const double least = m * DBL_EPSILON * sqrt(km_dot(W, W, m * n));
  bool has_rotated = true;
  for (int sweep = 0; sweep < MAX_SWEEPS && has_rotated; ++sweep) {
    has_rotated = false;
    for (int k = 0; k < n; ++k)
      squares[k] = km_dot(W + (size_t)k * (size_t)m, W + (size_t)k * (size_t)m, m);
    for (int p = 0; p + 1 < n; ++p)
      for (int q = p + 1; q < n; ++q)
        has_rotated = rotate_pair(m, n, W, V, squares, p, q, least) || has_rotated;
  }
  return !has_rotated;
}

static void swap_columns(double *A, int rows, int p, int q) {
  double *a = A + (size_t)p * (size_t)rows, *b = A + (size_t)q * (size_t)rows;
  for (int i = 0; i < rows; ++i) {
    const double x = a[i];
    a[i] = b[i];
    b[i] = x;
  }
}

/* Sorts the columns by their lengths, the singular values. */
static void sort_columns(int m, int n, double *W, double *V, double *s) {
  for (int k = 0; k < n; ++k)
    s[k] = sqrt(km_dot(W + (size_t)k * (size_t)m, W + (size_t)k * (size_t)m, m));
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      best = s[i] > s[best] ? i : best;
    if (best == k)
      continue;
    const double value = s[k];
    s[k] = s[best];
    s[best] = value;
    swap_columns(W, m, k, best);
    swap_columns(V, n, k, best);
  }
}

/* Column k of Q: the unit vector that is farthest from the columns before it, less its parts along them. */
static void add_orthonormal(double *Q, int m, int k) {
  double *column = Q + (size_t)k * (size_t)m, farthest = -1.0;
  int best = 0;
  for (int i = 0; i < m; ++i) {
    double square = 1.0;
    for (int j = 0; j < k; ++j)
      square -= Q[(size_t)j * (size_t)m + (size_t)i] * Q[(size_t)j * (size_t)m + (size_t)i];
    if (square > farthest) {
      farthest = square;
      best = i;
    }
  }
  memset(column, 0, (size_t)m * sizeof *column);
  column[best] = 1.0;
  for (int pass = 0; pass < 2; ++pass) /* twice is enough for orthogonality to rounding */
    for (int j = 0; j < k; ++j) {
      const double *q = Q + (size_t)j * (size_t)m, part = km_dot(q, column, m);
      for (int i = 0; i < m; ++i)
        column[i] -= part * q[i];
    }
  const double length = sqrt(km_dot(column, column, m));
  for (int i = 0; i < m; ++i)
    column[i] /= length;
}

/* Makes the first `wanted` columns of W orthonormal. */
static void normalise(int m, int n, double *W, const double *s, int wanted) {
  const double least = 2.0 * m * DBL_EPSILON * sqrt(km_dot(s, s, n)); /* columns that aren't rotated are shorter */
  for (int k = 0; k < wanted; ++k) {
    if (k >= n || !(s[k] > least)) {
      add_orthonormal(W, m, k);
      continue;
    }
    for (int i = 0; i < m; ++i)
      W[(size_t)k * (size_t)m + (size_t)i] /= s[k];
  }
}

/* Copies A[rows × columns], or its transpose. */
static void copy_matrix(int rows, int columns, const double *A, bool transposed, double *out) {
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      out[transposed ? (size_t)r * (size_t)columns + (size_t)c : (size_t)c * (size_t)rows + (size_t)r] =
          A[(size_t)c * (size_t)rows + (size_t)r];
}

km_status km_jacobi_svd(int rows, int columns, const double *A, bool complete, double *s, double *U, double *Vt,
                        km_error *error) {
  const bool is_wide = rows < columns;
  const int m = is_wide ? columns : rows, n = is_wide ? rows : columns;
  km_arena arena = {0};
  double *W = KM_ARENA_NEW(&arena, double, (size_t)m *(size_t)m),
         *V = KM_ARENA_NEW(&arena, double, (size_t)n *(size_t)n);
  if (arena.failed) {
    km_arena_free(&arena);
    return km_fail(error, KM_MEMORY, "out of memory for singular values");
  }
  copy_matrix(rows, columns, A, is_wide, W);
  for (int k = 0; k < n; ++k)
    V[(size_t)k * (size_t)n + (size_t)k] = 1.0;
  const bool has_converged = orthogonalise(m, n, W, V, s);
  sort_columns(m, n, W, V, s);
  normalise(m, n, W, s, complete ? m : n);
  /* A = W S Vᵀ, or A = V S Wᵀ of a wide matrix */
  if (is_wide) {
    memcpy(U, V, (size_t)n * (size_t)n * sizeof *U);
    copy_matrix(m, complete ? m : n, W, true, Vt);
  } else {
    memcpy(U, W, (size_t)m * (size_t)(complete ? m : n) * sizeof *U);
    copy_matrix(n, n, V, true, Vt);
  }
  km_arena_free(&arena);
  return has_converged ? KM_OK : km_fail(error, KM_DIVERGED, "the iteration for singular values doesn't end");
}
