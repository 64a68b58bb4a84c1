/* Gauss-Jordan elimination with complete pivoting (GECP) for any size; small matrices use register_elimination.h
 * (docs/theory.md 3.1).
 *
 *   step with pivot (r, c): l = J_:c / J_rc, l_r = 0;   J_:k <- J_:k − l J_rk  for all later columns k
 *   B_ik = (reduced entry) / pivot_i;   sign of det = product of the signs of the pivots */
#include "linalg/dense/dense_elimination.h"
#include "linalg/dense/register_elimination.h"
#include "linalg/dense/simd_pair.h"

#include <string.h>

static int stride_of(int rows) {
  return rows > 0 ? (rows + 1) & ~1 : 2;
}

km_factor *km_factor_create(int rows, int columns, const double *weight, km_arena *arena) {
  size_t r = (size_t)rows, c = (size_t)columns;
  km_factor *p = km_factor_allocate(rows, columns, rows * columns, weight, arena);
  if (!p)
    return NULL;
  p->reduced = KM_ARENA_NEW(arena, double, (size_t)stride_of(rows) * c);
  p->B = KM_ARENA_NEW(arena, double, r *c);
  p->pivot_guess = KM_ARENA_NEW(arena, int, r < c ? r : c);
  km_arena_grow(arena, (void **)&p->Z, &p->Z_capacity, c * c + 1, sizeof *p->Z); /* kernels do not allocate */
  return arena->failed ? NULL : p;
}

static bool is_small(const km_factor *p) {
  return p->rows > 0 && p->rows <= KM_SMALL_ROWS && p->columns <= KM_SMALL_COLUMNS;
}

static double *reduced_column(const km_factor *p, int column) {
  return p->reduced + (size_t)column * (size_t)p->stride;
}

/* Orders the columns: free ones, forced ones, locked ones. Returns the number of free columns, the candidates for
 * pivots. */
static int order_columns(km_factor *p, const bool *forced) {
  int free = 0, end = p->columns;
  for (int c = 0; p->options.locked && c < p->columns; ++c)
    if (p->options.locked[c])
      p->column[--end] = c;
  p->locked_count = p->columns - end;
  for (int c = 0; !forced && !p->options.locked && c < p->columns; ++c)
    p->column[free++] = c;
  for (int c = 0; (forced || p->options.locked) && c < p->columns; ++c) {
    if (p->options.locked && p->options.locked[c])
      continue;
    bool last = forced && forced[c];
    p->column[last ? end - 1 : free] = c;
    end -= last;
    free += !last;
  }
  return free;
}

typedef struct pivot {
  int row, slot;
  double size;
} pivot;

/* Largest magnitude of a column in rows without a pivot (bit masks in `work`). */
static double max_open_magnitude(const km_factor *p, const double *x) {
  km_pair best = {0.0, 0.0};
  for (int r = 0; r < p->stride; r += 2)
    best = km_pair_larger(km_pair_and(*(const km_pair *)(x + r), *(const km_pair *)(p->work + r)), best);
  return best[0] > best[1] ? best[0] : best[1];
}

/* Finds the pivot: the first of the largest entries in open rows of the columns in slots from … to-1. */
static pivot search_pivot(const km_factor *p, int from, int to) {
  const double tie_factor = p->options.ties_by_position ? KM_NEAR_TIE : 1.0;
  pivot best = {0, from, 0.0};
  for (int k = from; k < to; ++k) {
    double size = max_open_magnitude(p, reduced_column(p, p->column[k]));
    if (size > tie_factor * best.size)
      best = (pivot){0, k, size};
  }
  const double *x = reduced_column(p, p->column[best.slot]);
  while (best.size > 0.0 && (p->work[best.row] == 0.0 || !(tie_factor * fabs(x[best.row]) >= best.size)))
    ++best.row;
  best.size = best.size > 0.0 ? fabs(x[best.row]) : 0.0;
  return best;
}

/* Gauss-Jordan step: subtracts multiples of the pivot row from all other rows; the multiples replace the pivot
 * column. */
static void eliminate(km_factor *p, int step, int row) {
  double *l = reduced_column(p, p->column[step]), inverse = 1.0 / l[row];
  p->row[step] = row;
  p->inverse[step] = inverse;
  for (int r = 0; r < p->rows; ++r)
    l[r] *= inverse;
  l[row] = 0.0;
  for (int k = step + 1; k < p->columns; ++k) {
    double *x = reduced_column(p, p->column[k]), u = x[row];
    for (int r = 0; r < p->stride && u != 0.0; r += 2) /* Jacobians of loops that share few joints have many zeros */
      *(km_pair *)(x + r) -= *(const km_pair *)(l + r) * (km_pair){u, u};
  }
}

