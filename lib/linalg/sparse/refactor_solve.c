/* Refactorisation, B and solutions of the sparse factor (docs/theory.md 3.3, 3.6).
 *
 *   refactor: the stored pattern of L and U on new values;   B = U⁻¹ U_i, column by column;   x_d = U⁻¹ L⁻¹ rhs_p */
#include "base/extrema.h"
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Copies the entries of column c in primary rows to the accumulator. */
static void scatter_primary(const km_factor *p, const double *matrix, int c) {
  const km_sparse *s = p->sparse;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    if (s->step_of[s->row[i]] >= 0)
      s->x[s->row[i]] = matrix[i];
}

/* Back substitution with U by columns. */
void km_sparse_solve_upper(const km_factor *p, double *y) {
  const km_sparse *s = p->sparse;
  for (int k = p->rank - 1; k >= 0; --k) {
    double value = y[k] * p->inverse[k];
    const km_entry_range *above = &s->upper[p->column[k]];
    y[k] = value;
    if (value == 0.0)
      continue;
    for (int i = above->start; i < above->end; ++i)
      y[s->upper_store.index[i]] -= s->upper_store.value[i] * value;
  }
}

/* U⁻¹ times a column of U, by step, into the accumulator; the caller clears it. */
static double *solve_into_accumulator(const km_factor *p, const km_entry_range *column_of_u) {
  const km_sparse *s = p->sparse;
  for (int i = column_of_u->start; i < column_of_u->end; ++i)
    s->x[s->upper_store.index[i]] = s->upper_store.value[i];
  km_sparse_solve_upper(p, s->x);
  return s->x;
}

/* Column of B: U⁻¹ times a column of U; non-zero entries into the store from `end` on. */
static km_entry_range solve_column(const km_factor *p, const km_entry_range *column_of_u, int end) {
  const km_sparse *s = p->sparse;
  double *const x = solve_into_accumulator(p, column_of_u), *const value = s->b_store.value;
  int *const index = s->b_store.index;
  km_entry_range run = {end, end};
  for (int k = 0; k < p->rank; ++k) {
    if (x[k] == 0.0)
      continue;
    index[run.end] = k;
    value[run.end++] = x[k];
  }
  memset(x, 0, (size_t)p->rank * sizeof *x);
  return run;
}

km_entry_range km_sparse_b(const km_factor *p, int k) {
  const km_sparse *s = p->sparse;
  return s->stores_all_b ? s->b[k] : solve_column(p, &s->upper[p->column[p->rank + k]], 0);
}

/* Hash of index and probe: reproducible pseudo-random weight. */
double km_sparse_random_weight(int index, int probe) {
  uint32_t mixed = (uint32_t)index * 2654435769u + (uint32_t)probe * 2246822519u;
  mixed = (mixed ^ mixed >> 15) * 2246822519u;
  mixed = (mixed ^ mixed >> 13) * 3266489917u;
  double size = 1.0 + (mixed & 0xffff) / 65536.0;
  return mixed >> 31 ? size : -size;
}

/* Null vector −U⁻¹ u of one independent column. */
int km_factor_null_entries(const km_factor *p, int k, int *column, double *value) {
  const km_sparse *s = p->sparse;
  const int own = p->column[p->rank + k];
  double *const x = solve_into_accumulator(p, &s->upper[own]);
  int count = 0;
  column[count] = own;
  value[count++] = 1.0;
  for (int i = 0; i < p->rank; ++i) {
    if (x[i] == 0.0)
      continue;
    column[count] = p->column[i];
    value[count++] = -x[i];
  }
  memset(x, 0, (size_t)p->rank * sizeof *x);
  return count;
}

/* Estimate of the length of the longest row of B, by products with pseudo-random weights. O(entries of U). */
static double estimate_longest_row(const km_factor *p, const bool *forced) {
  enum { PROBES = 3 };
  const km_sparse *s = p->sparse;
  double largest = 0.0, *const x = s->x;
  for (int probe = 0; probe < PROBES; ++probe) {
    for (int k = p->rank; k < p->columns; ++k) {
      int c = p->column[k];
      double weight = km_sparse_random_weight(c, probe);
      for (int i = s->upper[c].start; i < s->upper[c].end && !km_sparse_is_preset(p, forced, c); ++i)
        x[s->upper_store.index[i]] += weight * s->upper_store.value[i];
    }
    km_sparse_solve_upper(p, x);
    for (int k = 0; k < p->rank; ++k)
      largest = km_larger_or_nan(fabs(x[k]), largest);
    memset(x, 0, (size_t)p->rank * sizeof *x);
  }
  return largest;
}

/* max|B_ij| over all independent columns, or over those that are not preset. Ends at such a column with an entry beyond
 * `max_entry`. NaN is returned. */
