/* Singular value decomposition A = U S Vᵀ of a small matrix by Jacobi's method. */
#ifndef KM_LINALG_DENSE_JACOBI_SVD_H
#define KM_LINALG_DENSE_JACOBI_SVD_H

#include "kmech/base.h"

#include <stdbool.h>

/* Arguments and errors of km_singular_value_decomposition without KM_IO; A is kept. O(10 rows · columns · min(rows,
 * columns)), and `complete` O(max(rows, columns)³). */
km_status km_jacobi_svd(int rows, int columns, const double *A, bool complete, double *s, double *U, double *Vt,
                        km_error *error);

#endif
