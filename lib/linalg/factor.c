/* Gauss-Jordan elimination with complete pivoting (GECP) for any size, and what follows from the factors
 * (docs/theory.md 3.1-3.3). Small matrices use linalg/dense/register_elimination.h, large sparse ones
 * linalg/sparse/sparse_lu.h.
 *
 *   step with pivot (r, c): l = J_:c / J_rc, l_r = 0;   J_:k <- J_:k − l J_rk  for all later columns k
 *   B_ik = (reduced entry) / pivot_i;   sign of det = product of the signs of the pivots */
#include "base/number/tolerances.h"
#include "linalg/dense/register_elimination.h"
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
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

km_factor *km_factor_create_like(const km_factor *other, km_arena *arena) {
  return other->sparse ? km_sparse_create(other->sparse, other->most_rows, other->most_columns, other->weight, arena)
                       : km_factor_create(other->most_rows, other->most_columns, other->weight, arena);
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

/* Appends the rows without a pivot (secondary rows) to `row`. */
static void order_rows(km_factor *p) {
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

/* Elimination with a search for pivots, by the implementation for the matrix's size. */
static void search_pivots(km_factor *p, const double *matrix, const bool *forced, double tolerance) {
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
    factor_dense(p, matrix, candidates, tolerance);
  compute_b(p);
}

/* Number of stored entries of the matrix. */
static size_t entry_count(const km_factor *p) {
  return p->sparse ? (size_t)p->sparse->start[p->columns] : (size_t)p->rows * (size_t)p->columns;
}

/* Compares stored flags of columns with flags; NULL: none is set. */
static bool are_flags_equal(bool has_flags, const bool *stored, const bool *flags, size_t count) {
  return has_flags == (flags != NULL) && (!flags || memcmp(stored, flags, count * sizeof *flags) == 0);
}

/* True if the present factor is that of these arguments. */
static bool is_current(const km_factor *p, const double *matrix, const km_factor_options *o) {
  size_t columns = (size_t)p->columns;
  return p->is_cached && !p->failed && p->options.tolerance == o->tolerance &&
         p->options.forced_never_pivot == o->forced_never_pivot && p->options.ties_by_position == o->ties_by_position &&
         (!p->sparse || p->options.basis == o->basis) &&
         are_flags_equal(p->options.forced, p->cached_forced, o->forced, columns) &&
         are_flags_equal(p->options.locked, p->cached_locked, o->locked, columns) &&
         memcmp(p->cached_matrix, matrix, entry_count(p) * sizeof *matrix) == 0;
}

/* Stores matrix and arguments of the present factor. */
static void cache_matrix(km_factor *p, const double *matrix, const km_factor_options *o) {
  memcpy(p->cached_matrix, matrix, entry_count(p) * sizeof *matrix);
  if (o->forced)
    memcpy(p->cached_forced, o->forced, (size_t)p->columns * sizeof *o->forced);
  if (o->locked)
    memcpy(p->cached_locked, o->locked, (size_t)p->columns * sizeof *o->locked);
  p->is_cached = !p->failed;
}

void km_factor_compute(km_factor *p, const double *matrix, int rows, int columns, const km_factor_options *o) {
  const bool is_known = p->rows == rows && p->columns == columns && is_current(p, matrix, o);
  p->options = *o;
  if (!is_known) {
    p->rows = rows;
    p->columns = columns;
    p->stride = stride_of(rows);
    search_pivots(p, matrix, o->forced, o->tolerance);
    order_rows(p);
    cache_matrix(p, matrix, o);
    p->search_count++;
    p->version++;
  }
  p->max_b_at_search = o->growth_reference > 0.0 ? o->growth_reference : p->max_b;
}

/* True if the smallest pivot has grown a hundredfold since the search. Pivots chosen near a singular configuration can
 * let entries grow elsewhere until no digits are left, which neither |B| nor the smallest pivot shows. */
static bool have_pivots_outgrown(const km_factor *p, double inverse) {
  return p->sparse && p->rank > 0 && km_significant_ratio * inverse * p->smallest_pivot < 1.0;
}

/* Refactors with the known pivots and applies the growth monitor. */
bool km_factor_refactor(km_factor *p, const double *matrix, km_factor_basis basis) {
  p->options.basis = basis;
  p->stride = stride_of(p->rows);
  p->version++;
  p->is_cached = false;
  bool finite;
  if (p->sparse) {
    finite = km_sparse_refactor(p, matrix);
  } else {
    finite = is_small(p) ? km_register_refactor(p, matrix) : refactor_dense(p, matrix);
    finite = compute_b(p) && finite;
  }
  double inverse = km_factor_largest_inverse(p), smallest = p->rank == 0 ? 0.0 : p->smallest_pivot;
  return finite && km_are_pivots_acceptable(p->max_b, p->max_b_at_search, inverse, smallest) &&
         !have_pivots_outgrown(p, inverse);
}

/* Operation count of a refactorisation, B and one solution. */
double km_factor_multiplications(const km_factor *p) {
  double rows = p->rows, columns = p->columns, rank = p->rank;
  if (p->sparse)
    return km_sparse_multiplications(p);
  return rank * rows * (columns - 0.5 * (rank + 1.0)) + rank * (rows + 1.0) + rank * (columns - rank);
}

/* Applies the elimination steps to the right side. */
void km_factor_solve(const km_factor *p, const double *rhs, double *x) {
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

const double *km_factor_b(const km_factor *p, int k) {
  return p->sparse ? km_sparse_gather_b(p, k) : p->B + (size_t)k * (size_t)p->rank;
}

/* Null vector of one independent column: −B in the dependent columns. */
void km_factor_null_vector(const km_factor *p, int column, double *direction) {
  int rank = p->rank, k = rank;
  while (p->column[k] != column)
    ++k;
  const double *b = km_factor_b(p, k - rank);
  for (int c = rank; c < p->columns; ++c)
    direction[p->column[c]] = 0.0;
  for (int i = 0; i < rank; ++i)
    direction[p->column[i]] = -b[i];
  direction[column] = 1.0;
}

void km_factor_copy_pivots(km_factor *to, const km_factor *from) {
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
  to->options = from->options;
  to->is_cached = false;
  to->version++;
  memcpy(to->row, from->row, (size_t)from->rows * sizeof *to->row);
  memcpy(to->column, from->column, (size_t)from->columns * sizeof *to->column);
  if (to->sparse)
    km_sparse_copy(to, from);
}

bool km_factor_has_null_vectors(const km_factor *p) {
  return !p->sparse || km_sparse_has_null_vectors(p);
}