static double measure_max_b(const km_factor *p, bool free_only, const bool *forced, double max_entry) {
  const km_sparse *s = p->sparse;
  double largest = 0.0;
  int entries = 0;
  for (int k = p->rank; k < p->columns; ++k) {
    bool is_preset = km_sparse_is_preset(p, forced, p->column[k]);
    if (is_preset && free_only)
      continue;
    if (entries > KM_SPARSE_MAX_NULL_FILL * s->start[p->columns])
      return fmax(largest, estimate_longest_row(p, free_only ? forced : NULL));
    km_entry_range run = km_sparse_b(p, k - p->rank);
    double size = 0.0;
    for (int i = run.start; i < run.end; ++i)
      size = km_larger_or_nan(fabs(s->b_store.value[i]), size);
    largest = km_larger_or_nan(size, largest);
    entries += run.end - run.start;
    if (size > max_entry && !is_preset)
      break;
  }
  return largest;
}

double km_sparse_estimate_max_b(const km_factor *p, const bool *forced) {
  return measure_max_b(p, true, forced, HUGE_VAL);
}

/* Computes and stores all columns of B. False if a value is not finite. */
static bool compute_all_columns(km_factor *p, const bool *forced, double max_entry) {
  km_sparse *s = p->sparse;
  bool finite = true;
  int end = 0;
  for (int k = p->rank; k < p->columns; ++k) {
    p->failed = p->failed || !km_sparse_grow(s, &s->b_store, end + p->rank);
    if (p->failed)
      return false;
    km_entry_range run = solve_column(p, &s->upper[p->column[k]], end);
    const double *b = s->b_store.value + end;
    double size = km_max_magnitude(b, run.end - end);
    p->max_b = size > p->max_b ? size : p->max_b;
    finite = km_all_finite(b, run.end - end) && finite;
    s->b[k - p->rank] = run;
    end = run.end;
    if (size > max_entry && !km_sparse_is_preset(p, forced, p->column[k]))
      break;
  }
  return finite;
}

/* Sign of the product of the pivots. */
static int pivot_sign(const km_factor *p) {
  bool negative = false;
  for (int i = 0; i < p->rank; ++i)
    negative = negative != (p->inverse[i] < 0.0);
  return negative ? -1 : 1;
}

/* B = U⁻¹ U_i: all columns, or max|B| only with many freedoms. */
bool km_sparse_find_b(km_factor *p, const bool *forced, double max_entry) {
  km_sparse *s = p->sparse;
  p->max_b = 0.0;
  p->sign = pivot_sign(p);
  s->is_b_unmeasured = false;
  s->stores_all_b = km_factor_freedom(p) <= KM_MANY_VECTORS;
  if (s->stores_all_b)
    return compute_all_columns(p, forced, max_entry);
  p->failed = p->failed || !km_sparse_grow(s, &s->b_store, p->rank);
  if (p->failed)
    return false;
  p->max_b = measure_max_b(p, false, forced, max_entry);
  return isfinite(p->max_b);
}

double km_sparse_current_max_b(const km_factor *p) {
  return p->sparse->is_b_unmeasured ? measure_max_b(p, false, NULL, HUGE_VAL) : p->max_b;
}

/* Defers B of many null vectors: max|B| of the search is kept. */
static bool defer_b(km_factor *p) {
  km_sparse *s = p->sparse;
  p->max_b = p->max_b_at_search;
  p->sign = pivot_sign(p);
  s->is_b_unmeasured = true;
  s->stores_all_b = false;
  p->failed = p->failed || !km_sparse_grow(s, &s->b_store, p->rank);
  return !p->failed && km_all_finite(p->inverse, p->rank);
}

/* Dense copy of column k of B. */
const double *km_sparse_gather_b(const km_factor *p, int k) {
  const km_sparse *s = p->sparse;
  km_entry_range b = km_sparse_b(p, k);
  memset(p->work, 0, (size_t)p->rank * sizeof *p->work);
  for (int i = b.start; i < b.end; ++i)
    p->work[s->b_store.index[i]] = s->b_store.value[i];
  return p->work;
}

/* True if the entries that the singletons assume to be 0 are 0. */
static bool are_structural_zeros(const km_sparse *s, const double *matrix) {
  bool all = true;
  for (int i = 0; i < s->singleton_zero_count; ++i)
    all = all && matrix[s->singleton_zero[i]] == 0.0;
  return all;
}

/* Refactors singleton column k: entries in rows of earlier steps are entries of U; L has none. */
static void refactor_singleton(km_factor *p, const double *matrix, int k) {
  const km_sparse *s = p->sparse;
  const int c = p->column[k];
  double *u = s->upper_store.value + s->upper[c].start;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i) {
    int step = s->step_of[s->row[i]];
    if (step == k)
      p->inverse[k] = 1.0 / matrix[i];
    else if (step >= 0 && step < k)
      *u++ = matrix[i];
  }
}

