/* Eigenvalues of a general matrix. LAPACK's dgeev does it by LAPACKE, loaded when it is first needed. */
#ifndef KM_LINALG_DENSE_EIGENVALUES_H
#define KM_LINALG_DENSE_EIGENVALUES_H

#include "kmech/base.h"

/* Of A[n × n], column-major, which is spoilt: real and imaginary parts [n], and the eigenvectors as LAPACK leaves
 * them, of length 1, in right[n × n] and left[n × n] (NULL: they aren't asked for): one column for a real eigenvalue; of a pair, the first of which has the positive imaginary
 * part, the real part and then the imaginary part of that one's. n > 0. KM_IO: LAPACKE isn't installed; KM_DIVERGED: a
 * number isn't finite, or the iteration doesn't end; KM_MEMORY. O(n³). */
km_status km_eigen(int n, double *A, double *real, double *imaginary, double *left, double *right, km_error *error);

#endif
