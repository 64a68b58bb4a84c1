/* LU and Gauss-Jordan elimination over the complex numbers (complex_solve.h). */
#include "space/complex/complex_solve.h"

#include <math.h>

static double size_of(double complex z) {
  return fabs(creal(z)) + fabs(cimag(z));
}

static void exchange(int *order, int a, int b) {
  int before = order[a];
  order[a] = order[b];
  order[b] = before;
}

bool km_complex_factor(double complex *A, int n, int stride, int *row) {
  for (int i = 0; i < n; ++i)
    row[i] = i;
  for (int k = 0; k < n; ++k) {
    int best = k;
    double largest = 0.0;
    for (int i = k; i < n; ++i) {
      double size = size_of(A[row[i] * stride + k]);
      if (size > largest) {
        largest = size;
        best = i;
      }
    }
    if (!(largest > 0.0 && isfinite(largest)))
      return false;
    exchange(row, k, best);
    const double complex *pivot_row = A + row[k] * stride;
    double complex inverse = 1.0 / pivot_row[k];
    for (int i = k + 1; i < n; ++i) {
      double complex *r = A + row[i] * stride;
      if (r[k] == 0.0)
        continue;
      double complex factor = r[k] *= inverse;
      for (int j = k + 1; j < n; ++j)
        r[j] -= factor * pivot_row[j];
    }
  }
  return true;
}

void km_complex_solve(const double complex *LU, int n, int stride, const int *row, const double complex *b,
                      double complex *x) {
  for (int i = 0; i < n; ++i) {
    const double complex *r = LU + row[i] * stride;
    double complex sum = b[row[i]];
    for (int j = 0; j < i; ++j)
      sum -= r[j] * x[j];
    x[i] = sum;
  }
  for (int i = n - 1; i >= 0; --i) {
    const double complex *r = LU + row[i] * stride;
    double complex sum = x[i];
    for (int j = i + 1; j < n; ++j)
      sum -= r[j] * x[j];
    x[i] = sum / r[i];
  }
}

int km_complex_eliminate(double complex *A, int rows, int columns, double tolerance, int *row, int *column) {
  for (int i = 0; i < rows; ++i)
    row[i] = i;
  for (int j = 0; j < columns; ++j)
    column[j] = j;
  double first = 0.0;
  int rank = 0;
  for (; rank < rows && rank < columns; ++rank) {
    int best_row = rank, best_column = rank;
    double largest = 0.0;
    for (int i = rank; i < rows; ++i)
      for (int j = rank; j < columns; ++j) {
        double size = size_of(A[row[i] * columns + column[j]]);
        if (size > largest) {
          largest = size;
          best_row = i;
          best_column = j;
        }
      }
    if (rank == 0)
      first = largest;
    if (!(largest > tolerance * first))
      break;
    exchange(row, rank, best_row);
    exchange(column, rank, best_column);
    double complex *pivot_row = A + row[rank] * columns, inverse = 1.0 / pivot_row[column[rank]];
    for (int j = 0; j < columns; ++j)
      pivot_row[j] *= inverse;
    for (int i = 0; i < rows; ++i) {
      double complex *r = A + row[i] * columns, factor = r[column[rank]];
      if (i == rank || factor == 0.0)
        continue;
      for (int j = 0; j < columns; ++j)
        r[j] -= factor * pivot_row[j];
    }
  }
  return rank;
}
