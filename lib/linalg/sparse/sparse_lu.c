/* The sparse engine: LU by columns with COLAMD's order, rank by what is left, and the choice of independent columns. */
#include "linalg/sparse/sparse_lu.h"
#include "linalg/dense/simd_pair.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* Smaller |B| than that is as good as complete pivoting gives. Of many vectors little is made, and they may reach far: the
 * choice among them isn't worth more. */
static const double good_b = 2.0, good_b_of_many = 30.0;
enum { MOST_PASSES = 4 };
/* Columns with more entries than others are shared by several loops: with those independent, null vectors reach no further
 * than a loop and its neighbours. Returns whether they aren't those that are independent now. */
static bool leave_shared(km_partition *p) {
  km_sparse *s = p->sparse;
  bool changed = false;
  for (int c = 0; c < p->columns; ++c)
    s->is_postponed[c] = (s->start[c + 1] - s->start[c]) * p->columns > s->start[p->columns];
  for (int k = 0; k < p->rank; ++k)
    changed = changed || s->is_postponed[p->column[k]];
  return changed;
}

/* Of the independent columns that aren't forced. */
static double largest_free_b(const km_partition *p, const bool *forced) {
  return forced || p->locked ? km_sparse_estimate_max_b(p, forced) : p->max_b;
}

/* A column that is dependent though no pivot tells; -1: none, or the rank alone counts, and the primary rows are independent.
 */
static int find_hidden(const km_partition *p, const double *matrix, const bool *forced, double threshold,
                       bool rank_counts) {
  if (p->failed || p->sparse->is_overfull)
    return -1;
  return rank_counts && km_sparse_hidden_row(p, matrix, forced, threshold) < 0
             ? -1
             : km_sparse_hidden_column(p, forced, threshold);
}

/* Until no column is dependent that no pivot tells, or that shows at least that the rank is right. What a column that comes
 * last already keeps grew by small pivots: a row among the primary ones depends on the others, unless a forced column tells them apart. */
static void eliminate_all(km_partition *p, const double *matrix, const bool *forced, double threshold,
                          bool rank_counts) {
  km_sparse *s = p->sparse;
  int hidden = -1, row = -1;
  do {
    if (row >= 0)
      s->is_excluded_row[row] = true;
    else if (hidden >= 0)
      s->is_postponed[hidden] = s->postpones_small = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = find_hidden(p, matrix, forced, threshold, rank_counts);
    bool last = hidden >= 0 && s->is_postponed[hidden];
    row = last ? km_sparse_hidden_row(p, matrix, p->forced_never_pivot ? forced : NULL, threshold) : -1;
    if (last && row < 0)
      hidden = -1;
  } while (hidden >= 0);
}

/* The same of rows, whatever the columns are, one after the other. */
static void eliminate_rows(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  int hidden = -1;
  do {
    if (hidden >= 0)
      p->sparse->is_excluded_row[hidden] = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = p->failed ? -1 : km_sparse_hidden_row(p, matrix, forced, threshold);
  } while (hidden >= 0);
}

/* By columns first, since their pivots tell more. Where rows depend on each other that may fill much, and little without those that
 * are superfluous: Q R finds these. It has no fewer entries than about the rows' products; where rows outnumber columns it has far
 * more, and is left to those that have shown a column to be dependent. */
static void find_rows(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  enum { MOST_FILL = 4 };
  km_sparse *s = p->sparse;
  s->max_entries = (int)fmin(fmax((double)MOST_FILL * s->start[p->columns], km_sparse_full_gram_cost(p)), INT_MAX);
  s->limits_fill_if_postponing = p->rows > p->columns;
  eliminate_all(p, matrix, forced, threshold, true);
  s->max_entries = 0;
  if (!s->is_overfull)
    return;
  s->postpones_small = false;
  memset(s->is_postponed, 0, (size_t)p->columns * sizeof *s->is_postponed);
  km_sparse_find_dependent_rows(p, matrix, forced, threshold);
  eliminate_rows(p, matrix, forced, threshold);
}

/* Are there so many motions that their least steps go by the rows, so that null vectors needn't be good ones? */
static bool goes_by_rows(const km_partition *p) {
  return p->rank > KM_MANY_VECTORS && km_partition_freedom(p) > KM_MANY_VECTORS;
}

