/* Baseline: rank, null space and mobility numbers of a dense matrix by LAPACK. Workspace is allocated beforehand, so
 * that only arithmetic is timed. */
#ifndef BENCH_LAPACK_H
#define BENCH_LAPACK_H

enum { LAPACK_ROWS = 32, LAPACK_COLUMNS = 32, LAPACK_WORK = 1 << 15 };

typedef struct lapack_space {
  double A[LAPACK_ROWS * LAPACK_COLUMNS], U[LAPACK_ROWS * LAPACK_COLUMNS];
  double VT[LAPACK_COLUMNS * LAPACK_COLUMNS], sigma[LAPACK_COLUMNS], tau[LAPACK_COLUMNS];
  double work[LAPACK_WORK];
  int integers[8 * LAPACK_COLUMNS]; /* workspace of dgesdd, pivots of dgeqp3 */
  int rank;
  double Z[LAPACK_COLUMNS * LAPACK_COLUMNS]; /* columns × (columns − rank) */
  double numbers[LAPACK_COLUMNS];
} lapack_space;

/* Computes these for `matrix`, rows × columns, rows ≥ columns, column-major. */
void lapack_by_svd(lapack_space *space, const double *matrix, int rows, int columns, double tolerance);
void lapack_by_qr(lapack_space *space, const double *matrix, int rows, int columns, double tolerance);

#endif
