/* Solutions by the rows of a triangle, several vectors and several rows at a time; included once for each instruction set: NAME is the
 * function, WIDTH the number of doubles of a register. Nothing is contracted or summed across lanes: the bits are the same. */
#include "linalg/sparse/triangular_solve.h"

enum { LANES = KM_TRIANGLE_LANES, VECTORS = LANES / WIDTH, TOGETHER = 4 };

typedef double vector __attribute__((vector_size(WIDTH * sizeof(double)), aligned(sizeof(double)), may_alias));

/* Row k takes its own entry of every vector, which is left 0, and subtracts it by its first `count` entries. */
static void take_row(const km_triangle *R, long k, long count, double *y, double sum[LANES], vector own[VECTORS]) {
  const long first = R->start[k];
  double *at = y + LANES * k;
  for (int l = 0; l < LANES; ++l) {
    double value = at[l] / R->value[first];
    own[l / WIDTH][l % WIDTH] = value;
    sum[l] += value * value;
    at[l] = 0.0;
  }
  for (long i = first + 1; i < first + count; ++i) {
    vector *to = (vector *)(y + LANES * R->column[i]);
    for (int v = 0; v < VECTORS; ++v)
      to[v] -= R->value[i] * own[v];
  }
}

/* Subtracts `count` entries of the rows, which stand in the same columns, from all vectors. */
static void subtract_rows(const long *column, const double *const value[TOGETHER], long count,
                          vector own[TOGETHER][VECTORS], double *y) {
  const double *const a = value[0], *const b = value[1], *const c = value[2], *const d = value[3];
  for (long i = 0; i < count; ++i) {
    vector *to = (vector *)(y + LANES * column[i]);
    for (int v = 0; v < VECTORS; ++v)
      to[v] = to[v] - a[i] * own[0][v] - b[i] * own[1][v] - c[i] * own[2][v] - d[i] * own[3][v];
  }
}

/* The same of several rows that continue each other, whose common columns are loaded and stored once. */
static void take_rows(const km_triangle *R, long k, double *y, double sum[LANES]) {
  vector own[TOGETHER][VECTORS];
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
    all = R->is_nested[k + r];
  return all;
}

/* `count` rows from row k on are done: what they have changed are the columns of the last one. */
static void pass_marks(const km_triangle *R, long k, long count, uint64_t *marked) {
  const long last = k + count - 1, next = R->start[last] + 1;
  const long end = R->covers_later[last] && next < R->start[k + count] ? next + 1 : R->start[k + count];
  for (long r = k; r <= last; ++r)
    marked[r / KM_TRIANGLE_WORD] &= ~((uint64_t)1 << r % KM_TRIANGLE_WORD);
  for (long i = next; i < end; ++i)
    km_triangle_mark(marked, R->column[i]);
}

void NAME(const km_triangle *R, long first, double *y, uint64_t *marked, double sum[LANES]) {
  vector own[VECTORS];
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
