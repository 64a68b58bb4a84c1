/* Lists of the operations of an elimination whose pivots are known. */
#include "partition/replay.h"

#include <string.h>

bool km_replay_reserve(km_replay *r, int rows, int columns, km_arena *arena) {
  size_t m = (size_t)rows, n = (size_t)columns, steps = m < n ? m : n;
  *r = (km_replay){.row_count = rows, .column_count = columns};
  r->steps = KM_ARENA_NEW(arena, km_replay_step, steps);
  r->rows = KM_ARENA_NEW(arena, int, steps *m);
  r->columns = KM_ARENA_NEW(arena, int, steps *n);
  r->fill = KM_ARENA_NEW(arena, int, m *n);
  r->row = KM_ARENA_NEW(arena, int, m);
  r->column = KM_ARENA_NEW(arena, int, n);
  r->reduced = KM_ARENA_NEW(arena, bool, m *n);
  return !arena->failed;
}

static void list_targets(km_replay *r, km_replay_step *step, const bool *column, int *count) {
  step->target_start = *count;
  for (int i = 0; i < r->row_count; ++i)
    if (i != step->row && column[i])
      r->rows[(*count)++] = i;
  step->target_count = *count - step->target_start;
}

/* A column that has an entry in the pivot's row: what the targets get may fill it. */
static void note_fill(km_replay *r, const km_replay_step *step, int first, bool *column) {
  for (int i = 0; i < step->target_count; ++i) {
    int row = r->rows[step->target_start + i];
    if (!column[row])
      r->fill[r->fill_count++] = first + row;
    column[row] = true;
  }
}

void km_replay_make(km_replay *r, const km_partition *p, const bool *used) {
  int targets = 0, columns = 0, rows = r->row_count;
  memcpy(r->reduced, used, (size_t)rows * (size_t)r->column_count * sizeof *used);
  r->rank = p->rank;
  r->fill_count = 0;
  memcpy(r->row, p->row, (size_t)rows * sizeof *r->row);
  memcpy(r->column, p->column, (size_t)r->column_count * sizeof *r->column);
  for (int s = 0; s < p->rank; ++s) {
    km_replay_step *step = &r->steps[s];
    int first = p->column[s] * rows;
    *step = (km_replay_step){.pivot = first + p->row[s], .row = p->row[s], .column_start = columns};
    list_targets(r, step, r->reduced + first, &targets);
    for (int k = s + 1; k < r->column_count; ++k) {
      int other = p->column[k] * rows;
      if (!r->reduced[other + step->row])
        continue;
      r->columns[columns++] = other;
      note_fill(r, step, other, r->reduced + other);
    }
    step->column_count = columns - step->column_start;
  }
}

bool km_replay_fits(const km_replay *r, const km_partition *p) {
  return r->rank == p->rank && memcmp(r->row, p->row, (size_t)r->rank * sizeof *r->row) == 0 &&
         memcmp(r->column, p->column, (size_t)r->column_count * sizeof *r->column) == 0;
}
