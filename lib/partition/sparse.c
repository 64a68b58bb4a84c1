/* The sparse engine: LU by columns with COLAMD's order, rank by what is left. */
#include "partition/sparse.h"

#include <math.h>
#include <string.h>

/* Smaller |B| than that is as good as complete pivoting gives. */
static const double good_b = 2.0;
enum { MOST_PASSES = 4 };
/* Of the largest entry of a column: as pivots such entries let others grow by little, and the row can be a short one. */
static const double large_share = 0.3;

/* All rows that column c of the matrix comes to hold when the steps so far are subtracted, into list[top … rows-1]:
 * each row behind those whose steps change it. */
static int reach(km_partition *p, int c) {
  km_sparse *s = p->sparse;
  int top = p->rows;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i) {
    if (s->seen[s->row[i]])
      continue;
    int depth = 0;
    s->stack[0] = s->row[i];
    s->next[0] = -1;
    while (depth >= 0) {
      int row = s->stack[depth], step = s->step_of[row];
      const km_run *below = step < 0 ? NULL : &s->lower[p->column[step]];
      if (s->next[depth] < 0) {
        s->seen[row] = true;
        s->next[depth] = below ? below->start : 0;
      }
      while (below && s->next[depth] < below->end && s->seen[s->lower_store.index[s->next[depth]]])
        s->next[depth]++;
      if (below && s->next[depth] < below->end) {
        int child = s->lower_store.index[s->next[depth]++];
        s->stack[++depth] = child;
        s->next[depth] = -1;
      } else {
        s->list[--top] = row;
        --depth;
      }
    }
  }
  return top;
}

static void scatter(const km_partition *p, const double *matrix, int c) {
  const km_sparse *s = p->sparse;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    s->x[s->row[i]] = matrix[i];
}

/* The entries in primary rows only. */
static void scatter_primary(const km_partition *p, const double *matrix, int c) {
  const km_sparse *s = p->sparse;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    if (s->step_of[s->row[i]] >= 0)
      s->x[s->row[i]] = matrix[i];
}

static bool is_finite(const km_partition *p, const double *matrix) {
  const km_sparse *s = p->sparse;
  double poison = 0.0; /* sum of x − x: 0, or not a number */
  for (int i = 0; i < s->start[p->columns]; ++i)
    poison += matrix[i] - matrix[i];
  return poison == 0.0;
}

/* Subtracts a step from the accumulators. */
static void subtract(const km_partition *p, int step, double u) {
  const km_sparse *s = p->sparse;
  const km_run *below = &s->lower[p->column[step]];
  for (int i = below->start; i < below->end; ++i)
    s->x[s->lower_store.index[i]] -= s->lower_store.value[i] * u;
}

/* Room for `more` entries behind those of L and U. */
static bool make_room(km_sparse *s, int upper_end, int lower_end, int more) {
  km_store *stores[2] = {&s->upper_store, &s->lower_store};
  size_t need[2] = {(size_t)(upper_end + more), (size_t)(lower_end + more)};
  for (int i = 0; i < 2; ++i) {
    size_t values = stores[i]->capacity; /* both arrays of a store grow together */
    if (!km_arena_grow(s->arena, (void **)&stores[i]->value, &values, need[i], sizeof(double)) ||
        !km_arena_grow(s->arena, (void **)&stores[i]->index, &stores[i]->capacity, need[i], sizeof(int)))
      return false;
  }
  return true;
}

/* Of the rows with a large entry, that with the fewest entries in the matrix; -1: all are 0. */
static int choose_row(const km_sparse *s, const km_run *rows, double largest) {
  int best = -1;
  for (int i = rows->start; i < rows->end && largest > 0.0; ++i) {
    int row = s->lower_store.index[i];
    if (fabs(s->x[row]) < large_share * largest)
      continue;
    bool shorter = best < 0 || s->row_size[row] < s->row_size[best];
    if (shorter || (s->row_size[row] == s->row_size[best] && fabs(s->x[row]) > fabs(s->x[best])))
      best = row;
  }
  return best;
}

