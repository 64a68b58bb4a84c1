/* Directions of the branches through a branch point (docs/theory.md 4.10): confirmed tangents (5.3) that differ,
 * 1 − |cos| > 2e-5. */
#include "local/bifurcation.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/sampled_tangents.h"
#include "local/second_order_conditions.h"

#include <string.h>

/* Counts the direction after the `found` ones if it differs from them in more than its sense. */
static int count_if_new(const km_tangents *f, const double *directions, int found) {
  size_t n = (size_t)f->sub->columns;
  for (int i = 0; i < found; ++i)
    if (km_is_same_tangent(km_step_dot(f->m, f->sub, directions + (size_t)found * n, directions + (size_t)i * n)))
      return found;
  return found + 1;
}

/* Branch directions by a basis of the tangents. */
static int find_by_basis(km_tangents *f, double *directions) {
  int found = 0;
  size_t k = (size_t)f->conditions.freedom;
  double length;
  if (!km_tangents_create_basis(f) || km_tangents_are_regular(f) || km_tangents_all_finite(f))
    return 0;
  double *known = KM_ARENA_NEW(f->arena, double, KM_MAX_BRANCHES *k);
  while (known && found < KM_MAX_BRANCHES && km_tangents_find_next(f, known, found, &length)) {
    memcpy(known + (size_t)found * k, f->a, k * sizeof *known);
    km_tangents_direction(f, f->a, directions + (size_t)found++ * (size_t)f->sub->columns);
  }
  return found;
}

/* Branch directions by random single tangents, with many freedoms. */
static int find_by_samples(km_tangents *f, double *directions) {
  km_sampled_tangents sample;
  int found = 0;
  double length;
  if (km_sampled_tangents_create(&sample, f) && !km_sampled_tangents_all_finite(&sample, &length))
    while (found < KM_MAX_BRANCHES && km_sampled_tangents_find_next(&sample, &length)) {
      memcpy(directions + (size_t)found * (size_t)f->sub->columns, sample.x,
             (size_t)f->sub->columns * sizeof *sample.x);
      found = count_if_new(f, directions, found);
    }
  km_sampled_tangents_free(&sample);
  return found;
}

/* True if J has full row rank, so that the configuration is no branch point. Pivots are searched. */
bool km_is_regular_configuration(const km_mechanism *m, km_state *s, int index) {
  km_second_order conditions;
  return km_second_order_count_tangents(m, s, index, &conditions) && !conditions.has_redundant_rows;
}

/* Branch directions: confirmed or undecided tangents at a configuration of deficient rank. */
int km_branch_directions(const km_mechanism *m, km_state *s, int index, double *directions) {
  if (km_is_regular_configuration(m, s, index))
    return 0;
  km_arena arena = {0};
  km_tangents f;
  int found = 0;
  bool is_ok = km_tangents_create(&f, m, s, index, &arena);
  f.min_verdict = KM_TANGENT_UNDECIDED; /* undecided tangents count, since rounded data have branches too */
  if (is_ok)
    found = (km_tangents_are_many(&f) ? find_by_samples : find_by_basis)(&f, directions);
  if (arena.failed) {
    found = -1;
  } else {
    km_state_restore(s, f.sub, f.origin);
    km_loops_update(m, s, f.sub);
    km_search_pivots(m, s, index, KM_NO_DRIVER, km_rank_tolerance(m, f.sub, 0.0));
  }
  km_arena_free(&arena);
  return found;
}