/* Copies the matrix to `reduced`, with an even leading dimension. */
static void copy_matrix(km_factor *p, const double *matrix) {
  size_t rows = (size_t)p->rows;
  for (int c = 0; c < p->columns && rows > 0; ++c) {
    double *to = reduced_column(p, c);
    to[p->stride - 1] = 0.0;
    memcpy(to, matrix + (size_t)c * rows, rows * sizeof *to);
  }
}

/* Elimination with complete pivoting. The first `candidates` columns are tried before the forced ones. */
static void factor_dense(km_factor *p, const double *matrix, int candidates, double tolerance) {
  copy_matrix(p, matrix);
  p->scale = km_max_magnitude(matrix, p->rows * p->columns);
  const int64_t magnitude = KM_MAGNITUDE;
  memset(p->work, 0, (size_t)p->stride * sizeof *p->work);
  for (int r = 0; r < p->rows; ++r)
    memcpy(p->work + r, &magnitude, sizeof magnitude);
  double threshold = tolerance * p->scale;
  int step = 0;
  for (; step < p->rows && step < p->columns; ++step) {
    pivot best = search_pivot(p, step, candidates);
    if (!(best.size > threshold) && candidates < p->columns && !p->options.forced_never_pivot) {
      best = search_pivot(p, candidates, p->columns);
      candidates = p->columns;
      p->forced_dependent = best.size > threshold;
    }
    if (!(best.size > threshold)) {
      p->first_dropped = best.size;
      break;
    }
    int column = p->column[best.slot];
    p->column[best.slot] = p->column[step];
    p->column[step] = column;
    eliminate(p, step, best.row);
    p->work[best.row] = 0.0;
    p->first_pivot = step == 0 ? best.size : p->first_pivot;
    p->last_pivot = best.size;
    p->smallest_pivot = best.size < p->smallest_pivot ? best.size : p->smallest_pivot;
  }
  p->rank = step;
}

/* Elimination with the known pivots. */
static bool refactor_dense(km_factor *p, const double *matrix) {
  copy_matrix(p, matrix);
  for (int step = 0; step < p->rank; ++step)
    eliminate(p, step, p->row[step]);
  return km_all_finite(matrix, p->rows * p->columns);
}

/* Computes B, max_b and sign from the reduced matrix. Returns true if B is finite. */
static bool compute_b(km_factor *p) {
  const int rank = p->rank, columns = p->columns, *const row = p->row;
  const double *const inverse = p->inverse;
  double largest = 0.0, sum = 0.0, *b = p->B;
  int negative = 0;
  for (int i = 0; i < rank; ++i)
    negative ^= inverse[i] < 0.0;
  for (int k = rank; k < columns; ++k) {
    const double *x = reduced_column(p, p->column[k]);
    for (int i = 0; i < rank; ++i, ++b) {
      double value = x[row[i]] * inverse[i], size = fabs(value);
      *b = value;
      largest = size > largest ? size : largest;
      sum += value;
    }
  }
  p->max_b = largest;
  p->sign = negative ? -1 : 1;
  return isfinite(sum);
}

void km_dense_factor(km_factor *p, const double *matrix, const bool *forced, double tolerance) {
  p->stride = stride_of(p->rows);
  int candidates = order_columns(p, forced);
  if (is_small(p))
    km_register_factor(p, matrix, candidates, tolerance);
  else
    factor_dense(p, matrix, candidates, tolerance);
  compute_b(p);
}

bool km_dense_refactor(km_factor *p, const double *matrix) {
  p->stride = stride_of(p->rows);
  bool finite = is_small(p) ? km_register_refactor(p, matrix) : refactor_dense(p, matrix);
  return compute_b(p) && finite;
}

/* Applies the elimination steps to the right side. */
void km_dense_solve(const km_factor *p, const double *rhs, double *x) {
  const int rank = p->rank, rows = p->rows, *const row = p->row;
  double *const y = p->work;
  y[p->stride - 1] = 0.0;
  memcpy(y, rhs, (size_t)rows * sizeof *y);
  for (int step = 0; step < rank; ++step) {
    const double *l = reduced_column(p, p->column[step]), u = y[row[step]];
    for (int r = 0; r < p->stride; r += 2)
      *(km_pair *)(y + r) -= *(const km_pair *)(l + r) * (km_pair){u, u};
  }
  for (int i = 0; i < rank; ++i)
    x[p->column[i]] = y[row[i]] * p->inverse[i];
  for (int c = rank; c < p->columns; ++c)
    x[p->column[c]] = 0.0;
}
