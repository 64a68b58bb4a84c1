/* Left null vectors of single loops: null space of the transposed six rows of each loop (theory 7.1). */
#include "local/local.h"
#include "mobility/left_null_space.h"

/* The loop's columns of J, transposed: row-major by constraint. */
typedef struct transposed {
  double *entries;
  int columns, next; /* columns of the loop; the next column */
} transposed;

static void write_column(void *out, int column, const double entry[6]) {
  transposed *T = out;
  (void)column;
  for (int r = 0; r < 6; ++r)
    T->entries[r * T->columns + T->next] = entry[r];
  T->next++;
}

/* Computes the left null vectors W[6 × returned] of one loop; -1: no memory. */
static int solve_loop(const km_left_space *a, int block, double *W) {
  km_arena scratch = {0};
  int columns = km_left_column_count(a, block);
  transposed T = {KM_ARENA_NEW(&scratch, double, 6 * (size_t)columns), columns, 0};
  double *found = NULL;
  int count = -1;
  if (!scratch.failed) {
    km_left_for_each_column(a, block, write_column, &T);
    count = km_dense_null_space(T.entries, columns, 6, a->tolerance, &scratch, &found);
    for (int i = 0; i < 6 * count; ++i)
      W[i] = found[i];
  }
  km_arena_free(&scratch);
  return count;
}

bool km_left_null_find(const km_left_space *a, km_arena *arena, km_left_null *out) {
  size_t loops = (size_t)a->sub->loop_count;
  *out = (km_left_null){.first = KM_ARENA_NEW(arena, int, loops + 1), .local = KM_ARENA_NEW(arena, double, 36 * loops)};
  if (arena->failed)
    return false;
  for (int i = 0; i < a->sub->loop_count; ++i) {
    int count = solve_loop(a, i, out->local + 6 * out->local_count);
    if (count < 0)
      return false;
    out->first[i] = out->local_count;
    out->local_count += count;
  }
  out->first[loops] = out->local_count;
  return a->rows - km_factor_rank(a->s->factor[a->index]) <= out->local_count ||
         km_left_null_find_multiloop(a, arena, out);
}
