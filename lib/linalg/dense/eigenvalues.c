/* Eigenvalues by LAPACKE. */
#include "linalg/dense/eigenvalues.h"

#include "base/dynamic_library.h"
#include "base/memory.h"

#include <lapacke.h>
#include <math.h>

/* The variant with workspace of the caller. */
typedef __typeof__(LAPACKE_dgeev_work) solver;

/* Loads LAPACKE's dgeev. */
static km_status load_dgeev(solver **out, km_error *error) {
  static const char *const files[] = {KM_LAPACKE, NULL}, *const names[] = {"LAPACKE_dgeev_work", NULL};
  static solver *function;
  static km_library library = {files, names, &function, false};
  const char *reason = km_library_load(&library);
  *out = function;
  return reason
             ? km_fail(error, KM_IO, "eigenvalues can't be computed: %.300s; expected LAPACKE to be installed", reason)
             : KM_OK;
}

/* Eigenvalues and eigenvectors by dgeev. */
km_status km_eigen(int n, double *A, double *real, double *imaginary, double *left, double *right, km_error *error) {
  for (size_t i = 0; i < (size_t)n * (size_t)n; ++i)
    if (!isfinite(A[i])) /* dgeev may not terminate */
      return km_fail(error, KM_DIVERGED, "eigenvalues can't be computed: a number of the matrix isn't finite");
  solver *solve;
  km_status status = load_dgeev(&solve, error);
  if (status)
    return status;
  const size_t size = 4 * (size_t)n; /* LAPACK's minimum with eigenvectors */
  double *work = KM_NEW(double, size);
  if (!work)
    return km_fail(error, KM_MEMORY, "out of memory for eigenvalues");
  lapack_int info = solve(LAPACK_COL_MAJOR, left ? 'V' : 'N', 'V', n, A, n, real, imaginary, left, n, right, n, work,
                          (lapack_int)size);
  km_free(work);
  return info == 0 ? KM_OK : km_fail(error, KM_DIVERGED, "the iteration for eigenvalues doesn't end");
}
