/* Sparse LU column by column (Gilbert and Peierls 1988; docs/theory.md 3.6), after the column singletons.
 *
 *   reach : rows that column c reaches in the graph of L (depth-first search)
 *   reduce: x <- x − L_:k u_k  for each reached step k in topological order;  u: entries of U
 *   accept: the rest of x over the pivot is the column of L */
#include "base/number/tolerances.h"
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

/* Threshold pivoting, relative to the largest entry of a column: such pivots let entries grow little, and leave a
 * choice of a short row. */
static const double threshold_ratio = 0.3;

/* Symbolic step: rows that column c reaches in the graph of L, by depth-first search, in topological order, into
 * reach_list[top … rows-1]. Returns top. */
static int find_reach(km_factor *p, int c) {
  km_sparse *s = p->sparse;
  int top = p->rows;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i) {
    if (s->visited[s->row[i]])
      continue;
    int depth = 0, first = s->step_of[s->row[i]];
    if (first < s->singleton_count) { /* a row without a pivot, or of a singleton, whose column of L is empty */
      s->visited[s->row[i]] = true;
      s->reach_list[--top] = s->row[i];
      continue;
    }
    s->stack[0] = s->row[i];
    s->stack_position[0] = -1;
    while (depth >= 0) {
      int row = s->stack[depth], step = s->step_of[row];
      const km_entry_range *below = step < 0 ? NULL : &s->lower[p->column[step]];
      if (s->stack_position[depth] < 0) {
        s->visited[row] = true;
        s->stack_position[depth] = below ? below->start : 0;
      }
      while (below && s->stack_position[depth] < below->end &&
             s->visited[s->lower_store.index[s->stack_position[depth]]])
        s->stack_position[depth]++;
      if (below && s->stack_position[depth] < below->end) {
        int child = s->lower_store.index[s->stack_position[depth]++];
        s->stack[++depth] = child;
        s->stack_position[depth] = -1;
      } else {
        s->reach_list[--top] = row;
        --depth;
      }
    }
  }
  return top;
}

static void scatter_column(const km_factor *p, const double *matrix, int c) {
  const km_sparse *s = p->sparse;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    s->x[s->row[i]] = matrix[i];
}

static int row_entry_count(const km_sparse *s, int row) {
  return s->row_start[row + 1] - s->row_start[row];
}

/* Threshold pivoting: of the allowed rows with an entry of at least 0.3 of the largest, the one with the fewest entries
 * in the matrix; -1: all are 0. */
static int choose_pivot_row(const km_sparse *s, const km_entry_range *rows, double largest) {
  int best = -1;
  for (int i = rows->start; i < rows->end && largest > 0.0; ++i) {
    int row = s->lower_store.index[i];
    if (fabs(s->x[row]) < threshold_ratio * largest || s->is_excluded_row[row])
      continue;
    bool shorter = best < 0 || row_entry_count(s, row) < row_entry_count(s, best);
    if (shorter || (row_entry_count(s, row) == row_entry_count(s, best) && fabs(s->x[row]) > fabs(s->x[best])))
      best = row;
  }
  return best;
}

/* Applies a step: x <- x − L_:k u_k; u_k is appended to U. */
static void apply_step(km_factor *p, int step, int *upper_end) {
  km_sparse *s = p->sparse;
  double value = s->x[p->row[step]];
  s->upper_store.index[*upper_end] = step;
  s->upper_store.value[(*upper_end)++] = value;
  km_sparse_subtract(s, &s->lower[p->column[step]], value);
  s->x[p->row[step]] = 0.0;
}

/* Reduces column c by the steps so far: u is stored in U, the rest stays in x. Returns the pivot row, -1 if nothing is
 * left. */
static int reduce_column(km_factor *p, const double *matrix, int c, int *upper_end, int *lower_end) {
  km_sparse *s = p->sparse;
  int top = find_reach(p, c);
  double largest = 0.0;
  s->upper[c] = (km_entry_range){*upper_end, *upper_end};
  s->lower[c] = (km_entry_range){*lower_end, *lower_end};
  if (!km_sparse_reserve_factor(s, *upper_end + p->rows - top, *lower_end + p->rows - top)) {
    for (int i = top; i < p->rows; ++i)
      s->visited[s->reach_list[i]] = false;
    p->failed = true;
    return -1;
  }
  scatter_column(p, matrix, c);
  for (int i = top; i < p->rows; ++i)
    s->visited[s->reach_list[i]] = false;
  for (int i = top; i < p->rows; ++i) {
    int row = s->reach_list[i], step = s->step_of[row];
    if (step >= 0) {
      apply_step(p, step, upper_end);
    } else {
      s->lower_store.index[(*lower_end)++] = row;
      largest = fabs(s->x[row]) > largest && !s->is_excluded_row[row] ? fabs(s->x[row]) : largest;
    }
  }
  s->upper[c].end = *upper_end;
  s->lower[c].end = *lower_end;
  return choose_pivot_row(s, &s->lower[c], largest);
}

