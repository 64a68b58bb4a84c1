/* Search for pivots of the sparse factor (docs/theory.md 3.6): elimination, hidden dependence, choice of independent
 * columns.
 *
 *   1. eliminate with a threshold on remainders;   2. postpone a hidden dependent column (or exclude a row), repeat 1
 *   3. if max|B| > 2 (30 with many freedoms): postpone shared columns, or choose independent columns, repeat from 1 */
#include "linalg/sparse/sparse_lu.h"
#include "linalg/dense/simd_pair.h"

#include <limits.h>
#include <math.h>
#include <string.h>

enum { MAX_PASSES = 4 };
/* Postpones columns with more entries than the average. They are shared by several loops: if they are independent, null
 * vectors reach no further than a loop and its neighbours. Returns true if the independent columns change. */
static bool postpone_shared_columns(km_factor *p) {
  km_sparse *s = p->sparse;
  bool changed = false;
  for (int c = 0; c < p->columns; ++c)
    s->is_postponed[c] = (s->start[c + 1] - s->start[c]) * p->columns > s->start[p->columns];
  for (int k = 0; k < p->rank; ++k)
    changed = changed || s->is_postponed[p->column[k]];
  return changed;
}

/* max|B_ij| over the independent columns that are neither forced nor locked. */
static double max_free_b(const km_factor *p, const bool *forced) {
  return forced || p->options.locked ? km_sparse_estimate_max_b(p, forced) : p->max_b;
}

/* Hidden dependent column; -1: none, or only the rank is needed and the primary rows are independent. */
static int find_hidden_column(const km_factor *p, const double *matrix, const bool *forced, double threshold,
                              bool is_rank_sufficient) {
  if (p->failed || p->sparse->is_overfull)
    return -1;
  return is_rank_sufficient && km_sparse_hidden_row(p, matrix, forced, threshold) < 0
             ? -1
             : km_sparse_hidden_column(p, forced, threshold);
}

/* Eliminates until no hidden dependence remains, or none that affects the rank if that is sufficient. If a column that
 * is already postponed remains as a pivot, it grew by small pivots: then a primary row depends on the others and is
 * excluded, unless a forced column makes it independent. */
static void eliminate_until_consistent(km_factor *p, const double *matrix, const bool *forced, double threshold,
                                       bool is_rank_sufficient) {
  km_sparse *s = p->sparse;
  int hidden = -1, row = -1;
  do {
    if (row >= 0)
      s->is_excluded_row[row] = true;
    else if (hidden >= 0)
      s->is_postponed[hidden] = s->postpones_small = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = find_hidden_column(p, matrix, forced, threshold, is_rank_sufficient);
    bool last = hidden >= 0 && s->is_postponed[hidden];
    row = last ? km_sparse_hidden_row(p, matrix, p->options.forced_never_pivot ? forced : NULL, threshold) : -1;
    if (last && row < 0)
      hidden = -1;
  } while (hidden >= 0);
}

/* Eliminates until no primary row depends on the others; dependent rows are excluded one by one. */
static void eliminate_by_rows(km_factor *p, const double *matrix, const bool *forced, double threshold) {
  int hidden = -1;
  do {
    if (hidden >= 0)
      p->sparse->is_excluded_row[hidden] = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = p->failed ? -1 : km_sparse_hidden_row(p, matrix, forced, threshold);
  } while (hidden >= 0);
}

/* Finds the primary rows only. Elimination by columns comes first; dependent rows can cause much fill-in there. If a
 * bound of entries is exceeded, sparse QR finds and excludes them. QR has at least the entries of the Gram matrix, far
 * more if rows outnumber columns, so it waits for a postponed column in that case. */
static void find_rows(km_factor *p, const double *matrix, const bool *forced, double threshold) {
  enum { MAX_FILL = 4 };
  km_sparse *s = p->sparse;
  s->max_entries = (int)fmin(fmax((double)MAX_FILL * s->start[p->columns], km_sparse_full_gram_cost(p)), INT_MAX);
  s->limits_fill_if_postponing = p->rows > p->columns;
  eliminate_until_consistent(p, matrix, forced, threshold, true);
  s->max_entries = 0;
  if (!s->is_overfull)
    return;
  s->postpones_small = false;
  memset(s->is_postponed, 0, (size_t)p->columns * sizeof *s->is_postponed);
  km_sparse_find_dependent_rows(p, matrix, forced, threshold);
  eliminate_by_rows(p, matrix, forced, threshold);
}

/* True if minimum-norm steps use the row equations, so that null vectors need not be short. */
static bool uses_row_equations(const km_factor *p) {
  return p->rank > KM_MANY_VECTORS && km_factor_freedom(p) > KM_MANY_VECTORS;
}

/* True if any independent columns suffice for the basis. */
static bool is_any_basis_sufficient(const km_factor *p, km_factor_basis basis) {
  return basis != KM_BASIS_SHORT && uses_row_equations(p);
}

bool km_sparse_is_basis_sufficient(const km_factor *p, km_factor_basis basis) {
  const km_factor_basis present = p->options.basis;
  return (basis == KM_BASIS_NONE) == (present == KM_BASIS_NONE) &&
         (basis == KM_BASIS_ENTRIES) == (present == KM_BASIS_ENTRIES) &&
         (!p->sparse->is_basis_any || is_any_basis_sufficient(p, basis));
}

/* Eliminates with better independent columns until max|B| is small. If any columns suffice, the search ends early. */
static void find_good_columns(km_factor *p, const double *matrix, const bool *forced, double threshold) {
  for (int pass = 0; pass < MAX_PASSES; ++pass) {
    eliminate_until_consistent(p, matrix, forced, threshold,
                               pass + 1 < MAX_PASSES && p->options.basis != KM_BASIS_ENTRIES);
    if (p->options.basis == KM_BASIS_ENTRIES)
      break;
    bool many = km_factor_freedom(p) > KM_MANY_VECTORS, others = many && pass == 0 && postpone_shared_columns(p);
    double most = many && pass > 0 ? km_max_good_b : km_max_b_growth; /* complete pivoting leaves about 1 */
    bool finite = km_sparse_find_b(p, forced, others ? most : HUGE_VAL);
    if (finite && max_free_b(p, forced) <= most)
      break;
    bool ends = !others && is_any_basis_sufficient(p, p->options.basis);
    p->sparse->is_basis_any = ends;
    if (ends || (!others && (!finite || !km_sparse_choose_independent(p, forced))))
      break;
  }
}

/* Factors a sparse matrix: rows only, or good independent columns. */
void km_sparse_factor(km_factor *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  p->scale = km_max_magnitude(matrix, s->start[p->columns]);
  p->locked_count = 0;
  s->postpones_small = false;
  s->is_basis_any = false;
  p->max_b = 0.0;
  for (int c = 0; c < p->columns; ++c)
    p->locked_count += km_factor_is_locked(p, c);
  memset(s->is_postponed, 0, (size_t)p->columns * sizeof *s->is_postponed);
  memset(s->is_excluded_row, 0, (size_t)p->rows * sizeof *s->is_excluded_row);
  s->has_rows_only = p->options.basis == KM_BASIS_NONE && !km_sparse_gram_is_dense(p);
  (s->has_rows_only ? find_rows : find_good_columns)(p, matrix, forced, tolerance * p->scale);
}