/* Does any choice of independent columns serve who asks? */
static bool any_serve(const km_partition *p) {
  return p->basis_quality_unneeded && goes_by_rows(p);
}

/* Of the factor that is known: what was asked for changes it. */
static unsigned flags_of(const km_partition *p) {
  return (p->forced_never_pivot ? 1u : 0u) | (p->unrestricted_basis ? 2u : 0u) | (p->rows_only ? 4u : 0u) |
         (p->kept_row_tolerance > 0.0 ? 8u : 0u);
}

/* Flags of columns; NULL: none is set. */
static void keep_flags(bool *kept, const bool *flags, size_t count) {
  if (flags)
    memcpy(kept, flags, count * sizeof *kept);
  else
    memset(kept, 0, count * sizeof *kept);
}

static bool are_kept(const bool *kept, const bool *flags, size_t count) {
  return flags ? memcmp(kept, flags, count * sizeof *kept) == 0 : memchr(kept, true, count * sizeof *kept) == NULL;
}

bool km_sparse_has_factor(const km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  const km_sparse *s = p->sparse;
  const size_t columns = (size_t)p->columns;
  return s->is_cached && !p->failed && s->cached_tolerance == tolerance && s->cached_flags == flags_of(p) &&
         are_kept(s->cached_forced, forced, columns) && are_kept(s->cached_locked, p->locked, columns) &&
         memcmp(s->cached_matrix, matrix, (size_t)s->start[columns] * sizeof *matrix) == 0;
}

static void remember(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  memcpy(s->cached_matrix, matrix, (size_t)s->start[p->columns] * sizeof *matrix);
  keep_flags(s->cached_forced, forced, (size_t)p->columns);
  keep_flags(s->cached_locked, p->locked, (size_t)p->columns);
  s->cached_tolerance = tolerance;
  s->cached_flags = flags_of(p);
  s->is_cached = !p->failed;
}

/* Passes of elimination until |B| is small enough, from `pass` on; it can go on later where it ends before that since any choice
 * serves. */
static void find_better_columns(km_partition *p, const double *matrix, const bool *forced, double threshold, int pass) {
  for (; pass < MOST_PASSES; ++pass) {
    eliminate_all(p, matrix, forced, threshold, pass + 1 < MOST_PASSES && !p->unrestricted_basis);
    if (p->unrestricted_basis)
      break;
    bool many = km_partition_freedom(p) > KM_MANY_VECTORS, others = many && pass == 0 && leave_shared(p);
    double most = many && pass > 0 ? good_b_of_many : good_b;
    bool finite = km_sparse_find_b(p, forced, others ? most : HUGE_VAL);
    if (finite && largest_free_b(p, forced) <= most)
      break;
    bool ends = !others && any_serve(p) && km_partition_may_defer(p);
    p->sparse->resume_pass = ends && finite ? pass + 1 : 0;
    if (ends || (!others && (!finite || !km_sparse_choose_independent(p, forced))))
      break;
  }
}

static void find_good_columns(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  find_better_columns(p, matrix, forced, threshold, 0);
}

void km_sparse_factor(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  p->scale = km_max_magnitude(matrix, s->start[p->columns]);
  p->locked_count = 0;
  p->rows_were_kept = false;
  s->postpones_small = false;
  s->resume_pass = 0;
  p->max_b = 0.0;
  for (int c = 0; p->locked && c < p->columns; ++c)
    p->locked_count += p->locked[c];
  memset(s->is_postponed, 0, (size_t)p->columns * sizeof *s->is_postponed);
  memset(s->is_excluded_row, 0, (size_t)p->rows * sizeof *s->is_excluded_row);
  s->has_rows_only = p->rows_only && !km_sparse_gram_is_dense(p);
  s->has_normal_only = s->has_rows_only && km_sparse_rows_are_independent(p, matrix, forced, tolerance);
  if (!s->has_normal_only)
    (s->has_rows_only ? find_rows : find_good_columns)(p, matrix, forced, tolerance * p->scale);
  remember(p, matrix, forced, tolerance);
}

bool km_sparse_improve_independent(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  const int pass = s->resume_pass;
  if (pass == 0 || any_serve(p))
    return false;
  s->resume_pass = 0;
  bool changes = km_sparse_choose_independent(p, forced);
  if (changes)
    find_better_columns(p, matrix, forced, tolerance * p->scale, pass);
  remember(p, matrix, forced, tolerance);
  return changes;
}
