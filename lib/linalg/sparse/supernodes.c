/* Steps whose rows are those of the step behind them and its pivot's: where much fills in, nearly all of them. Their entries of L are
 * kept a second time, in an order that they share, so that several steps are subtracted in one pass. */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/sparse_lu.h"

#include <string.h>

enum { TOGETHER = KM_SUPERNODE_WIDTH };
enum { LEAST_ENTRIES = 2 * TOGETHER }; /* of a step, for less isn't worth it */

void km_sparse_reset_supernodes(km_partition *p) {
  memset(p->sparse->is_nested, 0, (size_t)p->rows * sizeof *p->sparse->is_nested);
  memset(p->sparse->supernode_range, 0, (size_t)p->rows * sizeof *p->sparse->supernode_range);
  p->sparse->supernode_end = 0;
}

/* Where the row is in the run, if all other rows of the run are those of `own`; -1: they aren't. */
static int place_in(const km_sparse *s, const km_entry_range *run, const km_entry_range *own, int row) {
  int place = -1;
  bool all = run->end - run->start == own->end - own->start + 1;
  for (int i = own->start; i < own->end && all; ++i)
    s->visited[s->lower_store.index[i]] = true;
  for (int i = run->start; i < run->end && all; ++i) {
    int r = s->supernode_store.index[i];
    place = r == row ? i - run->start : place;
    all = r == row || s->visited[r];
  }
  for (int i = own->start; i < own->end; ++i)
    s->visited[s->lower_store.index[i]] = false;
  return all ? place : -1;
}

static void exchange(km_entry_store *store, int a, int b) {
  int index = store->index[a];
  double value = store->value[a];
  store->index[a] = store->index[b];
  store->value[a] = store->value[b];
  store->index[b] = index;
  store->value[b] = value;
}

/* The row at that place of step k's run comes first there, and at the same place of all steps that end in the same rows. */
static void bring_forward(km_sparse *s, int k, int place) {
  for (int n = k, ahead = 0; n == k || (n >= 0 && s->is_nested[n]); --n, ++ahead)
    exchange(&s->supernode_store, s->supernode_range[n].start + ahead, s->supernode_range[n].start + ahead + place);
}

/* The step's entries in the order of these rows. */
static void take_entries(km_sparse *s, int step, const km_entry_range *own, const int *rows) {
  const int count = own->end - own->start, start = s->supernode_end;
  s->supernode_range[step] = (km_entry_range){start, start + count};
  s->supernode_end += count;
  memmove(s->supernode_store.index + start, rows, (size_t)count * sizeof *rows);
  for (int i = own->start; i < own->end; ++i)
    s->x[s->lower_store.index[i]] = s->lower_store.value[i];
  for (int i = start; i < start + count; ++i) {
    s->supernode_store.value[i] = s->x[s->supernode_store.index[i]];
    s->x[s->supernode_store.index[i]] = 0.0;
  }
}

void km_sparse_extend_supernode(km_partition *p, int step) {
  km_sparse *s = p->sparse;
  const km_entry_range *own = &s->lower[p->column[step]];
  if (own->end - own->start < LEAST_ENTRIES ||
      !km_sparse_grow(s, &s->supernode_store, s->supernode_end + own->end - own->start)) /* it does without */
    return;
  int place = step > 0 ? place_in(s, &s->supernode_range[step - 1], own, p->row[step]) : -1;
  const int *rows = s->lower_store.index + own->start;
  if (place >= 0) {
    bring_forward(s, step - 1, place);
    s->is_nested[step - 1] = true;
    rows = s->supernode_store.index + s->supernode_range[step - 1].start + 1;
  }
  take_entries(s, step, own, rows);
}

bool km_sparse_supernode_follows(const km_partition *p, const int *list, int count) {
  const km_sparse *s = p->sparse;
  int step = s->step_of[list[0]];
  bool all = step >= 0 && count >= TOGETHER && s->is_nested[step];
  for (int n = 1; n < TOGETHER && all; ++n)
    all = list[n] == p->row[step + n] && (n + 1 == TOGETHER || s->is_nested[step + n]);
  return all;
}

/* The same sums in the same order as one step after the other. */
void km_sparse_supernode_subtract(const km_partition *p, int step, double u[TOGETHER]) {
  const km_sparse *s = p->sparse;
  const double *value[TOGETHER];
  double *const x = s->x;
  for (int n = 0; n < TOGETHER; ++n) {
    const double *own = s->supernode_store.value + s->supernode_range[step + n].start;
    u[n] = x[p->row[step + n]];
    x[p->row[step + n]] = 0.0;
    for (int m = n + 1; m < TOGETHER; ++m)
      x[p->row[step + m]] -= own[m - n - 1] * u[n];
    value[n] = own + (TOGETHER - 1 - n);
  }
  const km_entry_range *last = &s->supernode_range[step + TOGETHER - 1];
  const int *row = s->supernode_store.index + last->start, count = last->end - last->start;
  int i = 0;
  for (; i + 1 < count; i += 2) {
    km_pair sum = {x[row[i]], x[row[i + 1]]};
    for (int n = 0; n < TOGETHER; ++n)
      sum -= (km_pair){value[n][i], value[n][i + 1]} * (km_pair){u[n], u[n]};
    x[row[i]] = sum[0];
    x[row[i + 1]] = sum[1];
  }
  for (int n = 0; n < TOGETHER && i < count; ++n)
    x[row[i]] -= value[n][i] * u[n];
}
