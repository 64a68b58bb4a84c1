/* Records the operations of an elimination with known pivots. */
#include "linalg/dense/recorded_elimination.h"

#include <string.h>

bool km_recorded_elimination_reserve(km_recorded_elimination *r, int rows, int columns, int stride, km_arena *arena) {
  size_t m = (size_t)rows, n = (size_t)columns, steps = m < n ? m : n;
  *r = (km_recorded_elimination){.row_count = rows, .column_count = columns, .stride = stride};
  r->steps = KM_ARENA_NEW(arena, km_recorded_elimination_step, steps);
  r->scales = KM_ARENA_NEW(arena, int, steps *m);
  r->updates = KM_ARENA_NEW(arena, km_recorded_elimination_update, steps * m * n);
  r->rhs_updates = KM_ARENA_NEW(arena, km_recorded_elimination_update, steps * m);
  r->fill = KM_ARENA_NEW(arena, int, m *n);
  r->row = KM_ARENA_NEW(arena, int, m);
  r->column = KM_ARENA_NEW(arena, int, n);
  r->reduced = KM_ARENA_NEW(arena, bool, m *n);
  return !arena->failed;
}

/* Ends of the lists. */
typedef struct list_ends {
  int *scale;
  km_recorded_elimination_update *update, *turn;
} list_ends;

/* Lists the rows with an entry in the pivot column: divisions by the pivot, and updates of a right side. `first`: first
 * position of the column. */
static void list_multipliers(const km_recorded_elimination *r, int first, int row, list_ends *to) {
  for (int i = 0; i < r->row_count; ++i) {
    if (i == row || !r->reduced[first + i])
      continue;
    *to->scale++ = (first + i) * r->stride;
    *to->turn++ = (km_recorded_elimination_update){i * r->stride, (first + i) * r->stride, row * r->stride};
  }
}

/* Lists the updates of a column with an entry in the pivot row, and their fill-in. */
static void list_updates(km_recorded_elimination *r, int first, int row, int other, list_ends *to) {
  for (int i = 0; i < r->row_count; ++i) {
    if (i == row || !r->reduced[first + i])
      continue;
    *to->update++ =
        (km_recorded_elimination_update){(other + i) * r->stride, (first + i) * r->stride, (other + row) * r->stride};
    if (!r->reduced[other + i])
      r->fill[r->fill_count++] = (other + i) * r->stride;
    r->reduced[other + i] = true;
  }
}

/* Symbolic Gauss-Jordan elimination with known pivots: lists operations and fill-in. */
void km_recorded_elimination_record(km_recorded_elimination *r, const km_factor *p, const bool *used) {
  int rows = r->row_count;
  list_ends to = {r->scales, r->updates, r->rhs_updates};
  memcpy(r->reduced, used, (size_t)rows * (size_t)r->column_count * sizeof *used);
  r->rank = p->rank;
  r->fill_count = 0;
  memcpy(r->row, p->row, (size_t)rows * sizeof *r->row);
  memcpy(r->column, p->column, (size_t)r->column_count * sizeof *r->column);
  for (int s = 0; s < p->rank; ++s) {
    int first = p->column[s] * rows, row = p->row[s];
    list_ends from = to;
    list_multipliers(r, first, row, &to);
    for (int k = s + 1; k < r->column_count; ++k)
      if (r->reduced[p->column[k] * rows + row])
        list_updates(r, first, row, p->column[k] * rows, &to);
    r->steps[s] = (km_recorded_elimination_step){.pivot = (first + row) * r->stride,
                                                 .scale_count = (int)(to.scale - from.scale),
                                                 .update_count = (int)(to.update - from.update)};
  }
  r->rhs_update_count = (int)(to.turn - r->rhs_updates);
}

bool km_recorded_elimination_matches(const km_recorded_elimination *r, const km_factor *p) {
  return r->rank == p->rank && memcmp(r->row, p->row, (size_t)r->rank * sizeof *r->row) == 0 &&
         memcmp(r->column, p->column, (size_t)r->column_count * sizeof *r->column) == 0;
}
