/* Linear equations over the real numbers: LU with row pivoting (space/real_solve.h). */
#include "space/real_solve.h"

#include <math.h>

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
