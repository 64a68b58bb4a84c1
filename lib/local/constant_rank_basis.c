/* Constant-rank tangents U = { a : Q_i a = 0 for all i }, and a test whether other tangents can belong to finite
 * motions (docs/theory.md 5.6). */
#include "local/constant_rank_basis.h"

#include "base/random.h"
#include "linalg/partition.h"
#include "local/tangent_cone.h"

#include <string.h>

/* Common null space of all Q_i, to `tolerance` of their largest entry, as orthonormal coefficients. Returns its
 * dimension. */
static int find_common_null_space(const km_second_order *c, double tolerance, km_arena *arena, double **coefficients) {
  int k = c->freedom, rows = c->conditions * k;
  double *M = KM_ARENA_NEW(arena, double, (size_t)rows *(size_t)k),
         *unit_weight = KM_ARENA_NEW(arena, double, (size_t)k);
  km_partition p;
  if (arena->failed || !km_partition_reserve(&p, rows, k, arena))
    return 0;
  for (int a = 0; a < k; ++a) {
    unit_weight[a] = 1.0;
    for (int i = 0; i < rows; ++i)
      M[a * rows + i] = c->Q[i * k + a];
  }
  km_partition_factor(&p, M, rows, k, NULL, fmax(tolerance, c->noise / c->size));
  int count = km_partition_freedom(&p);
  *coefficients = KM_ARENA_NEW(arena, double, (size_t)(count * k) + 1);
  if (arena->failed)
    return 0;
  km_partition_null_space(&p, unit_weight, count, *coefficients);
  return count;
}

/* Constant-rank tangents U as the common null space of all Q_i, completed to an orthonormal basis. */
int km_constant_rank_basis(const km_second_order *c, int count, km_arena *arena, double **V) {
  static const double null_tolerance = 1e-6, max_tolerance = 1e-2;
  const int k = c->freedom;
  double *coefficients = NULL;
  *V = KM_ARENA_NEW(arena, double, (size_t)(k * k) + 1);
  if (!km_second_order_is_significant(c))
    return 0;
  int constant_rank_count = find_common_null_space(c, null_tolerance, arena, &coefficients);
  for (double tolerance = 10.0 * null_tolerance; constant_rank_count < count && tolerance <= max_tolerance;
       tolerance *= 10.0)
    constant_rank_count = find_common_null_space(c, tolerance, arena, &coefficients);
  if (arena->failed || constant_rank_count == 0 || constant_rank_count == k)
    return 0;
  memcpy(*V, coefficients, (size_t)(constant_rank_count * k) * sizeof *coefficients);
  return km_tangents_complete_basis(*V, constant_rank_count, k) ? constant_rank_count : 0;
}

/* Tests by random starts whether tangents orthogonal to U satisfy the second-order conditions. */
bool km_constant_rank_others_may_be_finite(const km_second_order *c, const double *V, int constant_rank_count,
                                           km_arena *arena) {
  int count = c->freedom - constant_rank_count;
  km_second_order restricted;
  uint64_t random = 1;
  double *a = KM_ARENA_NEW(arena, double, (size_t)count);
  double *work = KM_ARENA_NEW(arena, double, 4 * (size_t)(count * count) + 8 * (size_t)count);
  if (arena->failed || !km_second_order_restrict(c, V + constant_rank_count * c->freedom, count, arena, &restricted))
    return true;
  bool is_satisfied = false;
  for (int start = 0; start < KM_STARTS_PER_FREEDOM * count && count > 1 && !is_satisfied; ++start) {
    for (int i = 0; i < count; ++i)
      a[i] = km_uniform(&random);
    km_tangents_normalise(a, count);
    is_satisfied = km_second_order_solve(&restricted, a, work);
  }
  return is_satisfied;
}
