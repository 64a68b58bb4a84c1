/* Restriction of the tangents to those of constant rank (docs/theory.md 5.6). */
#include "local/constant_rank_basis.h"
#include "local/constant_rank_motion.h"

#include <string.h>

/* Removes all tangents outside U from the basis. */
int km_tangents_restrict_to_constant_rank(km_tangents *f, double *directions) {
  km_second_order *c = &f->conditions;
  km_arena arena = {0};
  int k = c->freedom;
  double *V = NULL, *out = NULL;
  int constant_rank_count = km_tangents_update_conditions(f) ? km_constant_rank_basis(c, 0, &arena, &V) : 0,
      other_count = k - constant_rank_count;
  if (constant_rank_count > 0 && !km_constant_rank_others_may_be_finite(c, V, constant_rank_count, &arena))
    out = KM_ARENA_NEW(&arena, double, (size_t)(k * k));
  if (out) { /* the constant-rank tangents remain when the others are removed */
    memcpy(out, V + constant_rank_count * k, (size_t)(other_count * k) * sizeof *out);
    for (int i = 0; i < other_count && directions; ++i)
      km_tangents_direction(f, out + i * k, directions + (size_t)i * (size_t)f->sub->columns);
    f->arena->failed = !km_tangents_remove(f, out, other_count) || f->arena->failed;
    c->conditions = 0;
  }
  f->arena->failed = f->arena->failed || arena.failed;
  km_arena_free(&arena);
  return out ? other_count : 0;
}
