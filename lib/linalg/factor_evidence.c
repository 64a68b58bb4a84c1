/* Memory of a factor, and what can be read of it: rank, order, evidence.
 *
 *   rank r, freedom = columns − r − locked;   det = product of the pivots = 1 / product of `inverse` */
#include "linalg/factor_private.h"

#include <math.h>

km_factor *km_factor_allocate(int rows, int columns, int entries, const double *weight, km_arena *arena) {
  size_t r = (size_t)rows, c = (size_t)columns, least = r < c ? r : c, most = r < c ? c : r;
  km_factor *p = KM_ARENA_NEW(arena, km_factor, 1);
  double *ones = weight || !p ? NULL : KM_ARENA_NEW(arena, double, c);
  for (size_t k = 0; ones && k < c; ++k)
    ones[k] = 1.0;
  if (p)
    *p = (km_factor){.most_rows = rows,
                     .most_columns = columns,
                     .weight = weight ? weight : ones,
                     .arena = arena,
                     .row = KM_ARENA_NEW(arena, int, r),
                     .column = KM_ARENA_NEW(arena, int, c),
                     .inverse = KM_ARENA_NEW(arena, double, least),
                     .work = KM_ARENA_NEW(arena, double, most + 2),
                     .projection = KM_ARENA_NEW(arena, double, c),
                     .cached_matrix = KM_ARENA_NEW(arena, double, (size_t)entries),
                     .cached_forced = KM_ARENA_NEW(arena, bool, c),
                     .cached_locked = KM_ARENA_NEW(arena, bool, c)};
  return arena->failed ? NULL : p;
}

int km_factor_rank(const km_factor *p) {
  return p->rank;
}

int km_factor_freedom(const km_factor *p) {
  return p->failed ? 0 : p->columns - p->rank - p->locked_count;
}

int km_factor_locked_count(const km_factor *p) {
  return p->locked_count;
}

const int *km_factor_row_order(const km_factor *p) {
  return p->row;
}

const int *km_factor_column_order(const km_factor *p) {
  return p->column;
}

km_factor_evidence km_factor_get_evidence(const km_factor *p) {
  return (km_factor_evidence){.scale = p->scale,
                              .first_pivot = p->first_pivot,
                              .last_pivot = p->last_pivot,
                              .first_dropped = p->first_dropped,
                              .smallest_pivot_at_search = p->smallest_pivot,
                              .max_b = p->max_b,
                              .max_b_at_search = p->max_b_at_search,
                              .version = p->version};
}

unsigned km_factor_search_count(const km_factor *p) {
  return p->search_count;
}

void km_factor_forget(km_factor *p) {
  p->is_cached = false;
}

bool km_factor_has_forced_pivot(const km_factor *p) {
  return p->forced_dependent;
}

bool km_factor_has_failed(const km_factor *p) {
  return p->failed;
}

int km_factor_sign(const km_factor *p) {
  return p->sign;
}

double km_factor_smallest_pivot(const km_factor *p) {
  return 1.0 / km_factor_largest_inverse(p);
}

double km_factor_pivot_product(const km_factor *p) {
  double product = 1.0;
  for (int i = 0; i < p->rank; ++i)
    product /= p->inverse[i];
  return product;
}
