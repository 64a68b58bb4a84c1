/* Eigenvalues and eigenvectors of a general matrix by LAPACK's dgeev, loaded at the first use. */
#ifndef KM_LINALG_DENSE_EIGENVALUES_H
#define KM_LINALG_DENSE_EIGENVALUES_H

#include "kmech/base.h"

/* Computes the eigenvalues of A[n × n], column-major, which is overwritten: real and imaginary parts [n]; eigenvectors
 * of length 1 as LAPACK stores them in right[n × n] and left[n × n] (NULL: not computed): one column for a real
 * eigenvalue; for a complex pair, whose first one has the positive imaginary part, the real and then the imaginary part
 * of the first eigenvector. n > 0. KM_IO: LAPACKE is not installed; KM_DIVERGED: a number is not finite, or the
 * iteration does not converge; KM_MEMORY. O(n³). */
km_status km_eigen(int n, double *A, double *real, double *imaginary, double *left, double *right, km_error *error);

#endif
