/* Supernodes: consecutive steps whose rows of L are nested, rows(k) = {pivot row of k + 1} ∪ rows(k + 1)
 * (docs/theory.md 3.6). Much fill-in makes nearly all rows nested. Their entries of L are stored a second time, in a
 * shared row order, so that eight steps are subtracted in one pass. */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <string.h>

enum { WIDTH = KM_SUPERNODE_WIDTH };
enum { MIN_ENTRIES = 2 * WIDTH }; /* entries of a step below which supernodes do not pay */

void km_sparse_reset_supernodes(km_partition *p) {
  memset(p->sparse->is_nested, 0, (size_t)p->rows * sizeof *p->sparse->is_nested);
  memset(p->sparse->supernode_range, 0, (size_t)p->rows * sizeof *p->sparse->supernode_range);
  p->sparse->supernode_end = 0;
}

/* Position of `row` in the range, if all other rows of the range are those of column_of_l; else −1. */
static int find_extra_row(const km_sparse *s, const km_entry_range *run, const km_entry_range *column_of_l, int row) {
  int position = -1;
  bool all = run->end - run->start == column_of_l->end - column_of_l->start + 1;
  for (int i = column_of_l->start; i < column_of_l->end && all; ++i)
    s->visited[s->lower_store.index[i]] = true;
  for (int i = run->start; i < run->end && all; ++i) {
    int r = s->supernode_store.index[i];
    position = r == row ? i - run->start : position;
    all = r == row || s->visited[r];
  }
  for (int i = column_of_l->start; i < column_of_l->end; ++i)
    s->visited[s->lower_store.index[i]] = false;
  return all ? position : -1;
}

static void swap_entries(km_entry_store *store, int a, int b) {
  int index = store->index[a];
  double value = store->value[a];
  store->index[a] = store->index[b];
  store->value[a] = store->value[b];
  store->index[b] = index;
  store->value[b] = value;
}

/* Moves the row at that position to the front of step k's range, and accordingly in all steps of its supernode. */
static void move_row_to_front(km_sparse *s, int k, int position) {
  for (int n = k, ahead = 0; n == k || (n >= 0 && s->is_nested[n]); --n, ++ahead)
    swap_entries(&s->supernode_store, s->supernode_range[n].start + ahead,
                 s->supernode_range[n].start + ahead + position);
}

/* Copies the step's entries of L in the given row order. */
static void copy_entries(km_sparse *s, int step, const km_entry_range *column_of_l, const int *rows) {
  const int count = column_of_l->end - column_of_l->start, start = s->supernode_end;
  s->supernode_range[step] = (km_entry_range){start, start + count};
  s->supernode_end += count;
  memmove(s->supernode_store.index + start, rows, (size_t)count * sizeof *rows);
  for (int i = column_of_l->start; i < column_of_l->end; ++i)
    s->x[s->lower_store.index[i]] = s->lower_store.value[i];
  for (int i = start; i < start + count; ++i) {
    s->supernode_store.value[i] = s->x[s->supernode_store.index[i]];
    s->x[s->supernode_store.index[i]] = 0.0;
  }
}

/* Appends a step to the supernode before it if the rows of L are nested. */
void km_sparse_extend_supernode(km_partition *p, int step) {
  km_sparse *s = p->sparse;
  const km_entry_range *column_of_l = &s->lower[p->column[step]];
  if (column_of_l->end - column_of_l->start < MIN_ENTRIES ||
      /* no supernode without memory */
      !km_sparse_grow(s, &s->supernode_store, s->supernode_end + column_of_l->end - column_of_l->start))
    return;
  int position = step > 0 ? find_extra_row(s, &s->supernode_range[step - 1], column_of_l, p->row[step]) : -1;
  const int *rows = s->lower_store.index + column_of_l->start;
  if (position >= 0) {
    move_row_to_front(s, step - 1, position);
    s->is_nested[step - 1] = true;
    rows = s->supernode_store.index + s->supernode_range[step - 1].start + 1;
  }
  copy_entries(s, step, column_of_l, rows);
}

/* Tests whether the next rows of a column are the pivot rows of nested steps. */
bool km_sparse_supernode_follows(const km_partition *p, const int *list, int count) {
  const km_sparse *s = p->sparse;
  int step = s->step_of[list[0]];
  bool all = step >= 0 && count >= WIDTH && s->is_nested[step];
  for (int n = 1; n < WIDTH && all; ++n)
    all = list[n] == p->row[step + n] && (n + 1 == WIDTH || s->is_nested[step + n]);
  return all;
}

/* The sums and their order are those of single steps, so the bits are equal. */
void km_sparse_supernode_subtract(const km_partition *p, int step, double u[WIDTH]) {
  const km_sparse *s = p->sparse;
  const double *value[WIDTH];
  double *const x = s->x;
  for (int n = 0; n < WIDTH; ++n) {
    const double *column_of_l = s->supernode_store.value + s->supernode_range[step + n].start;
    u[n] = x[p->row[step + n]];
    x[p->row[step + n]] = 0.0;
    for (int m = n + 1; m < WIDTH; ++m)
      x[p->row[step + m]] -= column_of_l[m - n - 1] * u[n];
    value[n] = column_of_l + (WIDTH - 1 - n);
  }
  const km_entry_range *last = &s->supernode_range[step + WIDTH - 1];
  const int *row = s->supernode_store.index + last->start, count = last->end - last->start;
  int i = 0;
  for (; i + 1 < count; i += 2) {
    km_pair sum = {x[row[i]], x[row[i + 1]]};
    for (int n = 0; n < WIDTH; ++n)
      sum -= (km_pair){value[n][i], value[n][i + 1]} * (km_pair){u[n], u[n]};
    x[row[i]] = sum[0];
    x[row[i + 1]] = sum[1];
  }
  for (int n = 0; n < WIDTH && i < count; ++n)
    x[row[i]] -= value[n][i] * u[n];
}
