/* Columns with a single entry: pivots that eliminate nothing. Jacobians have many, since a loop's closing joint turns about
 * the point at which the loop's rows are taken. */
#include "partition/sparse.h"

#include <math.h>

/* Counts the entries of every column and lists those columns that have one, in `dropped`. Returns how many. */
static int list_first(km_partition *p, const double *matrix) {
  km_sparse *s = p->sparse;
  int count = 0;
  for (int c = 0; c < p->columns; ++c) {
    int open = 0;
    for (int k = s->start[c]; k < s->start[c + 1]; ++k)
      open += matrix[k] != 0.0 && !s->spare[s->row[k]];
    s->open[c] = open;
  }
  for (int i = 0; i < p->columns; ++i)
    if (s->open[s->order[i]] == 1)
      s->dropped[count++] = s->order[i];
  return count;
}

/* Where the single entry of column c is, -1: it is too small. The others of its pattern go to U, or have to be 0. */
static int split(km_partition *p, const double *matrix, int c, double least, int *upper_end) {
  km_sparse *s = p->sparse;
  const int *const row = s->row, *const step_of = s->step_of, last = s->start[c + 1];
  int *const zero = s->zero, *const index = s->upper_store.index;
  double *const value = s->upper_store.value;
  int pivot = -1, zeros = s->zero_count, end = *upper_end;
  for (int k = s->start[c]; k < last; ++k) {
    int step = step_of[row[k]];
    if (step >= 0) {
      index[end] = step;
      value[end++] = matrix[k];
    } else if (matrix[k] != 0.0 && !s->spare[row[k]]) {
      pivot = k;
    } else if (!s->spare[row[k]]) {
      zero[zeros++] = k;
    }
  }
  if (pivot < 0 || !(fabs(matrix[pivot]) > least))
    return -1;
  s->upper[c] = (km_run){*upper_end, end};
  s->lower[c] = (km_run){0, 0};
  s->zero_count = zeros;
  *upper_end = end;
  return pivot;
}

/* The row has a pivot now: other columns may be left with a single entry. */
static int close_row(const km_sparse *s, const double *matrix, int row, int listed) {
  int *const open = s->open, *const list = s->dropped;
  const km_row_entry *end = s->by_row + s->row_start[row + 1];
  for (const km_row_entry *at = s->by_row + s->row_start[row]; at < end; ++at)
    if (matrix[at->entry] != 0.0 && --open[at->column] == 1)
      list[listed++] = at->column;
  return listed;
}

int km_sparse_take_singles(km_partition *p, const double *matrix, const bool *forced, double least) {
  km_sparse *s = p->sparse;
  int upper_end = 0, listed = list_first(p, matrix);
  s->singles = s->zero_count = 0;
  p->failed = p->failed || !km_sparse_make_room(s, s->start[p->columns], 0);
  while (listed > 0 && !p->failed) { /* the last one listed first: its neighbours are at hand */
    int c = s->dropped[--listed];
    if (s->open[c] != 1 || s->late[c] || km_sparse_is_given(p, forced, c))
      continue;
    int pivot = split(p, matrix, c, least, &upper_end);
    if (pivot < 0)
      continue;
    int row = s->row[pivot], step = p->rank++;
    p->row[step] = row;
    p->column[step] = s->lead[step] = c;
    p->inverse[step] = 1.0 / matrix[pivot];
    s->step_of[row] = step;
    listed = close_row(s, matrix, row, listed);
    s->open[c] = -1;
    km_sparse_note(p, fabs(matrix[pivot]));
  }
  s->singles = p->rank;
  return upper_end;
}
