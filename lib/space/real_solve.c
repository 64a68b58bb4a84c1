/* Small dense matrices over the real numbers (space/real_solve.h). */
#include "space/real_solve.h"

#include <math.h>

enum { MOST_SWEEPS = 30 };
static const double orthogonal = 1e-30; /* squared cosine of columns that are orthogonal to rounding */

bool km_real_factor(double *A, int n, int *row, int *sign) {
  *sign = 1;
  for (int i = 0; i < n; ++i)
    row[i] = i;
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (fabs(A[i * n + k]) > fabs(A[best * n + k]))
        best = i;
    double pivot = A[best * n + k];
    if (!(fabs(pivot) > 0.0) || !isfinite(pivot))
      return false;
    if (best != k) {
      for (int j = 0; j < n; ++j) {
        double kept = A[k * n + j];
        A[k * n + j] = A[best * n + j];
        A[best * n + j] = kept;
      }
      int kept = row[k];
      row[k] = row[best];
      row[best] = kept;
      *sign = -*sign;
    }
    *sign = pivot < 0.0 ? -*sign : *sign;
    for (int i = k + 1; i < n; ++i) {
      double factor = A[i * n + k] /= pivot;
      for (int j = k + 1; factor != 0.0 && j < n; ++j)
        A[i * n + j] -= factor * A[k * n + j];
    }
  }
  return true;
}

double km_real_determinant(double *A, int n, int *row) {
  int sign;
  if (!km_real_factor(A, n, row, &sign))
    return 0.0;
  double product = sign;
  for (int i = 0; i < n; ++i)
    product *= fabs(A[i * n + i]);
  return product;
}

void km_real_solve(const double *LU, int n, const int *row, const double *b, double *x) {
  for (int i = 0; i < n; ++i) {
    x[i] = b[row[i]];
    for (int j = 0; j < i; ++j)
      x[i] -= LU[i * n + j] * x[j];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j)
      x[i] -= LU[i * n + j] * x[j];
    x[i] /= LU[i * n + i];
  }
}

/* Rotations of pairs of columns until they are orthogonal (one-sided Jacobi method, M. R. Hestenes 1958). */
double km_singular_value(double *A, int rows, int columns, int rank) {
  bool is_rotated = true;
  for (int sweep = 0; is_rotated && sweep < MOST_SWEEPS; ++sweep) {
    is_rotated = false;
    for (int i = 0; i < columns; ++i)
      for (int j = i + 1; j < columns; ++j) {
        double *a = A + i * rows, *b = A + j * rows, aa = 0.0, bb = 0.0, ab = 0.0;
        for (int k = 0; k < rows; ++k) {
          aa += a[k] * a[k];
          bb += b[k] * b[k];
          ab += a[k] * b[k];
        }
        if (!(ab * ab > orthogonal * aa * bb))
          continue;
        is_rotated = true;
        double zeta = (bb - aa) / (2.0 * ab), t = copysign(1.0, zeta) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
        double c = 1.0 / sqrt(1.0 + t * t), s = c * t;
        for (int k = 0; k < rows; ++k) {
          double kept = a[k];
          a[k] = c * kept - s * b[k];
          b[k] = s * kept + c * b[k];
        }
      }
  }
  for (int i = 0; i < columns; ++i) { /* squares of the lengths, the largest first */
    double square = 0.0;
    for (int k = 0; k < rows; ++k)
      square += A[i * rows + k] * A[i * rows + k];
    int at = i;
    for (; at > 0 && A[at - 1] < square; --at)
      A[at] = A[at - 1];
    A[at] = square;
  }
  return sqrt(A[rank - 1]);
}
