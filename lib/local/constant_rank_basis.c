/* Which tangents are steady, and may others be real? */
#include "local/constant_rank_basis.h"

#include "base/random.h"
#include "linalg/partition.h"
#include "local/tangent_cone.h"

#include <string.h>

/* The common null space of all Q_i, to within a part of their largest entry, as orthonormal shares of the basis. Returns how many there
 * are. */
static int find_shares(const km_second_order *c, double within, km_arena *arena, double **shares) {
  int k = c->freedom, rows = c->conditions * k;
  double *M = KM_ARENA_NEW(arena, double, (size_t)rows *(size_t)k), *one = KM_ARENA_NEW(arena, double, (size_t)k);
  km_partition p;
  if (arena->failed || !km_partition_reserve(&p, rows, k, arena))
    return 0;
  for (int a = 0; a < k; ++a) {
    one[a] = 1.0;
    for (int i = 0; i < rows; ++i)
      M[a * rows + i] = c->Q[i * k + a];
  }
  km_partition_factor(&p, M, rows, k, NULL, fmax(within, c->noise / c->size));
  int count = km_partition_freedom(&p);
  *shares = KM_ARENA_NEW(arena, double, (size_t)(count * k) + 1);
  if (arena->failed)
    return 0;
  km_partition_null_space(&p, one, count, *shares);
  return count;
}

int km_constant_rank_basis(const km_second_order *c, int count, km_arena *arena, double **V) {
  static const double still = 1e-6, most_within = 1e-2;
  const int k = c->freedom;
  double *shares = NULL;
  *V = KM_ARENA_NEW(arena, double, (size_t)(k * k) + 1);
  if (!km_second_order_is_significant(c))
    return 0;
  int steady = find_shares(c, still, arena, &shares);
  for (double within = 10.0 * still; steady < count && within <= most_within; within *= 10.0)
    steady = find_shares(c, within, arena, &shares);
  if (arena->failed || steady == 0 || steady == k)
    return 0;
  memcpy(*V, shares, (size_t)(steady * k) * sizeof *shares);
  return km_tangents_complete_basis(*V, steady, k) ? steady : 0;
}

bool km_constant_rank_others_may_be_finite(const km_second_order *c, const double *V, int steady, km_arena *arena) {
  int count = c->freedom - steady;
  km_second_order rest;
  uint64_t random = 1;
  double *a = KM_ARENA_NEW(arena, double, (size_t)count);
  double *work = KM_ARENA_NEW(arena, double, 4 * (size_t)(count * count) + 8 * (size_t)count);
  if (arena->failed || !km_second_order_restrict(c, V + steady * c->freedom, count, arena, &rest))
    return true;
  bool met = false;
  for (int start = 0; start < KM_STARTS_PER_FREEDOM * count && count > 1 && !met; ++start) {
    for (int i = 0; i < count; ++i)
      a[i] = km_uniform(&random);
    km_tangents_normalise(a, count);
    met = km_second_order_solve(&rest, a, work);
  }
  return met;
}
