/* Solutions by the rows of a triangle, several vectors and several rows at a time. */
#include "partition/triangle.h"

#include "partition/pair.h"

#include <string.h>

enum { LANES = KM_TRIANGLE_LANES, TOGETHER = 4 };

bool km_triangle_continues(const km_triangle *R, long k) {
  const long *start = R->start, *column = R->column;
  if (k + 1 >= R->columns)
    return false;
  long count = start[k + 1] - start[k] - 1;
  return start[k + 2] - start[k + 1] == count &&
         memcmp(column + start[k] + 1, column + start[k + 1], (size_t)count * sizeof *column) == 0;
}

bool km_triangle_leads(const km_triangle *R, long k) {
  const long *start = R->start, *column = R->column;
  long i = start[k] + 1, end = start[k + 1];
  if (i >= end || km_triangle_continues(R, k))
    return true;
  for (long n = start[column[i]]; i < end && n < start[column[start[k] + 1] + 1]; ++n)
    i += column[n] == column[i];
  return i == end;
}

/* Row k takes its own entry of every vector, which is left 0, and subtracts it by its first `count` entries. */
static void take_row(const km_triangle *R, long k, long count, double *y, double sum[LANES], km_pair own[LANES / 2]) {
  const long first = R->start[k];
  double *at = y + LANES * k;
  for (int l = 0; l < LANES; ++l) {
    double value = at[l] / R->value[first];
    own[l / 2][l % 2] = value;
    sum[l] += value * value;
    at[l] = 0.0;
  }
  for (long i = first + 1; i < first + count; ++i) {
    km_pair *to = (km_pair *)(y + LANES * R->column[i]), v = {R->value[i], R->value[i]};
    for (int l = 0; l < LANES / 2; ++l)
      to[l] -= v * own[l];
  }
}

/* Subtracts `count` entries of the rows, which stand in the same columns, from all vectors. */
static void subtract_rows(const long *column, const double *const value[TOGETHER], long count,
                          km_pair own[TOGETHER][LANES / 2], double *y) {
  const double *const a = value[0], *const b = value[1], *const c = value[2], *const d = value[3];
  const km_pair a0 = own[0][0], a1 = own[0][1], b0 = own[1][0], b1 = own[1][1];
  const km_pair c0 = own[2][0], c1 = own[2][1], d0 = own[3][0], d1 = own[3][1];
  for (long i = 0; i < count; ++i) {
    km_pair *to = (km_pair *)(y + LANES * column[i]);
    km_pair ai = {a[i], a[i]}, bi = {b[i], b[i]}, ci = {c[i], c[i]}, di = {d[i], d[i]};
    to[0] = to[0] - ai * a0 - bi * b0 - ci * c0 - di * d0;
    to[1] = to[1] - ai * a1 - bi * b1 - ci * c1 - di * d1;
  }
}

/* The same of several rows that continue each other, whose common columns are loaded and stored once. */
static void take_rows(const km_triangle *R, long k, double *y, double sum[LANES]) {
  km_pair own[TOGETHER][LANES / 2];
  const double *value[TOGETHER];
  for (int r = 0; r < TOGETHER; ++r) {
    take_row(R, k + r, TOGETHER - r, y, sum, own[r]);
    value[r] = R->value + R->start[k + r] + TOGETHER - r;
  }
  long first = R->start[k] + TOGETHER;
  subtract_rows(R->column + first, value, R->start[k + 1] - first, own, y);
}

static bool go_together(const km_triangle *R, long k) {
  bool all = k + TOGETHER <= R->columns;
  for (int r = 0; r + 1 < TOGETHER && all; ++r)
    all = R->continues[k + r];
  return all;
}

/* `count` rows from row k on are done: what they have changed are the columns of the last one. */
static void pass_marks(const km_triangle *R, long k, long count, uint64_t *marked) {
  const long last = k + count - 1, next = R->start[last] + 1;
  const long end = R->leads[last] && next < R->start[k + count] ? next + 1 : R->start[k + count];
  for (long r = k; r <= last; ++r)
    marked[r / KM_TRIANGLE_WORD] &= ~((uint64_t)1 << r % KM_TRIANGLE_WORD);
  for (long i = next; i < end; ++i)
    km_triangle_mark(marked, R->column[i]);
}

void km_triangle_squares(const km_triangle *R, long first, double *y, uint64_t *marked, double sum[LANES]) {
  km_pair own[LANES / 2];
  for (long word = first / KM_TRIANGLE_WORD; word * KM_TRIANGLE_WORD < R->columns; ++word)
    while (marked[word] != 0) {
      long k = word * KM_TRIANGLE_WORD + __builtin_ctzll(marked[word]);
      bool together = go_together(R, k);
      if (together)
        take_rows(R, k, y, sum);
      else
        take_row(R, k, R->start[k + 1] - R->start[k], y, sum, own);
      pass_marks(R, k, together ? TOGETHER : 1, marked);
    }
}