/* Accepts the reduced column c as the next step with the pivot in `row`: column of L over the pivot. */
static void accept_pivot(km_factor *p, int c, int row) {
  km_sparse *s = p->sparse;
  int step = p->rank++, next_free = s->lower[c].start;
  p->row[step] = row;
  p->column[step] = c;
  p->inverse[step] = 1.0 / s->x[row];
  s->step_of[row] = step;
  for (int i = s->lower[c].start; i < s->lower[c].end; ++i) {
    int r = s->lower_store.index[i];
    if (r == row)
      continue;
    s->lower_store.index[next_free] = r;
    s->lower_store.value[next_free++] = s->x[r] * p->inverse[step];
    s->x[r] = 0.0;
  }
  s->x[row] = 0.0;
  s->lower[c].end = next_free;
}

/* Clears the accumulator of a column that becomes no step. */
static void clear_column(km_factor *p, int c) {
  km_sparse *s = p->sparse;
  for (int i = s->lower[c].start; i < s->lower[c].end; ++i)
    s->x[s->lower_store.index[i]] = 0.0;
}

enum { GROUPS = 4 };

static int column_group(const km_factor *p, const bool *forced, int c) {
  return km_factor_is_locked(p, c) ? 3 : km_sparse_is_preset(p, forced, c) ? 2 : p->sparse->is_postponed[c] ? 1 : 0;
}

/* Column order after the singletons: ordinary, postponed, forced, locked. Returns the index of the first postponed
 * one. */
static int order_columns(km_factor *p, const bool *forced) {
  km_sparse *s = p->sparse;
  int next[GROUPS] = {s->singleton_count, 0, 0, 0}, *const rest = s->dropped, count = 0;
  for (int i = 0; i < p->columns; ++i)
    if (s->open_entries[s->order[i]].count >= 0)
      rest[count++] = s->order[i];
  for (int i = 0; i < count; ++i)
    if (column_group(p, forced, rest[i]) + 1 < GROUPS)
      next[column_group(p, forced, rest[i]) + 1]++;
  for (int group = 1; group < GROUPS; ++group)
    next[group] += next[group - 1];
  for (int i = 0; i < count; ++i)
    s->factor_order[next[column_group(p, forced, rest[i])]++] = rest[i];
  return next[0];
}

/* True if the pivot is below 0.01 of the column's largest entry. */
static bool is_small_pivot(const km_sparse *s, const double *matrix, int c, double size) {
  double largest = 0.0;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    largest = fabs(matrix[i]) > largest ? fabs(matrix[i]) : largest;
  return km_significant_ratio * size < largest;
}

/* Postpones the column at index i to the last one before `end`. */
static void postpone_column(km_sparse *s, int i, int end) {
  int c = s->factor_order[i];
  memmove(s->factor_order + i, s->factor_order + i + 1, (size_t)(end - 1 - i) * sizeof *s->factor_order);
  s->factor_order[end - 1] = c;
  s->is_postponed[c] = true;
}

/* Removes secondary rows from L: they are not read, and refactorisations need not compute them. */
static void remove_secondary_rows(km_factor *p) {
  km_sparse *s = p->sparse;
  int next_free = 0; /* singletons have no entries of L */
  for (int i = s->singleton_count; i < p->columns; ++i) {
    km_entry_range *run = &s->lower[s->factor_order[i]];
    int start = next_free;
    for (int k = run->start; k < run->end; ++k)
      if (s->step_of[s->lower_store.index[k]] >= 0) {
        s->lower_store.index[next_free] = s->lower_store.index[k];
        s->lower_store.value[next_free++] = s->lower_store.value[k];
      }
    *run = (km_entry_range){start, next_free};
  }
}

