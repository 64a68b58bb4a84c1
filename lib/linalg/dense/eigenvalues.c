/* Eigenvalues by LAPACKE. */
#include "linalg/dense/eigenvalues.h"

#include "base/memory.h"
#include "linalg/dense/lapacke_functions.h"

#include <math.h>

/* Eigenvalues and eigenvectors by dgeev. */
km_status km_eigen(int n, double *A, double *real, double *imaginary, double *left, double *right, km_error *error) {
  for (size_t i = 0; i < (size_t)n * (size_t)n; ++i)
    if (!isfinite(A[i])) /* dgeev may not terminate */
      return km_fail(error, KM_DIVERGED, "eigenvalues can't be computed: a number of the matrix isn't finite");
  km_lapacke_functions lapacke;
  km_status status = km_lapacke_load("eigenvalues", &lapacke, error);
  if (status)
    return status;
  const size_t size = 4 * (size_t)n; /* LAPACK's minimum with eigenvectors */
  double *work = KM_NEW(double, size);
  if (!work)
    return km_fail(error, KM_MEMORY, "out of memory for eigenvalues");
  lapack_int info = lapacke.dgeev(LAPACK_COL_MAJOR, left ? 'V' : 'N', 'V', n, A, n, real, imaginary, left, n, right, n,
                                  work, (lapack_int)size);
  km_free(work);
  return info == 0 ? KM_OK : km_fail(error, KM_DIVERGED, "the iteration for eigenvalues doesn't end");
}
