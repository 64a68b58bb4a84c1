/* Complete pivoting of matrices of any size, and what is read from the result. */
#include "linalg/partition.h"
#include "linalg/dense/register_elimination.h"
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

static int stride_of(int rows) {
  return rows > 0 ? (rows + 1) & ~1 : 2;
}

bool km_partition_reserve(km_partition *p, int rows, int columns, km_arena *arena) {
  size_t r = (size_t)rows, c = (size_t)columns, stride = (size_t)stride_of(rows);
  *p = (km_partition){.row = KM_ARENA_NEW(arena, int, r),
                      .column = KM_ARENA_NEW(arena, int, c),
                      .reduced = KM_ARENA_NEW(arena, double, stride *c),
                      .inverse = KM_ARENA_NEW(arena, double, r < c ? r : c),
                      .B = KM_ARENA_NEW(arena, double, r *c),
                      .pivot_guess = KM_ARENA_NEW(arena, int, r < c ? r : c),
                      .work = KM_ARENA_NEW(arena, double, stride)};
  return !arena->failed;
}

bool km_partition_reserve_like(km_partition *p, const km_partition *other, int rows, int columns, km_arena *arena) {
  return other->sparse ? km_sparse_reserve(p, other->sparse, rows, columns, arena)
                       : km_partition_reserve(p, rows, columns, arena);
}

static bool is_small(const km_partition *p) {
  return p->rows > 0 && p->rows <= KM_SMALL_ROWS && p->columns <= KM_SMALL_COLUMNS;
}

static double *reduced_column(const km_partition *p, int column) {
  return p->reduced + (size_t)column * (size_t)p->stride;
}

/* Moves the forced columns behind the others, and the locked ones to the end; returns how many columns are free to be
 * chosen. */
static int order_columns(km_partition *p, const bool *forced) {
  int free = 0, behind = p->columns;
  for (int c = 0; p->locked && c < p->columns; ++c)
    if (p->locked[c])
      p->column[--behind] = c;
  p->locked_count = p->columns - behind;
  for (int c = 0; !forced && !p->locked && c < p->columns; ++c)
    p->column[free++] = c;
  for (int c = 0; (forced || p->locked) && c < p->columns; ++c) {
    if (p->locked && p->locked[c])
      continue;
    bool last = forced && forced[c];
    p->column[last ? behind - 1 : free] = c;
    behind -= last;
    free += !last;
  }
  return free;
}

typedef struct pivot {
  int row, slot;
  double size;
} pivot;

/* Largest magnitude of a column in the rows that are open: hold no pivot yet (bit mask in work). */
static double column_size(const km_partition *p, const double *x) {
  km_pair best = {0.0, 0.0};
  for (int r = 0; r < p->stride; r += 2)
    best = km_pair_larger(km_pair_and(*(const km_pair *)(x + r), *(const km_pair *)(p->work + r)), best);
  return best[0] > best[1] ? best[0] : best[1];
}

/* The first of the largest open entries of the columns in slots from … to-1. */
static pivot search(const km_partition *p, int from, int to) {
  const double as_large = p->ties_by_position ? KM_NEAR_TIE : 1.0;
  pivot best = {0, from, 0.0};
  for (int k = from; k < to; ++k) {
    double size = column_size(p, reduced_column(p, p->column[k]));
    if (size > as_large * best.size)
      best = (pivot){0, k, size};
  }
  const double *x = reduced_column(p, p->column[best.slot]);
  while (best.size > 0.0 && (p->work[best.row] == 0.0 || !(as_large * fabs(x[best.row]) >= best.size)))
    ++best.row;
  best.size = best.size > 0.0 ? fabs(x[best.row]) : 0.0;
  return best;
}

/* Subtracts the pivot row from all others. */
static void eliminate(km_partition *p, int step, int row) {
  double *l = reduced_column(p, p->column[step]), inverse = 1.0 / l[row];
  p->row[step] = row;
  p->inverse[step] = inverse;
  for (int r = 0; r < p->rows; ++r)
    l[r] *= inverse;
  l[row] = 0.0;
  for (int k = step + 1; k < p->columns; ++k) {
    double *x = reduced_column(p, p->column[k]), u = x[row];
    for (int r = 0; r < p->stride && u != 0.0; r += 2) /* loops that share few joints leave many zeros */
      *(km_pair *)(x + r) -= *(const km_pair *)(l + r) * (km_pair){u, u};
  }
}

static void load(km_partition *p, const double *matrix) {
  size_t rows = (size_t)p->rows;
  for (int c = 0; c < p->columns && rows > 0; ++c) {
    double *to = reduced_column(p, c);
    to[p->stride - 1] = 0.0;
    memcpy(to, matrix + (size_t)c * rows, rows * sizeof *to);
  }
}

