/* Singular value decomposition A = U S Vᵀ: Jacobi's method for small matrices, else LAPACK's dgesdd, loaded when it is
 * used first. */
#ifndef KM_LINALG_DENSE_SINGULAR_VALUES_H
#define KM_LINALG_DENSE_SINGULAR_VALUES_H

#include "kmech/base.h"

#include <stdbool.h>

enum {
  KM_SMALL_SVD = 64 /* rows and columns up to which Jacobi's method takes less time than the loading of LAPACK */
};

/* Decomposes A[rows × columns], column-major, which is overwritten. s[min(rows, columns)]: singular values, largest
 * first. `complete`: U[rows × rows] and Vt[columns × columns] are orthogonal; otherwise U[rows × min] and Vt[min ×
 * columns]. rows, columns > 0. KM_IO: LAPACKE, which larger matrices need, is not installed; KM_DIVERGED: a number is
 * not finite, or the iteration does not converge; KM_MEMORY. O(rows · columns · max(rows, columns)). */
km_status km_singular_value_decomposition(int rows, int columns, double *A, bool complete, double *s, double *U,
                                          double *Vt, km_error *error);

#endif