/* Clears the entries of U and L of the independent columns. */
static void clear_independent(const km_factor *p, int count) {
  const km_sparse *s = p->sparse;
  for (int i = 0; i < count; ++i)
    s->upper[s->dropped[i]] = s->lower[s->dropped[i]] = (km_entry_range){0, 0};
}

/* Reduces the independent columns by all steps. Later steps contribute only rounding at these values, but can
 * contribute at the next values with these pivots. */
static void reduce_independent(km_factor *p, const double *matrix, const int *dropped, int count, int upper_end,
                               int lower_end) {
  for (int i = 0; i < count; ++i) {
    reduce_column(p, matrix, dropped[i], &upper_end, &lower_end);
    clear_column(p, dropped[i]);
  }
}

/* Repeats the elimination with known pivots, symbolic steps included. */
bool km_sparse_refactor_full_pattern(km_factor *p, const double *matrix) {
  km_sparse *s = p->sparse;
  const int rank = p->rank;
  int upper_end = 0, lower_end = 0;
  bool is_ok = true;
  s->singleton_count = s->singleton_zero_count = 0;
  p->rank = 0;
  for (int r = 0; r < p->rows; ++r)
    s->step_of[r] = -1;
  memcpy(s->factor_order, p->column, (size_t)p->columns * sizeof *s->factor_order);
  for (int k = 0; k < rank && is_ok; ++k) {
    int c = p->column[k], row = p->row[k];
    reduce_column(p, matrix, c, &upper_end, &lower_end);
    is_ok = !p->failed && s->x[row] != 0.0;
    if (is_ok)
      accept_pivot(p, c, row);
    else
      clear_column(p, c);
    lower_end = s->lower[c].end;
  }
  p->rank = rank;
  if (!is_ok)
    return false;
  if (!s->has_rows_only)
    reduce_independent(p, matrix, p->column + rank, p->columns - rank, upper_end, lower_end);
  remove_secondary_rows(p);
  return !p->failed;
}

/* One LU elimination by columns with threshold pivoting; small pivots are postponed or dropped. */
void km_sparse_eliminate(km_factor *p, const double *matrix, const bool *forced, double threshold) {
  km_sparse *s = p->sparse;
  int lower_end = 0, dropped = 0;
  p->rank = 0;
  p->first_pivot = p->first_dropped = 0.0;
  p->smallest_pivot = HUGE_VAL;
  p->forced_dependent = false;
  for (int r = 0; r < p->rows; ++r)
    s->step_of[r] = -1;
  int upper_end = km_sparse_take_singletons(p, matrix, forced, fmax(threshold, p->scale / km_significant_ratio));
  int first_postponed = order_columns(p, forced);
  s->is_overfull = false;
  for (int i = s->singleton_count; i < p->columns; ++i) {
    int c = s->factor_order[i];
    s->is_overfull = (s->postpones_small || !s->limits_fill_if_postponing) && s->max_entries > 0 &&
                     upper_end + lower_end > s->max_entries;
    if (s->is_overfull)
      return;
    if (p->rank == p->rows) { /* the rank is full: nothing remains of the column */
      s->dropped[dropped++] = c;
      continue;
    }
    int row = reduce_column(p, matrix, c, &upper_end, &lower_end);
    double size = row < 0 ? 0.0 : fabs(s->x[row]);
    if (s->postpones_small && i < first_postponed && !s->is_postponed[c] && is_small_pivot(s, matrix, c, size)) {
      clear_column(p, c);
      upper_end = s->upper[c].start;
      lower_end = s->lower[c].start;
      postpone_column(s, i--, first_postponed);
      continue;
    }
    if (size > threshold && !(p->options.forced_never_pivot && forced && forced[c])) {
      accept_pivot(p, c, row);
      lower_end = s->lower[c].end;
      p->forced_dependent = p->forced_dependent || (forced && forced[c]);
      km_sparse_update_pivot_range(p, size);
    } else {
      clear_column(p, c);
      upper_end = s->upper[c].start;
      lower_end = s->lower[c].start;
      s->dropped[dropped++] = c;
      p->first_dropped = size > p->first_dropped ? size : p->first_dropped;
    }
  }
  clear_independent(p, dropped);
  if (!s->has_rows_only)
    reduce_independent(p, matrix, s->dropped, dropped, upper_end, lower_end);
  memcpy(p->column + p->rank, s->dropped, (size_t)dropped * sizeof *p->column);
  p->last_pivot = p->rank ? p->smallest_pivot : 0.0;
  remove_secondary_rows(p);
}
