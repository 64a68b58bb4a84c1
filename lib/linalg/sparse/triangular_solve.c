/* Structure of the rows of R, and forward substitution in the widest registers available. */
#include "linalg/sparse/triangular_solve.h"

#include <string.h>

/* Compares the columns of row k after its diagonal with those of row k + 1. */
bool km_triangle_is_nested(const km_triangle *R, long k) {
  const long *start = R->start, *column = R->column;
  if (k + 1 >= R->columns)
    return false;
  long count = start[k + 1] - start[k] - 1;
  return start[k + 2] - start[k + 1] == count &&
         memcmp(column + start[k] + 1, column + start[k + 1], (size_t)count * sizeof *column) == 0;
}

bool km_triangle_covers_later(const km_triangle *R, long k) {
  const long *start = R->start, *column = R->column;
  long i = start[k] + 1, end = start[k + 1];
  if (i >= end || km_triangle_is_nested(R, k))
    return true;
  for (long n = start[column[i]]; i < end && n < start[column[start[k] + 1] + 1]; ++n)
    i += column[n] == column[i];
  return i == end;
}

void km_triangle_squares(const km_triangle *R, long first, double *y, uint64_t *marked, double sum[KM_TRIANGLE_LANES]) {
#ifdef KM_LANES_AVX2
  if (__builtin_cpu_supports("avx2")) {
    km_triangle_squares_avx2(R, first, y, marked, sum);
    return;
  }
#endif
  km_triangle_squares_plain(R, first, y, marked, sum);
}
