#include "lapack.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

static void set_numbers(lapack_space *s, int columns) {
  for (int j = 0; j < columns; ++j)
    s->numbers[j] = 0.0;
  for (int k = 0; k < columns - s->rank; ++k)
    for (int j = 0; j < columns; ++j)
      s->numbers[j] += s->Z[k * columns + j] * s->Z[k * columns + j];
}

/* J = U Σ Vᵀ: Z is the columns of V past the rank. */
void lapack_by_svd(lapack_space *s, const double *matrix, int rows, int columns, double tolerance) {
  memcpy(s->A, matrix, (size_t)(rows * columns) * sizeof *s->A);
  LAPACKE_dgesdd_work(LAPACK_COL_MAJOR, 'S', rows, columns, s->A, rows, s->sigma, s->U, rows, s->VT, columns, s->work,
                      LAPACK_WORK, s->integers);
  s->rank = 0;
  while (s->rank < columns && s->sigma[s->rank] > tolerance * s->sigma[0])
    ++s->rank;
  for (int k = s->rank; k < columns; ++k)
    for (int j = 0; j < columns; ++j)
      s->Z[(k - s->rank) * columns + j] = s->VT[j * columns + k];
  set_numbers(s, columns);
}

/* J P = Q [R1 R2; 0 0]: N = P [−R1⁻¹R2; I], Z its orthonormal factor. */
void lapack_by_qr(lapack_space *s, const double *matrix, int rows, int columns, double tolerance) {
  memcpy(s->A, matrix, (size_t)(rows * columns) * sizeof *s->A);
  memset(s->integers, 0, (size_t)columns * sizeof *s->integers);
  LAPACKE_dgeqp3_work(LAPACK_COL_MAJOR, rows, columns, s->A, rows, s->integers, s->tau, s->work, LAPACK_WORK);
  int rank = 0;
  while (rank < columns && fabs(s->A[rank * rows + rank]) > tolerance * fabs(s->A[0]))
    ++rank;
  s->rank = rank;
  int freedom = columns - rank;
  LAPACKE_dtrtrs_work(LAPACK_COL_MAJOR, 'U', 'N', 'N', rank, freedom, s->A, rows, s->A + rank * rows, rows);
  memset(s->Z, 0, (size_t)(columns * freedom) * sizeof *s->Z);
  for (int k = 0; k < freedom; ++k) {
    for (int i = 0; i < rank; ++i)
      s->Z[k * columns + s->integers[i] - 1] = -s->A[(rank + k) * rows + i];
    s->Z[k * columns + s->integers[rank + k] - 1] = 1.0;
  }
  LAPACKE_dgeqrf_work(LAPACK_COL_MAJOR, columns, freedom, s->Z, columns, s->tau, s->work, LAPACK_WORK);
  LAPACKE_dorgqr_work(LAPACK_COL_MAJOR, columns, freedom, freedom, s->Z, columns, s->tau, s->work, LAPACK_WORK);
  set_numbers(s, columns);
}
