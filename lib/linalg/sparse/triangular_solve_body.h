/* Forward substitution with R by rows, for several right sides and rows at a time. Included once for each instruction
 * set: NAME is the function, WIDTH the doubles per register. Nothing is contracted or summed across lanes, so the bits
 * are equal. */
#include "linalg/sparse/triangular_solve.h"

enum { LANES = KM_TRIANGLE_LANES, VECTORS = LANES / WIDTH, NESTED_ROWS = 4 };

typedef double vector __attribute__((vector_size(WIDTH * sizeof(double)), aligned(sizeof(double)), may_alias));

/* Substitution of row k: u = y_k / R_kk of every right side, y_k <- 0, y_j <- y_j − R_kj u for its first `count`
 * entries. */
static void substitute_row(const km_triangle *R, long k, long count, double *y, double sum[LANES], vector u[VECTORS]) {
  const long first = R->start[k];
  double *at = y + LANES * k;
  for (int l = 0; l < LANES; ++l) {
    double value = at[l] / R->value[first];
    u[l / WIDTH][l % WIDTH] = value;
    sum[l] += value * value;
    at[l] = 0.0;
  }
  for (long i = first + 1; i < first + count; ++i) {
    vector *to = (vector *)(y + LANES * R->column[i]);
    for (int v = 0; v < VECTORS; ++v)
      to[v] -= R->value[i] * u[v];
  }
}

/* Subtracts `count` entries of the nested rows, which have equal columns, from all right sides. */
static void subtract_rows(const long *column, const double *const value[NESTED_ROWS], long count,
                          vector u[NESTED_ROWS][VECTORS], double *y) {
  const double *const a = value[0], *const b = value[1], *const c = value[2], *const d = value[3];
  for (long i = 0; i < count; ++i) {
    vector *to = (vector *)(y + LANES * column[i]);
    for (int v = 0; v < VECTORS; ++v)
      to[v] = to[v] - a[i] * u[0][v] - b[i] * u[1][v] - c[i] * u[2][v] - d[i] * u[3][v];
  }
}

/* Substitution of nested rows, whose common columns are loaded and stored once. */
static void substitute_nested_rows(const km_triangle *R, long k, double *y, double sum[LANES]) {
  vector u[NESTED_ROWS][VECTORS];
  const double *value[NESTED_ROWS];
  for (int r = 0; r < NESTED_ROWS; ++r) {
    substitute_row(R, k + r, NESTED_ROWS - r, y, sum, u[r]);
    value[r] = R->value + R->start[k + r] + NESTED_ROWS - r;
  }
  long first = R->start[k] + NESTED_ROWS;
  subtract_rows(R->column + first, value, R->start[k + 1] - first, u, y);
}

/* True if NESTED_ROWS rows from row k on are nested. */
static bool are_nested(const km_triangle *R, long k) {
  bool all = k + NESTED_ROWS <= R->columns;
  for (int r = 0; r + 1 < NESTED_ROWS && all; ++r)
    all = R->is_nested[k + r];
  return all;
}

/* Clears the marks of `count` processed rows from row k on and marks the columns that they changed. */
static void update_marks(const km_triangle *R, long k, long count, uint64_t *marked) {
  const long last = k + count - 1, next = R->start[last] + 1;
  const long end = R->covers_later[last] && next < R->start[k + count] ? next + 1 : R->start[k + count];
  for (long r = k; r <= last; ++r)
    marked[r / KM_TRIANGLE_WORD] &= ~((uint64_t)1 << r % KM_TRIANGLE_WORD);
  for (long i = next; i < end; ++i)
    km_triangle_mark(marked, R->column[i]);
}

void NAME(const km_triangle *R, long first, double *y, uint64_t *marked, double sum[LANES]) {
  vector u[VECTORS];
  for (long word = first / KM_TRIANGLE_WORD; word * KM_TRIANGLE_WORD < R->columns; ++word)
    while (marked[word] != 0) {
      long k = word * KM_TRIANGLE_WORD + __builtin_ctzll(marked[word]);
      bool together = are_nested(R, k);
      if (together)
        substitute_nested_rows(R, k, y, sum);
      else
        substitute_row(R, k, R->start[k + 1] - R->start[k], y, sum, u);
      update_marks(R, k, together ? NESTED_ROWS : 1, marked);
    }
}
