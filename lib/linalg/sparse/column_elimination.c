/* LU of one column after the other, with what columns of one entry leave. */
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

/* Of the largest entry of the matrix: smaller pivots aren't taken unseen. */
static const double single_share = 0.01;
/* Of the largest entry of a column: smaller pivots can wait. */
static const double small_share = 0.01;
/* Of the largest entry of a column: as pivots such entries let others grow by little, and the row can be a short one. */
static const double large_share = 0.3;

/* All rows that column c of the matrix comes to hold when the steps so far are subtracted, into list[top … rows-1]:
 * each row behind those whose steps change it. */
static int reach(km_partition *p, int c) {
  km_sparse *s = p->sparse;
  int top = p->rows;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i) {
    if (s->visited[s->row[i]])
      continue;
    int depth = 0, first = s->step_of[s->row[i]];
    if (first < s->singleton_count) { /* a row without a pivot, or one that nothing is below */
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
      if (below && s->is_nested[step] && s->visited[p->row[step + 1]]) /* then its other rows are too */
        s->stack_position[depth] = below->end;
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

static void scatter(const km_partition *p, const double *matrix, int c) {
  const km_sparse *s = p->sparse;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    s->x[s->row[i]] = matrix[i];
}

static int row_size(const km_sparse *s, int row) {
  return s->row_start[row + 1] - s->row_start[row];
}

/* Of the rows with a large entry that may be primary ones, that with the fewest entries in the matrix; -1: all are 0. */
static int choose_row(const km_sparse *s, const km_entry_range *rows, double largest) {
  int best = -1;
  for (int i = rows->start; i < rows->end && largest > 0.0; ++i) {
    int row = s->lower_store.index[i];
    if (fabs(s->x[row]) < large_share * largest || s->is_excluded_row[row])
      continue;
    bool shorter = best < 0 || row_size(s, row) < row_size(s, best);
    if (shorter || (row_size(s, row) == row_size(s, best) && fabs(s->x[row]) > fabs(s->x[best])))
      best = row;
  }
  return best;
}

/* Takes a step out of the column, whose entry there goes to U. */
static void take_step(km_partition *p, int step, int *upper_end) {
  km_sparse *s = p->sparse;
  double value = s->x[p->row[step]];
  s->upper_store.index[*upper_end] = step;
  s->upper_store.value[(*upper_end)++] = value;
  km_sparse_subtract(s, &s->lower[p->column[step]], value);
  s->x[p->row[step]] = 0.0;
}

/* The same of steps that go together. */
static void take_steps(km_partition *p, int step, int *upper_end) {
  km_sparse *s = p->sparse;
  for (int n = 0; n < KM_SUPERNODE_WIDTH; ++n)
    s->upper_store.index[*upper_end + n] = step + n;
  km_sparse_supernode_subtract(p, step, s->upper_store.value + *upper_end);
  *upper_end += KM_SUPERNODE_WIDTH;
}

/* Reduces column c by the steps so far: its part in U is stored, the rest stays in x. Returns the row of the pivot, -1
 * if nothing is left. */
static int reduce(km_partition *p, const double *matrix, int c, int *upper_end, int *lower_end) {
  km_sparse *s = p->sparse;
  int top = reach(p, c);
  double largest = 0.0;
  s->upper[c] = (km_entry_range){*upper_end, *upper_end};
  s->lower[c] = (km_entry_range){*lower_end, *lower_end};
  if (!km_sparse_reserve_factor(s, *upper_end + p->rows - top, *lower_end + p->rows - top)) {
    for (int i = top; i < p->rows; ++i)
      s->visited[s->reach_list[i]] = false;
    p->failed = true;
    return -1;
  }
  scatter(p, matrix, c);
  for (int i = top; i < p->rows; ++i)
    s->visited[s->reach_list[i]] = false;
  for (int i = top; i < p->rows; ++i) {
    int row = s->reach_list[i], step = s->step_of[row];
    if (km_sparse_supernode_follows(p, s->reach_list + i, p->rows - i)) {
      take_steps(p, step, upper_end);
      i += KM_SUPERNODE_WIDTH - 1;
    } else if (step >= 0) {
      take_step(p, step, upper_end);
    } else {
      s->lower_store.index[(*lower_end)++] = row;
      largest = fabs(s->x[row]) > largest && !s->is_excluded_row[row] ? fabs(s->x[row]) : largest;
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
  km_sparse_extend_supernode(p, step);
}

static void drop(km_partition *p, int c) {
  km_sparse *s = p->sparse;
  for (int i = s->lower[c].start; i < s->lower[c].end; ++i)
    s->x[s->lower_store.index[i]] = 0.0;
}

enum { GROUPS = 4 };

static int group_of(const km_partition *p, const bool *forced, int c) {
  return km_sparse_is_locked(p, c) ? 3 : km_sparse_is_preset(p, forced, c) ? 2 : p->sparse->is_postponed[c] ? 1 : 0;
}

/* Behind the single columns: those that shall stay independent behind the others, then the forced ones, then the locked ones.
 * Returns where the first of these begin. */
static int arrange(km_partition *p, const bool *forced) {
  km_sparse *s = p->sparse;
  int next[GROUPS] = {s->singleton_count, 0, 0, 0}, *const rest = s->dropped, count = 0;
  for (int i = 0; i < p->columns; ++i)
    if (s->open_entries[s->order[i]].count >= 0)
      rest[count++] = s->order[i];
  for (int i = 0; i < count; ++i)
    if (group_of(p, forced, rest[i]) + 1 < GROUPS)
      next[group_of(p, forced, rest[i]) + 1]++;
  for (int group = 1; group < GROUPS; ++group)
    next[group] += next[group - 1];
  for (int i = 0; i < count; ++i)
    s->factor_order[next[group_of(p, forced, rest[i])]++] = rest[i];
  return next[0];
}

/* Is the pivot small beside what the column had? */
static bool is_small(const km_sparse *s, const double *matrix, int c, double size) {
  double largest = 0.0;
  for (int i = s->start[c]; i < s->start[c + 1]; ++i)
    largest = fabs(matrix[i]) > largest ? fabs(matrix[i]) : largest;
  return size < small_share * largest;
}

/* The column at place i becomes the last one before `end`. */
static void put_off(km_sparse *s, int i, int end) {
  int c = s->factor_order[i];
  memmove(s->factor_order + i, s->factor_order + i + 1, (size_t)(end - 1 - i) * sizeof *s->factor_order);
  s->factor_order[end - 1] = c;
  s->is_postponed[c] = true;
}

/* Rows that are no primary constraints leave L: nothing asks for them, and new values for the same pivots needn't be
 * found for them. */
static void keep_primary(km_partition *p) {
  km_sparse *s = p->sparse;
  int kept = 0; /* of single columns, which have nothing in L */
  for (int i = s->singleton_count; i < p->columns; ++i) {
    km_entry_range *run = &s->lower[s->factor_order[i]];
    int start = kept;
    for (int k = run->start; k < run->end; ++k)
      if (s->step_of[s->lower_store.index[k]] >= 0) {
        s->lower_store.index[kept] = s->lower_store.index[k];
        s->lower_store.value[kept++] = s->lower_store.value[k];
      }
    *run = (km_entry_range){start, kept};
  }
}

/* The independent columns, before they are reduced: nothing above them yet. */
static void clear_dropped(const km_partition *p, int count) {
  const km_sparse *s = p->sparse;
  for (int i = 0; i < count; ++i)
    s->upper[s->dropped[i]] = s->lower[s->dropped[i]] = (km_entry_range){0, 0};
}

/* The independent columns once more, now by all steps: those that came later have next to nothing of them at these values,
 * but may have at the next ones by the same pivots. */
static void reduce_dropped(km_partition *p, const double *matrix, const int *dropped, int count, int upper_end,
                           int lower_end) {
  for (int i = 0; i < count; ++i) {
    reduce(p, matrix, dropped[i], &upper_end, &lower_end);
    drop(p, dropped[i]);
  }
}

bool km_sparse_refactor_full_pattern(km_partition *p, const double *matrix) {
  km_sparse *s = p->sparse;
  const int rank = p->rank;
  int upper_end = 0, lower_end = 0;
  bool good = true;
  s->singleton_count = s->singleton_zero_count = 0;
  p->rank = 0;
  km_sparse_reset_supernodes(p);
  for (int r = 0; r < p->rows; ++r)
    s->step_of[r] = -1;
  memcpy(s->factor_order, p->column, (size_t)p->columns * sizeof *s->factor_order);
  for (int k = 0; k < rank && good; ++k) {
    int c = p->column[k], row = p->row[k];
    reduce(p, matrix, c, &upper_end, &lower_end);
    good = !p->failed && s->x[row] != 0.0;
    if (good)
      use(p, c, row);
    else
      drop(p, c);
    lower_end = s->lower[c].end;
  }
  p->rank = rank;
  if (!good)
    return false;
  if (!s->has_rows_only)
    reduce_dropped(p, matrix, p->column + rank, p->columns - rank, upper_end, lower_end);
  keep_primary(p);
  return !p->failed;
}

void km_sparse_eliminate(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  km_sparse *s = p->sparse;
  int lower_end = 0, dropped = 0;
  p->rank = 0;
  p->first_pivot = p->first_dropped = 0.0;
  p->smallest_pivot = HUGE_VAL;
  p->forced_dependent = false;
  km_sparse_reset_supernodes(p);
  for (int r = 0; r < p->rows; ++r)
    s->step_of[r] = -1;
  int upper_end = km_sparse_take_singletons(p, matrix, forced, fmax(threshold, single_share * p->scale));
  int early = arrange(p, forced);
  s->is_overfull = false;
  for (int i = s->singleton_count; i < p->columns; ++i) {
    int c = s->factor_order[i];
    s->is_overfull = (s->postpones_small || !s->limits_fill_if_postponing) && s->max_entries > 0 &&
                     upper_end + lower_end > s->max_entries;
    if (s->is_overfull)
      return;
    if (p->rank == p->rows) { /* nothing can be left of it */
      s->dropped[dropped++] = c;
      continue;
    }
    int row = reduce(p, matrix, c, &upper_end, &lower_end);
    double size = row < 0 ? 0.0 : fabs(s->x[row]);
    if (s->postpones_small && i < early && !s->is_postponed[c] && is_small(s, matrix, c, size)) {
      drop(p, c);
      upper_end = s->upper[c].start;
      lower_end = s->lower[c].start;
      put_off(s, i--, early);
      continue;
    }
    if (size > threshold && !(p->forced_never_pivot && forced && forced[c])) {
      use(p, c, row);
      lower_end = s->lower[c].end;
      p->forced_dependent = p->forced_dependent || (forced && forced[c]);
      km_sparse_update_pivot_range(p, size);
    } else {
      drop(p, c);
      upper_end = s->upper[c].start;
      lower_end = s->lower[c].start;
      s->dropped[dropped++] = c;
      p->first_dropped = size > p->first_dropped ? size : p->first_dropped;
    }
  }
  clear_dropped(p, dropped);
  if (!s->has_rows_only)
    reduce_dropped(p, matrix, s->dropped, dropped, upper_end, lower_end);
  memcpy(p->column + p->rank, s->dropped, (size_t)dropped * sizeof *p->column);
  p->last_pivot = p->rank ? p->smallest_pivot : 0.0;
  keep_primary(p);
}