/* Reduces column c by the steps so far: its part in U is stored, the rest stays in x. Returns the row of the pivot, -1
 * if nothing is left. */
static int reduce(km_partition *p, const double *matrix, int c, int *upper_end, int *lower_end) {
  km_sparse *s = p->sparse;
  int top = reach(p, c);
  double largest = 0.0;
  s->upper[c] = (km_run){*upper_end, *upper_end};
  s->lower[c] = (km_run){*lower_end, *lower_end};
  if (!make_room(s, *upper_end, *lower_end, p->rows - top)) {
    for (int i = top; i < p->rows; ++i)
      s->seen[s->list[i]] = false;
    p->failed = true;
    return -1;
  }
  scatter(p, matrix, c);
  for (int i = top; i < p->rows; ++i) {
    int row = s->list[i], step = s->step_of[row];
    s->seen[row] = false;
    if (step >= 0) {
      s->upper_store.index[*upper_end] = step;
      s->upper_store.value[(*upper_end)++] = s->x[row];
      subtract(p, step, s->x[row]);
      s->x[row] = 0.0;
    } else {
      s->lower_store.index[(*lower_end)++] = row;
      largest = fmax(largest, fabs(s->x[row]));
    }
  }
  s->upper[c].end = *upper_end;
  s->lower[c].end = *lower_end;
  return choose_row(s, &s->lower[c], largest);
}

/* Column c, reduced in x, becomes the next step with a pivot in `row`. */
static void use(km_partition *p, int c, int row) {
  km_sparse *s = p->sparse;
  int step = p->rank++, kept = s->lower[c].start;
  p->row[step] = row;
  p->column[step] = c;
  p->inverse[step] = 1.0 / s->x[row];
  s->step_of[row] = step;
  for (int i = s->lower[c].start; i < s->lower[c].end; ++i) {
    int r = s->lower_store.index[i];
    if (r == row)
      continue;
    s->lower_store.index[kept] = r;
    s->lower_store.value[kept++] = s->x[r] * p->inverse[step];
    s->x[r] = 0.0;
  }
  s->x[row] = 0.0;
  s->lower[c].end = kept;
}

static void drop(km_partition *p, int c) {
  km_sparse *s = p->sparse;
  for (int i = s->lower[c].start; i < s->lower[c].end; ++i)
    s->x[s->lower_store.index[i]] = 0.0;
}

/* Those that shall stay independent behind the others, then the forced ones, then the locked ones. */
static void arrange(km_partition *p, const bool *forced) {
  km_sparse *s = p->sparse;
  int n = 0;
  for (int group = 0; group < 4; ++group)
    for (int i = 0; i < p->columns; ++i) {
      int c = s->order[i];
      if (group == (km_sparse_is_locked(p, c) ? 3 : km_sparse_is_given(p, forced, c) ? 2 : s->late[c] ? 1 : 0))
        s->lead[n++] = c;
    }
}

/* Rows that are no primary constraints leave L: nothing asks for them, and new values for the same pivots needn't be
 * found for them. */
static void keep_primary(km_partition *p) {
  km_sparse *s = p->sparse;
  int kept = 0;
  for (int i = 0; i < p->columns; ++i) {
    km_run *run = &s->lower[s->lead[i]];
    int start = kept;
    for (int k = run->start; k < run->end; ++k)
      if (s->step_of[s->lower_store.index[k]] >= 0) {
        s->lower_store.index[kept] = s->lower_store.index[k];
        s->lower_store.value[kept++] = s->lower_store.value[k];
      }
    *run = (km_run){start, kept};
  }
}

