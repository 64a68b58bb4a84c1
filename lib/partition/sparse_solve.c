/* What the sparse factor is used for: the same pivots on new values, B, solutions. */
#include "partition/pair.h"
#include "partition/sparse.h"

#include <math.h>
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
    const km_run *above = &s->upper[p->column[k]];
    y[k] = value;
    if (value == 0.0)
      continue;
    for (int i = above->start; i < above->end; ++i)
      y[s->upper_store.index[i]] -= s->upper_store.value[i] * value;
  }
}

bool km_sparse_find_b(km_partition *p) {
  km_sparse *s = p->sparse;
  bool negative = false, finite = true;
  p->largest_b = 0.0;
  if (p->failed || !km_arena_grow(s->arena, (void **)&p->B, &s->b_capacity,
                                  (size_t)(p->columns - p->rank) * (size_t)p->rank, sizeof *p->B)) {
    p->failed = true;
    return false;
  }
  for (int i = 0; i < p->rank; ++i)
    negative = negative != (p->inverse[i] < 0.0);
  for (int k = p->rank; k < p->columns; ++k) {
    double *b = p->B + (size_t)(k - p->rank) * (size_t)p->rank;
    const km_run *own = &s->upper[p->column[k]];
    memset(b, 0, (size_t)p->rank * sizeof *b);
    for (int i = own->start; i < own->end; ++i)
      b[s->upper_store.index[i]] = s->upper_store.value[i];
    km_sparse_solve_upper(p, b);
    double size = km_largest_size(b, p->rank);
    p->largest_b = size > p->largest_b ? size : p->largest_b;
    finite = km_all_finite(b, p->rank) && finite;
  }
  p->sign = negative ? -1 : 1;
  return finite;
}

/* Are the entries 0 whose rows the single columns left to others? */
static bool are_zero(const km_sparse *s, const double *matrix) {
  bool all = true;
  for (int i = 0; i < s->zero_count; ++i)
    all = all && matrix[s->zero[i]] == 0.0;
  return all;
}

bool km_sparse_refactor(km_partition *p, const double *matrix) {
  km_sparse *s = p->sparse;
  if (p->failed || !km_all_finite(matrix, s->start[p->columns]) || !are_zero(s, matrix))
    return false;
  for (int k = 0; k < p->columns; ++k) {
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
  return p->any_independent || p->rows_only || km_sparse_find_b(p);
}

void km_sparse_solve(const km_partition *p, const double *rhs, double *x) {
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

/* A column's entries of U take what their steps have in L; L is divided by the pivot; B by the upper columns of every
 * independent one, and the right side once through all of them. */
double km_sparse_multiplications(const km_partition *p) {
  const km_sparse *s = p->sparse;
  double sum = 0.0, entries = 0.0;
  for (int k = 0; k < p->columns; ++k) {
    const km_run *upper = &s->upper[p->column[k]];
    for (int i = upper->start; i < upper->end; ++i) {
      const km_run *lower = &s->lower[p->column[s->upper_store.index[i]]];
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
  memcpy(t->zero, f->zero, (size_t)f->zero_count * sizeof *t->zero);
  t->zero_count = f->zero_count;
  memcpy(t->step_of, f->step_of, (size_t)from->rows * sizeof *t->step_of);
  to->failed = from->failed || !km_sparse_make_room(t, upper, lower);
  if (to->failed)
    return;
  memcpy(t->upper_store.index, f->upper_store.index, (size_t)upper * sizeof *t->upper_store.index);
  memcpy(t->lower_store.index, f->lower_store.index, (size_t)lower * sizeof *t->lower_store.index);
}
