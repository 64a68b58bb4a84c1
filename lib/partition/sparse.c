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

/* Complete pivoting on N: the columns of the matrix that serve best as independent ones become late. Returns whether
 * they aren't those that are independent now. */
static bool choose_late(km_partition *p, const bool *forced) {
  km_sparse *s = p->sparse;
  int count = list_null(p, forced), n = p->columns;
  bool changed = false;
  memset(s->late, 0, (size_t)n * sizeof *s->late);
  for (int step = 0; step < count; ++step) {
    int best = -1, vector = step;
    for (int k = step; k < count; ++k)
      for (int c = 0; c < n; ++c) {
        double size = fabs(s->null[(size_t)k * (size_t)n + (size_t)c]);
        if (!s->late[c] && !km_sparse_is_given(p, forced, c) &&
            (best < 0 || size > fabs(s->null[(size_t)vector * (size_t)n + (size_t)best]))) {
          best = c;
          vector = k;
        }
      }
    double *own = s->null + (size_t)step * (size_t)n, *other = s->null + (size_t)vector * (size_t)n;
    s->late[best] = true;
    for (int c = 0; c < n && vector != step; ++c) {
      double swap = own[c];
      own[c] = other[c];
      other[c] = swap;
    }
    for (int k = step + 1; k < count && own[best] != 0.0; ++k) {
      double *v = s->null + (size_t)k * (size_t)n, share = v[best] / own[best];
      for (int c = 0; c < n; ++c)
        v[c] -= share * own[c];
    }
  }
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
      p->sparse->late[hidden] = true;
    km_sparse_eliminate(p, matrix, forced, threshold);
    hidden = p->failed ? -1 : km_sparse_hidden(p, forced, threshold);
  } while (hidden >= 0 && !p->sparse->late[hidden]);
}

void km_sparse_factor(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  p->scale = km_largest_size(matrix, s->start[p->columns]);
  p->locked_count = 0;
  p->largest_b = 0.0;
  for (int c = 0; c < p->columns; ++c)
    p->locked_count += km_sparse_is_locked(p, c);
  memset(s->late, 0, (size_t)p->columns * sizeof *s->late);
  for (int pass = 0; pass < MOST_PASSES; ++pass) {
    eliminate_all(p, matrix, forced, tolerance * p->scale);
    if (p->any_independent || !km_sparse_find_b(p) || largest_free_b(p, forced) <= good_b || !choose_late(p, forced))
      break;
  }
}
