/* Small dense matrices over the real numbers, of the size of one closed mechanism.
 *
 *   P A = L U   with row pivoting */
#ifndef KM_SPACE_REAL_SOLVE_H
#define KM_SPACE_REAL_SOLVE_H

#include <stdbool.h>

/* Factors A[n × n], by rows, in place; row[n] is the order of the rows. *sign is the sign of det A. False: a pivot is
 * 0 or not finite. O(n³). */
bool km_real_factor(double *A, int n, int *row, int *sign);
/* Solves A x = b with the factors; x must not be b. O(n²). */
void km_real_solve(const double *LU, int n, const int *row, const double *b, double *x);
/* det A of A[n × n], which is destroyed; 0 where a pivot is. O(n³). */
double km_real_determinant(double *A, int n, int *row);
/* Singular value number `rank` from the largest, of A[rows × columns], column-major. A is destroyed. O(10 rows
 * columns²). */
double km_singular_value(double *A, int rows, int columns, int rank);

#endif
