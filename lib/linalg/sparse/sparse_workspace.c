/* Memory of the sparse factor, and the column order by COLAMD. */
#include "linalg/sparse/sparse_lu.h"

#include <string.h>
#include <suitesparse/colamd.h>

/* Column order for little fill-in by COLAMD (T. Davis and others 2004). */
static bool order_columns(int rows, int columns, const int *start, const int *row, int *order) {
  for (int c = 0; c < columns; ++c)
    order[c] = c;
  if (start[columns] == 0)
    return true;
  size_t capacity = colamd_recommended(start[columns], rows, columns);
  int *work = KM_NEW(int, capacity), *pointers = KM_NEW(int, (size_t)columns + 1), stats[COLAMD_STATS];
  bool is_ok = capacity > 0 && work && pointers;
  if (is_ok) {
    memcpy(work, row, (size_t)start[columns] * sizeof *work);
    memcpy(pointers, start, ((size_t)columns + 1) * sizeof *pointers);
    is_ok = colamd(rows, columns, (int)capacity, work, pointers, NULL, stats);
    memcpy(order, pointers, (size_t)columns * sizeof *order);
  }
  km_free(work);
  km_free(pointers);
  return is_ok;
}

static bool reserve_arrays(km_sparse *s, int rows, int columns, km_arena *arena) {
  size_t r = (size_t)rows, c = (size_t)columns;
  *s = (km_sparse){.arena = arena,
                   .start = s->start,
                   .row = s->row,
                   .by_row = s->by_row,
                   .row_start = s->row_start,
                   .order = s->order,
                   .normal = s->normal,
                   .factor_order = KM_ARENA_NEW(arena, int, c),
                   .singleton_zero = KM_ARENA_NEW(arena, int, (size_t)s->start[columns]),
                   .open_entries = KM_ARENA_NEW(arena, km_open_entries, c),
                   .dropped = KM_ARENA_NEW(arena, int, c),
                   .b = KM_ARENA_NEW(arena, km_entry_range, c),
                   .is_postponed = KM_ARENA_NEW(arena, bool, c),
                   .upper = KM_ARENA_NEW(arena, km_entry_range, c),
                   .lower = KM_ARENA_NEW(arena, km_entry_range, c),
                   .step_of = KM_ARENA_NEW(arena, int, r),
                   .x = KM_ARENA_NEW(arena, double, r),
                   .reach_list = KM_ARENA_NEW(arena, int, r),
                   .stack = KM_ARENA_NEW(arena, int, r),
                   .stack_position = KM_ARENA_NEW(arena, int, r),
                   .visited = KM_ARENA_NEW(arena, bool, r),
                   .is_excluded_row = KM_ARENA_NEW(arena, bool, r)};
  return !arena->failed;
}

km_factor *km_sparse_create(const km_sparse *pattern, int rows, int columns, const double *weight, km_arena *arena) {
  km_factor *p = km_factor_allocate(rows, columns, pattern->start[columns], weight, arena);
  km_sparse *s = KM_ARENA_NEW(arena, km_sparse, 1);
  if (!p || !s)
    return NULL;
  *s = *pattern;
  p->sparse = s;
  return reserve_arrays(s, rows, columns, arena) ? p : NULL;
}

km_factor *km_factor_create_sparse(int rows, int columns, const int *start, const int *row, const double *weight,
                                   km_arena *arena) {
  int *order = KM_ARENA_NEW(arena, int, (size_t)columns + 1), *row_start = KM_ARENA_NEW(arena, int, (size_t)rows + 2);
  km_row_entry *by_row = KM_ARENA_NEW(arena, km_row_entry, (size_t)start[columns]);
  km_sparse pattern = {.start = start, .row = row, .by_row = by_row, .row_start = row_start, .order = order};
  if (!arena->failed)
    km_create_row_storage(rows, columns, start, row, row_start, by_row);
  arena->failed = arena->failed || !order_columns(rows, columns, start, row, order);
  return arena->failed ? NULL : km_sparse_create(&pattern, rows, columns, weight, arena);
}

void km_factor_share_normal_equations(km_factor *p, km_normal_equations **normal) {
  if (p->sparse)
    p->sparse->normal = normal;
}

/* Grows both arrays of a store. */
bool km_sparse_grow(km_sparse *s, km_entry_store *store, int need) {
  size_t values = store->capacity; /* both arrays of a store grow together */
  if ((size_t)need <= store->capacity && store->index)
    return true;
  return km_arena_grow(s->arena, (void **)&store->value, &values, (size_t)need, sizeof(double)) &&
         km_arena_grow(s->arena, (void **)&store->index, &store->capacity, (size_t)need, sizeof(int));
}

bool km_sparse_reserve_factor(km_sparse *s, int upper, int lower) {
  return km_sparse_grow(s, &s->upper_store, upper) && km_sparse_grow(s, &s->lower_store, lower);
}
