/* Finding the tangents along which the rank stays, and whether others can be real. */
#include "kinematics/steady.h"

#include "base/random.h"
#include "partition/partition.h"

#include <string.h>

/* The common null space of all Q_i, as orthonormal shares of the basis. Returns how many there are. */
static int find_steady(const km_second_order *c, km_arena *arena, double **shares) {
  static const double still = 1e-6; /* over the largest entry: what changes no rank */
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
  km_partition_factor(&p, M, rows, k, NULL, fmax(still, c->noise / c->size));
  int count = km_partition_freedom(&p);
  *shares = KM_ARENA_NEW(arena, double, (size_t)(count * k) + 1);
  if (arena->failed)
    return 0;
  km_partition_null(&p, one, count, *shares);
  return count;
}

/* Shares at right angles to the first `count` rows of V[k × k], as the rows behind them. */
static bool find_others(double *V, int count, int k, km_arena *arena) {
  double *unit = KM_ARENA_NEW(arena, double, (size_t)k);
  for (int i = 0; i < k && count < k && unit; ++i) {
    memset(unit, 0, (size_t)k * sizeof *unit);
    unit[i] = 1.0;
    count += km_tangents_add(V, count, k, unit);
  }
  return count == k;
}

/* May one of these shares, others[count × freedom], or some of them together, meet the conditions? */
static bool others_may_move(const km_second_order *c, const double *others, int count, km_arena *arena) {
  km_second_order rest;
  uint64_t random = 1;
  double *a = KM_ARENA_NEW(arena, double, (size_t)count);
  double *work = KM_ARENA_NEW(arena, double, 4 * (size_t)(count * count) + 8 * (size_t)count);
  if (arena->failed || !km_second_order_restrict(c, others, count, arena, &rest))
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

int km_tangents_keep_steady(km_tangents *f, double *directions) {
  km_second_order *c = &f->conditions;
  km_arena arena = {0};
  int k = c->freedom, others = 0;
  double *steady = NULL, *V = KM_ARENA_NEW(&arena, double, (size_t)(k * k) + 1);
  if (V && km_tangents_need_conditions(f) && c->conditions > 0 && c->size > c->noise) {
    int count = find_steady(c, &arena, &steady);
    for (int i = 0; i < count * k; ++i)
      V[i] = steady[i];
    bool found = count > 0 && count < k && find_others(V, count, k, &arena);
    if (found && !others_may_move(c, V + count * k, k - count, &arena))
      others = k - count;
  }
  /* The steady ones are what is left when the others are taken out. */
  double *out = others ? KM_ARENA_NEW(&arena, double, (size_t)(k * k)) : NULL;
  if (out) {
    memcpy(out, V + (k - others) * k, (size_t)(others * k) * sizeof *out);
    for (int i = 0; i < others && directions; ++i)
      km_tangents_direction(f, out + i * k, directions + (size_t)i * (size_t)f->sub->columns);
    f->arena->failed = !km_tangents_take_out(f, out, others) || f->arena->failed;
    c->conditions = 0;
  }
  f->arena->failed = f->arena->failed || arena.failed;
  km_arena_free(&arena);
  return out ? others : 0;
}
