/* What the sparse factor is used for: the same pivots on new values, B, solutions. */
#include "base/extrema.h"
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The entries in primary rows only. */
static void scatter_primary(const km_partition *p, const double *matrix, int c) {
  const km_sparse *s = p->sparse;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    if (s->step_of[s->row[i]] >= 0)
      s->x[s->row[i]] = matrix[i];
}

void km_sparse_solve_upper(const km_partition *p, double *y) {
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

static int descending(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (y > x) - (y < x);
}

/* The steps that the column reaches, descending, into list[0 … count-1]; where they are many by looking at all steps. */
static int list_reached(const km_partition *p, const km_entry_range *own) {
  km_sparse *s = p->sparse;
  int top = km_sparse_reach_upper(p, own), count = p->rows - top;
  if (count > p->rank / 16) {
    int n = 0;
    for (int k = p->rank - 1; k >= 0; --k)
      if (s->visited[k])
        s->reach_list[n++] = k;
  } else {
    memmove(s->reach_list, s->reach_list + top, (size_t)count * sizeof *s->reach_list);
    qsort(s->reach_list, (size_t)count, sizeof *s->reach_list, descending);
  }
  for (int i = 0; i < count; ++i)
    s->visited[s->reach_list[i]] = false;
  return count;
}

/* U⁻¹ times the column of U, into the store from `end` on: the entries other than 0. */
static km_entry_range solve_whole(const km_partition *p, const km_entry_range *own, int end) {
  const km_sparse *s = p->sparse;
  double *const x = s->x, *const value = s->b_store.value;
  int *const index = s->b_store.index;
  km_entry_range run = {end, end};
  for (int i = own->start; i < own->end; ++i)
    x[s->upper_store.index[i]] = s->upper_store.value[i];
  km_sparse_solve_upper(p, x);
  for (int k = 0; k < p->rank; ++k) {
    if (x[k] == 0.0)
      continue;
    index[run.end] = k;
    value[run.end++] = x[k];
  }
  memset(x, 0, (size_t)p->rank * sizeof *x);
  return run;
}

/* The same by the steps that the column reaches. */
static km_entry_range solve_reached(const km_partition *p, const km_entry_range *own, int end) {
  km_sparse *s = p->sparse;
  km_entry_range run = {end, end};
  int count = list_reached(p, own);
  for (int i = own->start; i < own->end; ++i)
    s->x[s->upper_store.index[i]] = s->upper_store.value[i];
  for (int i = 0; i < count; ++i) {
    int step = s->reach_list[i];
    double value = s->x[step] * p->inverse[step];
    const km_entry_range *above = &s->upper[p->column[step]];
    s->x[step] = value;
    for (int n = above->start; n < above->end && value != 0.0; ++n)
      s->x[s->upper_store.index[n]] -= s->upper_store.value[n] * value;
  }
  for (int i = count - 1; i >= 0; --i) {
    if (s->x[s->reach_list[i]] != 0.0) {
      s->b_store.index[run.end] = s->reach_list[i];
      s->b_store.value[run.end++] = s->x[s->reach_list[i]];
    }
    s->x[s->reach_list[i]] = 0.0;
  }
  return run;
}

/* Whichever takes less, as the last one tells: to ask which steps are reached takes as long as to go through them. The entries are the
 * same. */
static km_entry_range solve_column(const km_partition *p, const km_entry_range *own, int end) {
  enum { FEW = 16 };
  km_sparse *s = p->sparse;
  km_entry_range run = (s->was_last_b_long ? solve_whole : solve_reached)(p, own, end);
  s->was_last_b_long = run.end - run.start > p->rank / FEW;
  return run;
}

/* So few vectors take no more steps in all than the matrix has entries: which ones are reached needn't be asked. */
static bool are_few(const km_partition *p) {
  return (double)(p->columns - p->rank) * p->rank <= p->sparse->start[p->columns];
}

km_entry_range km_sparse_b(const km_partition *p, int k) {
  const km_sparse *s = p->sparse;
  return s->stores_all_b ? s->b[k] : solve_column(p, &s->upper[p->column[p->rank + k]], 0);
}

double km_sparse_random_weight(int index, int probe) {
  uint32_t mixed = (uint32_t)index * 2654435769u + (uint32_t)probe * 2246822519u;
  mixed = (mixed ^ mixed >> 15) * 2246822519u;
  mixed = (mixed ^ mixed >> 13) * 3266489917u;
  double size = 1.0 + (mixed & 0xffff) / 65536.0;
  return mixed >> 31 ? size : -size;
}

/* About the length of the longest row of B, by its products with such weights. O(entries of U). */
static double longest_row(const km_partition *p, const bool *forced) {
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

/* Of all independent columns, or of the free ones alone. Ends at a free column with an entry beyond `most`. NaN stays. */
static double measure_b(const km_partition *p, bool free_only, const bool *forced, double most) {
  const km_sparse *s = p->sparse;
  double largest = 0.0;
  int entries = 0;
  for (int k = p->rank; k < p->columns; ++k) {
    bool given = km_sparse_is_preset(p, forced, p->column[k]);
    if (given && free_only)
      continue;
    if (entries > KM_SPARSE_MAX_NULL_FILL * s->start[p->columns])
      return fmax(largest, longest_row(p, free_only ? forced : NULL));
    km_entry_range run = km_sparse_b(p, k - p->rank);
    double size = 0.0;
    for (int i = run.start; i < run.end; ++i)
      size = km_larger_or_nan(fabs(s->b_store.value[i]), size);
    largest = km_larger_or_nan(size, largest);
    entries += run.end - run.start;
    if (size > most && !given)
      break;
  }
  return largest;
}

double km_sparse_estimate_max_b(const km_partition *p, const bool *forced) {
  return measure_b(p, true, forced, HUGE_VAL);
}

/* The columns of B, which are kept. False where a value is not finite. */
static bool find_columns(km_partition *p, const bool *forced, double most) {
  km_sparse *s = p->sparse;
  bool finite = true, few = are_few(p);
  int end = 0;
  for (int k = p->rank; k < p->columns; ++k) {
    p->failed = p->failed || !km_sparse_grow(s, &s->b_store, end + p->rank);
    if (p->failed)
      return false;
    km_entry_range run = (few ? solve_whole : solve_column)(p, &s->upper[p->column[k]], end);
    const double *b = s->b_store.value + end;
    double size = km_max_magnitude(b, run.end - end);
    p->max_b = size > p->max_b ? size : p->max_b;
    finite = km_all_finite(b, run.end - end) && finite;
    s->b[k - p->rank] = run;
    end = run.end;
    if (size > most && !km_sparse_is_preset(p, forced, p->column[k]))
      break;
  }
  return finite;
}

static int sign_of(const km_partition *p) {
  bool negative = false;
  for (int i = 0; i < p->rank; ++i)
    negative = negative != (p->inverse[i] < 0.0);
  return negative ? -1 : 1;
}

bool km_sparse_find_b(km_partition *p, const bool *forced, double most) {
  km_sparse *s = p->sparse;
  p->max_b = 0.0;
  p->sign = sign_of(p);
  s->is_b_unmeasured = false;
  s->stores_all_b = km_partition_freedom(p) <= KM_MANY_VECTORS;
  if (s->stores_all_b)
    return find_columns(p, forced, most);
  p->failed = p->failed || !km_sparse_grow(s, &s->b_store, p->rank);
  if (p->failed)
    return false;
  p->max_b = measure_b(p, false, forced, most);
  return isfinite(p->max_b);
}

double km_sparse_current_max_b(const km_partition *p) {
  return p->sparse->is_b_unmeasured ? measure_b(p, false, NULL, HUGE_VAL) : p->max_b;
}

/* Of many vectors, with room for one. */
static bool let_b_wait(km_partition *p) {
  km_sparse *s = p->sparse;
  p->max_b = p->max_b_at_search;
  p->sign = sign_of(p);
  s->is_b_unmeasured = true;
  s->stores_all_b = false;
  p->failed = p->failed || !km_sparse_grow(s, &s->b_store, p->rank);
  return !p->failed && km_all_finite(p->inverse, p->rank);
}

const double *km_sparse_gather_b(const km_partition *p, int k) {
  const km_sparse *s = p->sparse;
  km_entry_range b = km_sparse_b(p, k);
  memset(p->work, 0, (size_t)p->rank * sizeof *p->work);
  for (int i = b.start; i < b.end; ++i)
    p->work[s->b_store.index[i]] = s->b_store.value[i];
  return p->work;
}

/* Are the entries 0 whose rows the single columns left to others? */
static bool are_zero(const km_sparse *s, const double *matrix) {
  bool all = true;
  for (int i = 0; i < s->singleton_zero_count; ++i)
    all = all && matrix[s->singleton_zero[i]] == 0.0;
  return all;
}

/* A single column k: what it has in the rows of the steps before goes to U as it is, and nothing to L. */
static void refactor_single(km_partition *p, const double *matrix, int k) {
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

/* B of new values. */
static bool renew_b(km_partition *p) {
  if (p->unrestricted_basis || p->sparse->has_rows_only)
    return true;
  bool waits = p->basis_quality_unneeded && km_partition_freedom(p) > KM_MANY_VECTORS;
  return waits ? let_b_wait(p) : km_sparse_find_b(p, NULL, HUGE_VAL);
}

bool km_sparse_refactor(km_partition *p, const double *matrix, bool whole) {
  km_sparse *s = p->sparse;
  s->is_cached = false;
  if (p->failed || !km_all_finite(matrix, s->start[p->columns]) || (s->has_normal_only && !p->rows_only))
    return false;
  if (s->has_normal_only) /* the rows' next least solution shows whether they still stand */
    return true;
  if (!are_zero(s, matrix))
    return whole && km_sparse_refactor_full_pattern(p, matrix) && renew_b(p);
  for (int k = 0; k < s->singleton_count; ++k)
    refactor_single(p, matrix, k);
  const int count =
      s->has_rows_only ? p->rank : p->columns; /* by rows the independent columns have no entries of U to take theirs */
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
  return renew_b(p);
}

void km_sparse_solve(const km_partition *p, const double *rhs, double *x) {
  const km_sparse *s = p->sparse;
  double *y = p->work;
  if (s->has_normal_only) { /* comes to this where memory is short */
    memset(x, 0, (size_t)p->columns * sizeof *x);
    return;
  }
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

/* A column's entries of U take what their steps have in L; L is divided by the pivot; B by the upper columns of every
 * independent one, and the right side once through all of them. */
double km_sparse_multiplications(const km_partition *p) {
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

void km_sparse_copy(km_partition *to, const km_partition *from) {
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
  t->is_cached = false;
  t->has_rows_only = f->has_rows_only;
  t->has_normal_only = f->has_normal_only;
  memcpy(t->step_of, f->step_of, (size_t)from->rows * sizeof *t->step_of);
  to->failed = from->failed || !km_sparse_reserve_factor(t, upper, lower);
  if (to->failed)
    return;
  memcpy(t->upper_store.index, f->upper_store.index, (size_t)upper * sizeof *t->upper_store.index);
  memcpy(t->lower_store.index, f->lower_store.index, (size_t)lower * sizeof *t->lower_store.index);
}