static void eliminate(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  km_sparse *s = p->sparse;
  int upper_end = 0, lower_end = 0, dropped = 0;
  p->rank = 0;
  p->first_pivot = p->first_dropped = 0.0;
  p->smallest_pivot = HUGE_VAL;
  p->forced_dependent = false;
  for (int r = 0; r < p->rows; ++r)
    s->step_of[r] = -1;
  for (int i = 0; i < p->columns; ++i) {
    int c = s->lead[i], row = reduce(p, matrix, c, &upper_end, &lower_end);
    double size = row < 0 ? 0.0 : fabs(s->x[row]);
    if (size > threshold && !(p->held && forced && forced[c])) {
      use(p, c, row);
      lower_end = s->lower[c].end;
      p->forced_dependent = p->forced_dependent || (forced && forced[c]);
      p->first_pivot = fmax(p->first_pivot, size);
      p->smallest_pivot = fmin(p->smallest_pivot, size);
    } else {
      drop(p, c);
      s->dropped[dropped++] = c;
      p->first_dropped = fmax(p->first_dropped, size);
    }
  }
  memcpy(p->column + p->rank, s->dropped, (size_t)dropped * sizeof *p->column);
  p->last_pivot = p->rank ? p->smallest_pivot : 0.0;
  keep_primary(p);
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

/* The columns of B. False where a value is not finite. */
static bool find_b(km_partition *p) {
  km_sparse *s = p->sparse;
  double sum = 0.0;
  bool negative = false;
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
    for (int i = 0; i < p->rank; ++i) {
      p->largest_b = fmax(p->largest_b, fabs(b[i]));
      sum += b[i];
    }
  }
  p->sign = negative ? -1 : 1;
  return isfinite(sum);
}

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
    arrange(p, forced);
    eliminate(p, matrix, forced, threshold);
    hidden = p->failed ? -1 : km_sparse_hidden(p, forced, threshold);
  } while (hidden >= 0 && !p->sparse->late[hidden]);
}

void km_sparse_factor(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  p->scale = 0.0;
  p->locked_count = 0;
  for (int c = 0; c < p->columns; ++c)
    p->locked_count += km_sparse_is_locked(p, c);
  for (int i = 0; i < s->start[p->columns]; ++i)
    p->scale = fmax(p->scale, fabs(matrix[i]));
  memset(s->late, 0, (size_t)p->columns * sizeof *s->late);
  for (int pass = 0; pass < MOST_PASSES; ++pass) {
    eliminate_all(p, matrix, forced, tolerance * p->scale);
    if (!find_b(p) || p->any_independent || largest_free_b(p, forced) <= good_b || !choose_late(p, forced))
      break;
  }
}

bool km_sparse_refactor(km_partition *p, const double *matrix) {
  km_sparse *s = p->sparse;
  if (p->failed || !is_finite(p, matrix))
    return false;
  for (int k = 0; k < p->columns; ++k) {
    int c = p->column[k];
    scatter_primary(p, matrix, c);
    for (int i = s->upper[c].start; i < s->upper[c].end; ++i) {
      int step = s->upper_store.index[i], row = p->row[step];
      s->upper_store.value[i] = s->x[row];
      s->x[row] = 0.0;
      subtract(p, step, s->upper_store.value[i]);
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
  return find_b(p);
}

void km_sparse_solve(const km_partition *p, const double *rhs, double *x) {
  const km_sparse *s = p->sparse;
  double *y = p->work;
  memcpy(s->x, rhs, (size_t)p->rows * sizeof *s->x);
  for (int k = 0; k < p->rank; ++k) {
    y[k] = s->x[p->row[k]];
    if (y[k] != 0.0)
      subtract(p, k, y[k]);
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
  memcpy(t->step_of, f->step_of, (size_t)from->rows * sizeof *t->step_of);
  to->failed = from->failed || !make_room(t, upper, lower, 0);
  if (to->failed)
    return;
  memcpy(t->upper_store.index, f->upper_store.index, (size_t)upper * sizeof *t->upper_store.index);
  memcpy(t->lower_store.index, f->lower_store.index, (size_t)lower * sizeof *t->lower_store.index);
}
