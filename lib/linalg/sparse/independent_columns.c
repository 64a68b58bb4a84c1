/* Choice of independent columns by complete pivoting of the null vectors (docs/theory.md 3.6).
 *
 *   N = [−B; I]  [columns × freedom];   GECP of N: its pivot rows are the new independent columns
 *
 * Each pivot is the largest entry of all remaining null vectors, so |B| <= 2 about, as with complete pivoting of the
 * matrix. */
#include "linalg/dense/dense_elimination.h"
#include "linalg/sparse/sparse_lu.h"

#include <string.h>

/* Writes the null vectors of the independent columns that are not preset, to N[columns × count]; preset columns have
 * entries 0, which are no pivots. Returns their number. */
static int write_null_vectors(const km_factor *p, const bool *forced, double *N) {
  int count = 0;
  for (int k = p->rank; k < p->columns; ++k) {
    if (km_sparse_is_preset(p, forced, p->column[k]))
      continue;
    double *vector = N + (size_t)count++ * (size_t)p->columns;
    const km_entry_range b = km_sparse_b(p, k - p->rank);
    vector[p->column[k]] = 1.0;
    for (int i = b.start; i < b.end; ++i) {
      int c = p->column[p->sparse->b_store.index[i]];
      vector[c] = km_sparse_is_preset(p, forced, c) ? 0.0 : -p->sparse->b_store.value[i];
    }
  }
  return count;
}

bool km_sparse_choose_independent(km_factor *p, const bool *forced) {
  bool changed = false, *const is_postponed = p->sparse->is_postponed;
  const int most = p->columns - p->rank;
  km_arena arena = {0};
  double *N = KM_ARENA_NEW(&arena, double, (size_t)p->columns *(size_t)most);
  km_factor *q = km_factor_create(p->columns, most, NULL, &arena);
  p->failed = p->failed || arena.failed;
  if (!arena.failed) {
    q->rows = p->columns;
    q->columns = write_null_vectors(p, forced, N);
    km_dense_factor(q, N, NULL, 0.0);
    memset(is_postponed, 0, (size_t)p->columns * sizeof *is_postponed);
    for (int i = 0; i < q->rank; ++i)
      is_postponed[q->row[i]] = true;
  }
  km_arena_free(&arena);
  for (int k = 0; k < p->rank; ++k)
    changed = changed || is_postponed[p->column[k]];
  return changed && !p->failed;
}
