/* Any matrix: rank, order of columns and null space of the partition, by the dense engine and the sparse one,
 * against LAPACK's singular values. */
#include "target.h"

#include "linalg/factor_private.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

enum { MOST = 12 };

typedef struct bytes {
  const uint8_t *at;
  size_t left;
} bytes;

static int next(bytes *b) {
  if (b->left == 0)
    return 0;
  --b->left;
  return *b->at++;
}

/* Zeros, small whole numbers, fractions, multiples of the column before, sums of the two before, other scales. */
static double entry(bytes *b, const double *J, int rows, int r, int c) {
  int kind = next(b), value = next(b) - 128;
  switch (kind % 8) {
  case 0:
  case 1:
    return 0.0;
  case 2:
    return value % 4;
  case 3:
    return c > 0 ? J[(c - 1) * rows + r] * (value / 16) : value;
  case 4:
    return c > 1 ? J[(c - 1) * rows + r] + J[(c - 2) * rows + r] : value;
  case 5:
    return value * exp2(kind / 8 % 8 - 4);
  case 6:
    return r > 0 ? J[c * rows + r - 1] : value;
  default:
    return value / 37.0;
  }
}

/* Columns of one scale, as Jacobians have them, whose lengths are over the size. Beside columns of 1 others of 1e-7
 * may share a product of pivots that is rounding, and LU of one column after the other then keeps them all. */
static void scale_columns(double *J, int rows, int columns) {
  for (int c = 0; c < columns; ++c) {
    double largest = 0.0;
    int exponent = 0;
    for (int r = 0; r < rows; ++r)
      largest = fmax(largest, fabs(J[c * rows + r]));
    (void)frexp(largest, &exponent);
    for (int r = 0; r < rows; ++r)
      J[c * rows + r] = ldexp(J[c * rows + r], -exponent);
  }
}

/* Where no singular value lies between what is surely kept and surely rounding, the rank is theirs; else -1. */
static int true_rank(const double *J, int rows, int columns) {
  double copy[MOST * MOST], sigma[MOST], superb[MOST];
  int rank = 0, count = rows < columns ? rows : columns;
  memcpy(copy, J, (size_t)(rows * columns) * sizeof *copy);
  if (LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'N', 'N', rows, columns, copy, rows, sigma, NULL, 1, NULL, 1, superb))
    return -1;
  for (int i = 0; i < count && sigma[0] > 0.0; ++i) {
    if (sigma[i] < 1e-4 * sigma[0] && sigma[i] > 1e-13 * sigma[0])
      return -1;
    rank += sigma[i] >= 1e-4 * sigma[0];
  }
  return rank;
}

/* J N = 0 with N = [−B; I]. */
static void check_null(const km_factor *p, const double *J) {
  bool met[MOST] = {false};
  for (int i = 0; i < p->columns; ++i) {
    if (p->column[i] < 0 || p->column[i] >= p->columns || met[p->column[i]])
      fuzz_fail("the columns are no permutation");
    met[p->column[i]] = true;
  }
  double allowed = 1e-10 * p->scale * (1.0 + p->max_b);
  for (int i = p->rank; i < p->columns; ++i) {
    const double *b = km_factor_b(p, i - p->rank);
    for (int r = 0; r < p->rows; ++r) {
      double sum = J[p->column[i] * p->rows + r];
      for (int k = 0; k < p->rank; ++k)
        sum -= J[p->column[k] * p->rows + r] * b[k];
      if (!(fabs(sum) <= allowed * p->rows))
        fuzz_fail("a column of the null space isn't in it");
    }
  }
}

static void judge(km_factor *p, const double *stored, const double *J, int rows, int columns, const bool *forced) {
  int rank = true_rank(J, rows, columns);
  km_factor_compute(p, stored, rows, columns, &(km_factor_options){.tolerance = 1e-9, .forced = forced});
  if (p->failed || p->rank < 0 || p->rank > (rows < columns ? rows : columns))
    fuzz_fail("a rank that can't be");
  if (rank < 0)
    return;
  if (forced && p->forced_dependent) /* the last singular value may be shared with the forced column's pivot */
    return;
  if (p->rank != rank)
    fuzz_fail("the rank isn't that of the singular values");
  if (!forced && !p->sparse && !(p->max_b <= exp2(rank) * (1.0 + 1e-9)))
    fuzz_fail("complete pivoting lets |B| grow");
  check_null(p, J);
  if (!km_factor_refactor(p, stored, KM_BASIS_SHORT))
    fuzz_fail("the same values don't go by the same pivots");
  if (p->rank != rank)
    fuzz_fail("the same pivots give another rank");
  check_null(p, J);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes b = {data, size};
  int rows = 1 + next(&b) % MOST, columns = 1 + next(&b) % MOST, flags = next(&b), start[MOST + 1], row[MOST * MOST];
  double J[MOST * MOST];
  bool forced[MOST] = {false};
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      J[c * rows + r] = entry(&b, J, rows, r, c);
  scale_columns(J, rows, columns);
  for (int i = 0; i < rows * columns; ++i)
    row[i] = i % rows;
  for (int c = 0; c <= columns; ++c)
    start[c] = c * rows;
  if (flags % 4 == 1)
    forced[flags / 4 % columns] = true;
  km_arena arena = {0};
  km_factor *dense = km_factor_create(rows, columns, NULL, &arena);
  km_factor *sparse = km_factor_create_sparse(rows, columns, start, row, NULL, &arena);
  if (!dense || !sparse)
    fuzz_fail("no memory for a small matrix");
  judge(dense, J, J, rows, columns, flags % 4 == 1 ? forced : NULL);
  judge(sparse, J, J, rows, columns, flags % 4 == 1 ? forced : NULL);
  km_arena_free(&arena);
  return 0;
}