/* Updates B after a refactorisation, or defers it. */
static bool update_b(km_factor *p) {
  if (!km_sparse_has_null_vectors(p))
    return true;
  bool is_deferred = p->options.basis != KM_BASIS_SHORT && km_factor_freedom(p) > KM_MANY_VECTORS;
  return is_deferred ? defer_b(p) : km_sparse_find_b(p, NULL, HUGE_VAL);
}

/* Numeric refactorisation on the stored pattern of L and U. */
bool km_sparse_refactor(km_factor *p, const double *matrix) {
  km_sparse *s = p->sparse;
  if (p->failed || !km_all_finite(matrix, s->start[p->columns]))
    return false;
  if (!are_structural_zeros(s, matrix))
    return km_sparse_refactor_full_pattern(p, matrix) && update_b(p);
  for (int k = 0; k < s->singleton_count; ++k)
    refactor_singleton(p, matrix, k);
  const int count =
      s->has_rows_only ? p->rank : p->columns; /* independent columns have no entries of U if only rows were
                                                * requested */
  for (int k = s->singleton_count; k < count; ++k) {
    int c = p->column[k];
    scatter_primary(p, matrix, c);
    for (int i = s->upper[c].start; i < s->upper[c].end; ++i) {
      int step = s->upper_store.index[i], row = p->row[step];
      s->upper_store.value[i] = s->x[row];
      s->x[row] = 0.0;
      km_sparse_subtract(s, &s->lower[p->column[step]], s->upper_store.value[i]);
    }
    if (k < p->rank) {
      p->inverse[k] = 1.0 / s->x[p->row[k]];
      s->x[p->row[k]] = 0.0;
    }
    for (int i = s->lower[c].start; i < s->lower[c].end; ++i) {
      if (k < p->rank)
        s->lower_store.value[i] = s->x[s->lower_store.index[i]] * p->inverse[k];
      s->x[s->lower_store.index[i]] = 0.0;
    }
  }
  return update_b(p);
}

/* Solves L U x_d = rhs_p; independent columns are 0. */
void km_sparse_solve(const km_factor *p, const double *rhs, double *x) {
  const km_sparse *s = p->sparse;
  double *y = p->work;
  memcpy(s->x, rhs, (size_t)p->rows * sizeof *s->x);
  for (int k = 0; k < p->rank; ++k) {
    y[k] = s->x[p->row[k]];
    if (y[k] != 0.0)
      km_sparse_subtract(s, &s->lower[p->column[k]], y[k]);
  }
  memset(s->x, 0, (size_t)p->rows * sizeof *s->x);
  km_sparse_solve_upper(p, y);
  for (int i = 0; i < p->rank; ++i)
    x[p->column[i]] = y[i];
  for (int c = p->rank; c < p->columns; ++c)
    x[p->column[c]] = 0.0;
}

/* Cost: entries of U times their columns of L; divisions by the pivots; B by all columns of U for each independent
 * column; one solution. */
double km_sparse_multiplications(const km_factor *p) {
  const km_sparse *s = p->sparse;
  double sum = 0.0, entries = 0.0;
  for (int k = 0; k < p->columns; ++k) {
    const km_entry_range *upper = &s->upper[p->column[k]];
    for (int i = upper->start; i < upper->end; ++i) {
      const km_entry_range *lower = &s->lower[p->column[s->upper_store.index[i]]];
      sum += lower->end - lower->start;
    }
    if (k < p->rank)
      entries += upper->end - upper->start + s->lower[p->column[k]].end - s->lower[p->column[k]].start + 1.0;
  }
  return sum + entries * (2.0 + p->columns - p->rank);
}

/* Copies pivots and pattern of L and U. */
void km_sparse_copy(km_factor *to, const km_factor *from) {
  km_sparse *t = to->sparse;
  const km_sparse *f = from->sparse;
  int upper = 0, lower = 0;
  for (int c = 0; c < from->columns; ++c) {
    upper = f->upper[c].end > upper ? f->upper[c].end : upper;
    lower = f->lower[c].end > lower ? f->lower[c].end : lower;
  }
  memcpy(t->upper, f->upper, (size_t)from->columns * sizeof *t->upper);
  memcpy(t->lower, f->lower, (size_t)from->columns * sizeof *t->lower);
  memcpy(t->singleton_zero, f->singleton_zero, (size_t)f->singleton_zero_count * sizeof *t->singleton_zero);
  t->singleton_zero_count = f->singleton_zero_count;
  t->singleton_count = f->singleton_count;
  t->has_rows_only = f->has_rows_only;
  memcpy(t->step_of, f->step_of, (size_t)from->rows * sizeof *t->step_of);
  to->failed = from->failed || !km_sparse_reserve_factor(t, upper, lower);
  if (to->failed)
    return;
  memcpy(t->upper_store.index, f->upper_store.index, (size_t)upper * sizeof *t->upper_store.index);
  memcpy(t->lower_store.index, f->lower_store.index, (size_t)lower * sizeof *t->lower_store.index);
}
