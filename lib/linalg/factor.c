/* Factorisation by either back end, its cache and the growth monitor (docs/theory.md 3.1-3.3): Gauss-Jordan elimination
 * with complete pivoting of dense matrices, and sparse LU of large ones with few entries. */
#include "base/number/tolerances.h"
#include "linalg/dense/dense_elimination.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

km_factor *km_factor_create_like(const km_factor *other, km_arena *arena) {
  return other->sparse ? km_sparse_create(other->sparse, other->most_rows, other->most_columns, other->weight, arena)
                       : km_factor_create(other->most_rows, other->most_columns, other->weight, arena);
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

/* Elimination with a search for pivots. */
static void search_pivots(km_factor *p, const double *matrix, const bool *forced, double tolerance) {
  p->first_pivot = p->last_pivot = p->first_dropped = 0.0;
  p->smallest_pivot = (double)INFINITY;
  p->forced_dependent = p->failed = false;
  (p->sparse ? km_sparse_factor : km_dense_factor)(p, matrix, forced, tolerance);
}

/* Number of stored entries of the matrix. */
static size_t entry_count(const km_factor *p) {
  return p->sparse ? (size_t)p->sparse->start[p->columns] : (size_t)p->rows * (size_t)p->columns;
}

/* Compares stored flags of columns with flags; NULL: none is set. */
static bool are_flags_equal(bool has_flags, const bool *stored, const bool *flags, size_t count) {
  return has_flags == (flags != NULL) && (!flags || memcmp(stored, flags, count * sizeof *flags) == 0);
}

/* True if the present factor has the basis that is needed. */
static bool is_basis_sufficient(const km_factor *p, km_factor_basis basis) {
  return !p->sparse || km_sparse_is_basis_sufficient(p, basis);
}

/* True if the present factor is that of these arguments. */
static bool is_current(const km_factor *p, const double *matrix, const km_factor_options *o) {
  size_t columns = (size_t)p->columns;
  return p->is_cached && !p->failed && p->options.tolerance == o->tolerance &&
         p->options.forced_never_pivot == o->forced_never_pivot && p->options.ties_by_position == o->ties_by_position &&
         is_basis_sufficient(p, o->basis) && are_flags_equal(p->options.forced, p->cached_forced, o->forced, columns) &&
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
  p->version++;
  p->is_cached = false;
  bool finite = p->sparse ? km_sparse_refactor(p, matrix) : km_dense_refactor(p, matrix);
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

void km_factor_solve(const km_factor *p, const double *rhs, double *x) {
  (p->sparse ? km_sparse_solve : km_dense_solve)(p, rhs, x);
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
