/* Linear equations over the complex numbers: LU with row pivoting, and elimination with complete pivoting.
 *
 *   P A = L U,   |·| = |Re| + |Im| in the choice of pivots */
#ifndef KM_SPACE_COMPLEX_COMPLEX_SOLVE_H
#define KM_SPACE_COMPLEX_COMPLEX_SOLVE_H

#include <complex.h>
#include <stdbool.h>

/* Factors A[n × n], by rows of `stride` numbers, in place; row[n] is the order of the rows. Zeros are skipped, so
 * sparse columns belong first. False: A is singular or not finite. O(n³). */
bool km_complex_factor(double complex *A, int n, int stride, int *row);
/* Solves A x = b with the factors; x must not be b. O(n²). */
void km_complex_solve(const double complex *LU, int n, int stride, const int *row, const double complex *b,
                      double complex *x);

/* Gauss-Jordan elimination of A[rows × columns] with complete pivoting: leaves [I B] in the first rank rows and pivot
 * columns. Pivots below `tolerance` times the first one count as 0. row, column: orders, pivots first. Returns the
 * rank. */
int km_complex_eliminate(double complex *A, int rows, int columns, double tolerance, int *row, int *column);

#endif
