/* Path-control and pose-control columns of a Jacobian that is given as a matrix (docs/theory.md 12.3).
 *
 *   M Z = 0,  z = last row of Z;   Z' = [Z z^T/|z|, orthonormal complement with last entries 0] */
#include "arm/path_control.h"
#include "base/arguments.h"
#include "base/number/vectors.h"
#include "kmech/arm.h"

#include <string.h>

static void scale(double *a, double by, int n) {
  for (int i = 0; i < n; ++i)
    a[i] *= by;
}

/* Rotates an orthonormal basis so that the last row is 0 in all columns but the first, which is Z zᵀ/|z|. The others
 * are the basis columns, Gram-Schmidt orthonormalised against it; the one with the largest last entry is dropped.
 * Basis and result must not overlap. */
static void align_with_path(const double *basis, int n, int freedom, double *Z) {
  double *path = Z;
  memset(path, 0, (size_t)n * sizeof *path);
  int most = 0;
  for (int k = 0; k < freedom; ++k) {
    double z = basis[k * n + n - 1];
    for (int i = 0; i < n; ++i)
      path[i] += z * basis[k * n + i];
    if (fabs(z) > fabs(basis[most * n + n - 1]))
      most = k;
  }
  scale(path, 1.0 / sqrt(km_dot(path, path, n)), n);
  for (int k = 0, out = 1; k < freedom; ++k) {
    if (k == most)
      continue;
    double *c = Z + out++ * n;
    memcpy(c, basis + k * n, (size_t)n * sizeof *c);
    for (int pass = 0; pass < 2; ++pass)
      for (double *o = Z; o < c; o += n) {
        double d = km_dot(o, c, n);
        for (int i = 0; i < n; ++i)
          c[i] -= d * o[i];
      }
    scale(c, 1.0 / sqrt(km_dot(c, c, n)), n);
    c[n - 1] = 0.0;
  }
}

/* Factors the matrix, finds its null space and rotates it to path-control and pose-control columns. */
static km_status solve(const double *matrix, int rows, int columns, km_arena *arena, double *Z, km_control *out,
                       km_error *error) {
  size_t n = (size_t)columns;
  km_factor *p = km_factor_create(rows, columns, NULL, arena);
  if (!p)
    return km_fail(error, KM_MEMORY, "out of memory for a matrix of %d x %d", rows, columns);
  out->tolerance = KM_ARM_PIVOT * (rows > columns ? rows : columns);
  km_factor_compute(p, matrix, rows, columns, &(km_factor_options){.tolerance = out->tolerance});
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  out->rank = km_factor_rank(p);
  out->freedom = columns - out->rank;
  out->last_pivot = evidence.last_pivot;
  out->first_dropped = evidence.first_dropped;
  if (out->freedom == 0)
    return km_fail(error, KM_NO_RESULT,
                   "the matrix has rank %d with %d columns: no null space; expected one of at least 1", out->rank,
                   columns);
  const double *basis = km_factor_null_space(p, out->freedom);
  for (int k = 0; k < out->freedom; ++k)
    out->path_entry = hypot(out->path_entry, basis[(size_t)(k + 1) * n - 1]);
  if (out->path_entry < KM_PATH_ENTRY_LEAST)
    return km_fail(
        error, KM_NO_RESULT,
        "the null space has no part along the path (|z| = %.3g): the joints can't move the effector along it",
        out->path_entry);
  align_with_path(basis, columns, out->freedom, Z);
  return KM_OK;
}

km_status km_control_of_matrix(const double *matrix, int rows, int columns, double *Z, km_control *out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_control){0};
  km_status fits = km_check_given(matrix && Z, "matrix", error);
  if (fits)
    return fits;
  if (rows < 1 || columns < 2)
    return km_fail(error, KM_USAGE, "a matrix of %d x %d; expected at least 1 x 2", rows, columns);
  for (size_t i = 0; i < (size_t)rows * (size_t)columns; ++i)
    if (!isfinite(matrix[i]))
      return km_fail(error, KM_USAGE, "row %zu, column %zu is not finite", i % (size_t)rows + 1, i / (size_t)rows + 1);
  km_arena arena = {0};
  km_status status = solve(matrix, rows, columns, &arena, Z, out, error);
  km_arena_free(&arena);
  return status;
}
