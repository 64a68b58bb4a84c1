/* Leaving the steady tangents alone in the basis. */
#include "local/constant_rank_basis.h"
#include "local/constant_rank_motion.h"

#include <string.h>

int km_tangents_restrict_to_constant_rank(km_tangents *f, double *directions) {
  km_second_order *c = &f->conditions;
  km_arena arena = {0};
  int k = c->freedom;
  double *V = NULL, *out = NULL;
  int steady = km_tangents_update_conditions(f) ? km_constant_rank_basis(c, 0, &arena, &V) : 0, others = k - steady;
  if (steady > 0 && !km_constant_rank_others_may_be_finite(c, V, steady, &arena))
    out = KM_ARENA_NEW(&arena, double, (size_t)(k * k));
  if (out) { /* the steady ones are what is left when the others are taken out */
    memcpy(out, V + steady * k, (size_t)(others * k) * sizeof *out);
    for (int i = 0; i < others && directions; ++i)
      km_tangents_direction(f, out + i * k, directions + (size_t)i * (size_t)f->sub->columns);
    f->arena->failed = !km_tangents_remove(f, out, others) || f->arena->failed;
    c->conditions = 0;
  }
  f->arena->failed = f->arena->failed || arena.failed;
  km_arena_free(&arena);
  return out ? others : 0;
}
