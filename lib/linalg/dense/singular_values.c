/* Singular values and vectors: small matrices by Jacobi's method, others by LAPACKE. */
#include "linalg/dense/singular_values.h"

#include "base/memory.h"
#include "linalg/dense/jacobi_svd.h"
#include "linalg/dense/lapacke_functions.h"

#include <math.h>

km_status km_singular_value_decomposition(int rows, int columns, double *A, bool complete, double *s, double *U,
                                          double *Vt, km_error *error) {
  for (size_t i = 0; i < (size_t)rows * (size_t)columns; ++i)
    if (!isfinite(A[i])) /* dgesdd may not terminate */
      return km_fail(error, KM_DIVERGED, "singular values can't be computed: a number of the matrix isn't finite");
  if (rows <= KM_SMALL_SVD && columns <= KM_SMALL_SVD)
    return km_jacobi_svd(rows, columns, A, complete, s, U, Vt, error);
  km_lapacke_functions lapacke;
  km_status status = km_lapacke_load("singular values", &lapacke, error);
  if (status)
    return status;
  int least = rows < columns ? rows : columns, most = rows < columns ? columns : rows;
  size_t size = 4 * (size_t)least * (size_t)least + 7 * (size_t)least + (size_t)most; /* LAPACK's minimum */
  km_arena arena = {0};
  double *work = KM_ARENA_NEW(&arena, double, size);
  lapack_int *indices = KM_ARENA_NEW(&arena, lapack_int, 8 * (size_t)least), info = 0;
  if (!arena.failed)
    info = lapacke.dgesdd(LAPACK_COL_MAJOR, complete ? 'A' : 'S', rows, columns, A, rows, s, U, rows, Vt,
                          complete ? columns : least, work, (lapack_int)size, indices);
  status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for singular values")
           : info       ? km_fail(error, KM_DIVERGED, "the iteration for singular values doesn't end")
                        : KM_OK;
  km_arena_free(&arena);
  return status;
}
