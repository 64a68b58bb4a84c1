/* Column singletons: columns with one entry in open rows, pivots that eliminate nothing (docs/theory.md 3.6). Jacobians
 * have many, since a loop's closing joint rotates about the point at which the loop's rows are taken. */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

/* Counts the non-zero entries of every column. */
static void count_entries(const km_factor *p, const double *matrix) {
  const km_sparse *s = p->sparse;
  const int *const start = s->start;
  km_open_entries *const open = s->open_entries;
  for (int c = 0, k = 0; c < p->columns; ++c) {
    km_open_entries column = {0, 0};
    for (; k < start[c + 1]; ++k) {
      if (matrix[k] == 0.0)
        continue;
      column.count++;
      column.index_xor ^= k;
    }
    open[c] = column;
  }
}

/* Removes a row: columns that are left with a single entry are appended to the list of singletons. Returns its
 * length. */
static int remove_row(const km_sparse *s, const double *matrix, int row, int list_count) {
  km_open_entries *const open = s->open_entries;
  int *const list = s->dropped;
  const km_row_entry *const end = s->by_row + s->row_start[row + 1];
  for (const km_row_entry *at = s->by_row + s->row_start[row]; at < end; ++at) {
    km_open_entries *column = &open[at->column];
    if (matrix[at->entry] == 0.0)
      continue;
    column->index_xor ^= at->entry;
    if (--column->count == 1)
      list[list_count++] = at->column;
  }
  return list_count;
}

/* Lists the columns with one entry in rows that are not excluded, in `dropped`. Returns their number. */
static int list_singletons(const km_factor *p, const double *matrix) {
  const km_sparse *s = p->sparse;
  int *const list = s->dropped, list_count = 0;
  count_entries(p, matrix);
  for (int r = 0; r < p->rows; ++r)
    if (s->is_excluded_row[r])
      remove_row(s, matrix, r, 0);
  for (int i = 0; i < p->columns; ++i)
    if (s->open_entries[s->order[i]].count == 1)
      list[list_count++] = s->order[i];
  return list_count;
}

/* Stores the entries of singleton column c in pivot rows as entries of U; other entries have to be 0. */
static int store_column(km_sparse *s, const double *matrix, int c, int upper_end) {
  const int *const row = s->row, *const step_of = s->step_of, last = s->start[c + 1],
                   pivot_entry = s->open_entries[c].index_xor;
  int *const index = s->upper_store.index, end = upper_end;
  double *const value = s->upper_store.value;
  for (int k = s->start[c]; k < last; ++k) {
    int step = step_of[row[k]];
    if (step >= 0) {
      index[end] = step;
      value[end++] = matrix[k];
    } else if (k != pivot_entry && !s->is_excluded_row[row[k]]) {
      s->singleton_zero[s->singleton_zero_count++] = k;
    }
  }
  s->upper[c] = (km_entry_range){upper_end, end};
  return end;
}

/* Inverts the pivots and stores their range and order. */
static void store_pivots(km_factor *p) {
  km_sparse *s = p->sparse;
  double *const inverse = p->inverse, smallest = p->smallest_pivot; /* still the pivots */
  p->first_pivot = km_max_magnitude(inverse, p->rank);
  for (int k = 0; k < p->rank; ++k)
    smallest = fabs(inverse[k]) < smallest ? fabs(inverse[k]) : smallest;
  for (int k = 0; k < p->rank; ++k)
    inverse[k] = 1.0 / inverse[k];
  p->smallest_pivot = smallest;
  memcpy(s->factor_order, p->column, (size_t)p->rank * sizeof *s->factor_order);
  s->singleton_count = p->rank;
}

/* Takes singletons as pivots until none is left; each removal can create further ones. */
int km_sparse_take_singletons(km_factor *p, const double *matrix, const bool *forced, double min_pivot) {
  km_sparse *s = p->sparse;
  km_open_entries *const open = s->open_entries;
  int rank = 0, upper_end = 0, list_count = list_singletons(p, matrix), *const list = s->dropped;
  s->singleton_zero_count = 0;
  memset(s->lower, 0, (size_t)p->columns * sizeof *s->lower);
  p->failed = p->failed || !km_sparse_reserve_factor(s, s->start[p->columns], 0);
  while (list_count > 0 && !p->failed) { /* last one first: its neighbours are in the cache */
    int c = list[--list_count], pivot_entry = open[c].index_xor;
    if (open[c].count != 1 || s->is_postponed[c] || km_sparse_is_preset(p, forced, c) ||
        !(fabs(matrix[pivot_entry]) > min_pivot))
      continue;
    int row = s->row[pivot_entry];
    upper_end = store_column(s, matrix, c, upper_end);
    p->row[rank] = row;
    p->column[rank] = c;
    p->inverse[rank] = matrix[pivot_entry];
    s->step_of[row] = rank++;
    list_count = remove_row(s, matrix, row, list_count);
    open[c].count = -1;
  }
  p->rank = rank;
  store_pivots(p);
  return upper_end;
}
