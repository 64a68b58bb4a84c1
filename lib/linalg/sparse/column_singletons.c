/* Columns with a single entry: pivots that eliminate nothing. Jacobians have many, since a loop's closing joint turns about
 * the point at which the loop's rows are taken. */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

/* Counts the entries of every column. */
static void count_entries(const km_partition *p, const double *matrix) {
  const km_sparse *s = p->sparse;
  const int *const start = s->start;
  km_open_entries *const open = s->open_entries;
  for (int c = 0, k = 0; c < p->columns; ++c) {
    km_open_entries own = {0, 0};
    for (; k < start[c + 1]; ++k) {
      if (matrix[k] == 0.0)
        continue;
      own.count++;
      own.index_xor ^= k;
    }
    open[c] = own;
  }
}

/* The row counts no more: other columns may be left with a single entry, and are listed behind the others. */
static int close_row(const km_sparse *s, const double *matrix, int row, int listed) {
  km_open_entries *const open = s->open_entries;
  int *const list = s->dropped;
  const km_row_entry *const end = s->by_row + s->row_start[row + 1];
  for (const km_row_entry *at = s->by_row + s->row_start[row]; at < end; ++at) {
    km_open_entries *own = &open[at->column];
    if (matrix[at->entry] == 0.0)
      continue;
    own->index_xor ^= at->entry;
    if (--own->count == 1)
      list[listed++] = at->column;
  }
  return listed;
}

/* Lists those columns that have one entry in rows that are no spare ones, in `dropped`. Returns how many. */
static int list_first(const km_partition *p, const double *matrix) {
  const km_sparse *s = p->sparse;
  int *const list = s->dropped, listed = 0;
  count_entries(p, matrix);
  for (int r = 0; r < p->rows; ++r)
    if (s->is_excluded_row[r])
      close_row(s, matrix, r, 0);
  for (int i = 0; i < p->columns; ++i)
    if (s->open_entries[s->order[i]].count == 1)
      list[listed++] = s->order[i];
  return listed;
}

/* The entries of column c beside its single one go to U, or have to be 0. */
static int split(km_sparse *s, const double *matrix, int c, int upper_end) {
  const int *const row = s->row, *const step_of = s->step_of, last = s->start[c + 1],
                   single = s->open_entries[c].index_xor;
  int *const index = s->upper_store.index, end = upper_end;
  double *const value = s->upper_store.value;
  for (int k = s->start[c]; k < last; ++k) {
    int step = step_of[row[k]];
    if (step >= 0) {
      index[end] = step;
      value[end++] = matrix[k];
    } else if (k != single && !s->is_excluded_row[row[k]]) {
      s->singleton_zero[s->singleton_zero_count++] = k;
    }
  }
  s->upper[c] = (km_entry_range){upper_end, end};
  return end;
}

/* What is told of the steps, once they are found. */
static void finish(km_partition *p) {
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

int km_sparse_take_singletons(km_partition *p, const double *matrix, const bool *forced, double least) {
  km_sparse *s = p->sparse;
  km_open_entries *const open = s->open_entries;
  int rank = 0, upper_end = 0, listed = list_first(p, matrix), *const list = s->dropped;
  s->singleton_zero_count = 0;
  memset(s->lower, 0, (size_t)p->columns * sizeof *s->lower);
  p->failed = p->failed || !km_sparse_reserve_factor(s, s->start[p->columns], 0);
  while (listed > 0 && !p->failed) { /* the last one listed first: its neighbours are at hand */
    int c = list[--listed], single = open[c].index_xor;
    if (open[c].count != 1 || s->is_postponed[c] || km_sparse_is_preset(p, forced, c) ||
        !(fabs(matrix[single]) > least))
      continue;
    int row = s->row[single];
    upper_end = split(s, matrix, c, upper_end);
    p->row[rank] = row;
    p->column[rank] = c;
    p->inverse[rank] = matrix[single];
    s->step_of[row] = rank++;
    listed = close_row(s, matrix, row, listed);
    open[c].count = -1;
  }
  p->rank = rank;
  finish(p);
  return upper_end;
}
