/* The sparse engine: LU by columns with COLAMD's order, rank by what is left, and the choice of independent columns. */
#include "partition/sparse.h"
#include "partition/pair.h"

#include <math.h>
#include <string.h>

/* Smaller |B| than that is as good as complete pivoting gives. */
static const double good_b = 2.0;
enum { MOST_PASSES = 4 };
/* The null vectors of the independent columns that aren't forced, by column of the matrix. Returns how many. */
static int list_null(km_partition *p, const bool *forced) {
  int count = 0;
  if (!km_arena_grow(p->sparse->arena, (void **)&p->sparse->null, &p->sparse->null_capacity,
                     (size_t)(p->columns - p->rank) * (size_t)p->columns, sizeof(double))) {
    p->failed = true;
    return 0;
  }
  for (int k = p->rank; k < p->columns; ++k) {
    if (km_sparse_is_given(p, forced, p->column[k]))
      continue;
    const double *b = p->B + (size_t)(k - p->rank) * (size_t)p->rank;
    double *n = p->sparse->null + (size_t)count++ * (size_t)p->columns;
    memset(n, 0, (size_t)p->columns * sizeof *n);
    for (int i = 0; i < p->rank; ++i)
      n[p->column[i]] = -b[i];
    n[p->column[k]] = 1.0;
  }
  return count;
}

/* The largest entry of null vector k, of those in columns that may still become independent ones. */
static void find_largest(const km_partition *p, const bool *forced, int k) {
  const km_sparse *s = p->sparse;
  const double *v = s->null + (size_t)k * (size_t)p->columns;
  int best = -1;
  for (int c = 0; c < p->columns; ++c)
    if ((best < 0 || fabs(v[c]) > fabs(v[best])) && !s->late[c] && !km_sparse_is_given(p, forced, c))
      best = c;
  s->largest[k] = best;
}

/* Of the null vectors from `first` on, that with the largest entry. */
static int vector_of_largest(const km_partition *p, int first, int count) {
  const km_sparse *s = p->sparse;
  size_t n = (size_t)p->columns;
  int best = first;
  for (int k = first + 1; k < count; ++k)
    if (fabs(s->null[(size_t)k * n + (size_t)s->largest[k]]) >
        fabs(s->null[(size_t)best * n + (size_t)s->largest[best]]))
      best = k;
  return best;
}

static void swap_vectors(const km_partition *p, int a, int b) {
  const km_sparse *s = p->sparse;
  double *x = s->null + (size_t)a * (size_t)p->columns, *y = s->null + (size_t)b * (size_t)p->columns;
  int column = s->largest[a];
  s->largest[a] = s->largest[b];
  s->largest[b] = column;
  for (int c = 0; c < p->columns; ++c) {
    double swap = x[c];
    x[c] = y[c];
    y[c] = swap;
  }
}

/* Takes what the later null vectors have in the pivot's column out of them by null vector `step`. Few have any where the
 * null vectors are local. */
static void subtract_from_later(const km_partition *p, const bool *forced, int step, int count) {
  const km_sparse *s = p->sparse;
  const double *own = s->null + (size_t)step * (size_t)p->columns;
  int pivot = s->largest[step];
  for (int k = step + 1; k < count; ++k) {
    double *v = s->null + (size_t)k * (size_t)p->columns, share = own[pivot] != 0.0 ? v[pivot] / own[pivot] : 0.0;
    for (int c = 0; c < p->columns && share != 0.0; ++c)
      v[c] -= share * own[c];
    if (share != 0.0 || s->largest[k] == pivot)
      find_largest(p, forced, k);
  }
}

/* Complete pivoting on N: the columns of the matrix that serve best as independent ones become late. Returns whether
 * they aren't those that are independent now. */
static bool choose_late(km_partition *p, const bool *forced) {
  km_sparse *s = p->sparse;
  int count = list_null(p, forced);
  bool changed = false;
  memset(s->late, 0, (size_t)p->columns * sizeof *s->late);
  for (int k = 0; k < count; ++k)
    find_largest(p, forced, k);
  for (int step = 0; step < count; ++step) {
    int vector = vector_of_largest(p, step, count);
    s->late[s->largest[vector]] = true;
    if (vector != step)
      swap_vectors(p, step, vector);
    subtract_from_later(p, forced, step, count);
  }
  for (int k = 0; k < p->rank; ++k)
    changed = changed || s->late[p->column[k]];
  return changed;
}

/* Columns with more entries than others are shared by several loops: with those independent, null vectors reach no further
 * than a loop and its neighbours. Returns whether they aren't those that are independent now. */
static bool leave_shared(km_partition *p) {
  km_sparse *s = p->sparse;
  bool changed = false;
  for (int c = 0; c < p->columns; ++c)
    s->late[c] = (s->start[c + 1] - s->start[c]) * p->columns > s->start[p->columns];
  for (int k = 0; k < p->rank; ++k)
    changed = changed || s->late[p->column[k]];
  return changed;
}

/* Of the independent columns that aren't forced. */
static double largest_free_b(const km_partition *p, const bool *forced) {
  double largest = 0.0;
  if (!forced && !p->locked)
    return p->largest_b;
  for (int k = p->rank; k < p->columns; ++k)
    for (int i = 0; i < p->rank && !km_sparse_is_given(p, forced, p->column[k]); ++i)
      largest = fmax(largest, fabs(p->B[(size_t)(k - p->rank) * (size_t)p->rank + (size_t)i]));
  return largest;
}

/* Until no column is dependent that no pivot tells. */
static void eliminate_all(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  int hidden = -1;
  do {
    if (hidden >= 0)
      p->sparse->late[hidden] = p->sparse->waits = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = p->failed ? -1 : km_sparse_hidden(p, forced, threshold);
  } while (hidden >= 0 && !p->sparse->late[hidden]);
}

/* The same of rows, and of no columns. */
static void eliminate_rows(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  int hidden = -1;
  bool looked = false;
  do {
    bool found = hidden >= 0 && !looked && km_sparse_spare_rows(p, matrix, forced, threshold);
    looked = hidden >= 0;
    if (hidden >= 0 && !found)
      p->sparse->spare[hidden] = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = p->failed ? -1 : km_sparse_hidden_row(p, matrix, forced, threshold);
  } while (hidden >= 0);
}

void km_sparse_factor(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  p->scale = km_largest_size(matrix, s->start[p->columns]);
  p->locked_count = 0;
  s->waits = false;
  p->largest_b = 0.0;
  for (int c = 0; c < p->columns; ++c)
    p->locked_count += km_sparse_is_locked(p, c);
  memset(s->late, 0, (size_t)p->columns * sizeof *s->late);
  memset(s->spare, 0, (size_t)p->rows * sizeof *s->spare);
  if (p->rows_only) {
    eliminate_rows(p, matrix, forced, tolerance * p->scale);
    return;
  }
  for (int pass = 0; pass < MOST_PASSES; ++pass) {
    eliminate_all(p, matrix, forced, tolerance * p->scale);
    if (p->any_independent)
      break;
    bool finite = km_sparse_find_b(p), first_of_many = pass == 0 && km_partition_freedom(p) > KM_MANY_VECTORS;
    if (finite && largest_free_b(p, forced) <= good_b)
      break;
    if (!(first_of_many && leave_shared(p)) && !(finite && choose_late(p, forced)))
      break;
  }
}