/* km_register_factor for any size. */
static void factor(km_partition *p, const double *matrix, int candidates, double tolerance) {
  load(p, matrix);
  p->scale = km_max_magnitude(matrix, p->rows * p->columns);
  const int64_t magnitude = KM_MAGNITUDE;
  memset(p->work, 0, (size_t)p->stride * sizeof *p->work);
  for (int r = 0; r < p->rows; ++r)
    memcpy(p->work + r, &magnitude, sizeof magnitude);
  double threshold = tolerance * p->scale;
  int step = 0;
  for (; step < p->rows && step < p->columns; ++step) {
    pivot best = search(p, step, candidates);
    if (!(best.size > threshold) && candidates < p->columns && !p->forced_never_pivot) {
      best = search(p, candidates, p->columns);
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

static bool refactor(km_partition *p, const double *matrix) {
  load(p, matrix);
  for (int step = 0; step < p->rank; ++step)
    eliminate(p, step, p->row[step]);
  return km_all_finite(matrix, p->rows * p->columns);
}

/* The rows without pivot behind the others. */
static void order_rows(km_partition *p) {
  if (p->rank == p->rows)
    return;
  for (int r = 0; r < p->rows; ++r)
    p->work[r] = 1.0;
  for (int i = 0; i < p->rank; ++i)
    p->work[p->row[i]] = 0.0;
  for (int r = 0, i = p->rank; r < p->rows; ++r)
    if (p->work[r] != 0.0)
      p->row[i++] = r;
}

/* B, largest_b and sign from what elimination left. Returns whether B is finite. */
static bool finish(km_partition *p) {
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

static double largest_inverse(const km_partition *p) {
  double largest = 0.0;
  for (int i = 0; i < p->rank; ++i) {
    double size = fabs(p->inverse[i]);
    largest = size > largest ? size : largest;
  }
  return largest;
}

static void search_pivots(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  p->first_pivot = p->last_pivot = p->first_dropped = 0.0;
  p->smallest_pivot = (double)INFINITY;
  p->forced_dependent = p->failed = false;
  if (p->sparse) {
    km_sparse_factor(p, matrix, forced, tolerance);
    return;
  }
  int candidates = order_columns(p, forced);
  if (is_small(p))
    km_register_factor(p, matrix, candidates, tolerance);
  else
    factor(p, matrix, candidates, tolerance);
  finish(p);
}

void km_partition_factor(km_partition *p, const double *matrix, int rows, int columns, const bool *forced,
                         double tolerance) {
  bool same_size = p->rows == rows && p->columns == columns, changes = true;
  p->is_deferred = false;
  if (p->sparse && same_size && km_sparse_has_factor(p, matrix, forced, tolerance)) {
    changes = km_sparse_improve_independent(p, matrix, forced, tolerance);
  } else {
    p->rows = rows;
    p->columns = columns;
    p->stride = stride_of(rows);
    search_pivots(p, matrix, forced, tolerance);
  }
  p->max_b_at_search = p->max_b;
  if (!changes)
    return;
  order_rows(p);
  p->search_count++;
  p->version++;
}

void km_partition_defer(km_partition *p) {
  p->is_deferred = true;
  p->version++;
}

/* Were the pivots searched near a singular pose that is far away by now? Of many rows in an order that was good there the entries can grow
 * until no digits are left, which neither |B| nor the smallest pivot tells. */
static bool are_outgrown(const km_partition *p, double inverse) {
  static const double most_growth = 1e3; /* of the smallest pivot */
  return p->sparse && p->rank > 0 && most_growth * inverse * p->smallest_pivot < 1.0;
}

static bool refactor_and_watch(km_partition *p, const double *matrix, bool whole) {
  p->is_deferred = false;
  p->stride = stride_of(p->rows);
  p->version++;
  bool finite;
  if (p->sparse) {
    finite = km_sparse_refactor(p, matrix, whole);
  } else {
    finite = is_small(p) ? km_register_refactor(p, matrix) : refactor(p, matrix);
    finite = finish(p) && finite;
  }
  double inverse = largest_inverse(p), smallest = p->rank == 0 ? 0.0 : p->smallest_pivot;
  return finite && km_are_pivots_acceptable(p->max_b, p->max_b_at_search, inverse, smallest) &&
         !are_outgrown(p, inverse);
}

bool km_partition_refactor(km_partition *p, const double *matrix) {
  return refactor_and_watch(p, matrix, false);
}

bool km_partition_refactor_full_pattern(km_partition *p, const double *matrix) {
  return refactor_and_watch(p, matrix, true);
}

double km_partition_multiplications(const km_partition *p) {
  double rows = p->rows, columns = p->columns, rank = p->rank;
  if (p->sparse)
    return km_sparse_multiplications(p);
  return rank * rows * (columns - 0.5 * (rank + 1.0)) + rank * (rows + 1.0) + rank * (columns - rank);
}

/* The steps of elimination on the right side alone. */
void km_partition_solve(const km_partition *p, const double *rhs, double *x) {
  if (p->sparse) {
    km_sparse_solve(p, rhs, x);
    return;
  }
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

const double *km_partition_b(const km_partition *p, int k) {
  return p->sparse ? km_sparse_gather_b(p, k) : p->B + (size_t)k * (size_t)p->rank;
}

void km_partition_null_vector(const km_partition *p, int column, double *direction) {
  int rank = p->rank, k = rank;
  while (p->column[k] != column)
    ++k;
  const double *b = km_partition_b(p, k - rank);
  for (int c = rank; c < p->columns; ++c)
    direction[p->column[c]] = 0.0;
  for (int i = 0; i < rank; ++i)
    direction[p->column[i]] = -b[i];
  direction[column] = 1.0;
}

void km_partition_copy_pivots(km_partition *to, const km_partition *from) {
  to->rows = from->rows;
  to->columns = from->columns;
  to->rank = from->rank;
  to->stride = from->stride;
  to->sign = from->sign;
  to->search_count = from->search_count;
  to->scale = from->scale;
  to->first_pivot = from->first_pivot;
  to->last_pivot = from->last_pivot;
  to->first_dropped = from->first_dropped;
  to->smallest_pivot = from->smallest_pivot;
  to->max_b_at_search = from->max_b_at_search;
  to->forced_dependent = from->forced_dependent;
  to->locked_count = from->locked_count;
  to->version++;
  memcpy(to->row, from->row, (size_t)from->rows * sizeof *to->row);
  memcpy(to->column, from->column, (size_t)from->columns * sizeof *to->column);
  if (to->sparse)
    km_sparse_copy(to, from);
}
