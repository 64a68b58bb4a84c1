/* Singular values and vectors by LAPACKE. */
#include "linalg/dense/singular_values.h"

#include "base/dynamic_library.h"
#include "base/memory.h"

#include <lapacke.h>
#include <math.h>

/* The variant with workspace of the caller. */
typedef __typeof__(LAPACKE_dgesdd_work) solver;

/* Loads LAPACKE's dgesdd. */
static km_status load_dgesdd(solver **out, km_error *error) {
  static const char *const files[] = {KM_LAPACKE, NULL}, *const names[] = {"LAPACKE_dgesdd_work", NULL};
  static solver *function;
  static km_library library = {files, names, &function, false};
  const char *reason = km_library_load(&library);
  *out = function;
  return reason ? km_fail(error, KM_IO, "singular values can't be computed: %.300s; expected LAPACKE to be installed",
                          reason)
                : KM_OK;
}

km_status km_singular_value_decomposition(int rows, int columns, double *A, bool complete, double *s, double *U,
                                          double *Vt, km_error *error) {
  for (size_t i = 0; i < (size_t)rows * (size_t)columns; ++i)
    if (!isfinite(A[i])) /* dgesdd may not terminate */
      return km_fail(error, KM_DIVERGED, "singular values can't be computed: a number of the matrix isn't finite");
  solver *solve;
  km_status status = load_dgesdd(&solve, error);
  if (status)
    return status;
  int least = rows < columns ? rows : columns, most = rows < columns ? columns : rows;
  size_t size = 4 * (size_t)least * (size_t)least + 7 * (size_t)least + (size_t)most; /* LAPACK's minimum */
  km_arena arena = {0};
  double *work = KM_ARENA_NEW(&arena, double, size);
  lapack_int *indices = KM_ARENA_NEW(&arena, lapack_int, 8 * (size_t)least), info = 0;
  if (!arena.failed)
    info = solve(LAPACK_COL_MAJOR, complete ? 'A' : 'S', rows, columns, A, rows, s, U, rows, Vt,
                 complete ? columns : least, work, (lapack_int)size, indices);
  status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for singular values")
           : info       ? km_fail(error, KM_DIVERGED, "the iteration for singular values doesn't end")
                        : KM_OK;
  km_arena_free(&arena);
  return status;
}
