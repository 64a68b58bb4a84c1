/* Neighbouring configuration (docs/theory.md 5.8).
 *
 *   q₁ = close(q₀ + Σ_i 0.02 (1 + 0.3 i) D⁻¹ z_i)
 *
 * All motions are combined with different amounts, so that none conceals another. Many freedoms use one random
 * combination that satisfies the second order; permanently shaky mechanisms use their constant-rank tangents (5.6). */
#include "local/generic_neighbour.h"

#include "base/random.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/constant_rank.h"
#include "local/local_private.h"

#include <string.h>

/* Sum of all motions Z[freedom × columns] with different amounts. */
static void combine_motions(const km_mechanism *m, int index, const double *Z, int freedom, double *move) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  memset(move, 0, (size_t)sub->columns * sizeof *move);
  for (int c = 0; c < sub->columns; ++c)
    for (int i = 0; i < freedom; ++i)
      move[c] += 0.02 * (1.0 + 0.3 * i) * Z[(size_t)i * (size_t)sub->columns + (size_t)c] / weight[c];
}

/* Random tangent that satisfies the second order, scaled so that its fastest coordinate moves by 0.05. The start is
 * nearly uniform, so that equal loops move alike. */
static void choose_random_motion(const km_mechanism *m, km_state *s, int index, double *move) {
  int columns = m->substructures[index].columns;
  double fastest = 0.0;
  km_arena arena = {0};
  km_local *l = km_local_create(m, s, index, NULL, 0.0, &arena);
  bool is_mobile = l && km_local_reserve_tangents(l, false) && km_local_draw(l, &l->random, l->a);
  if (is_mobile && km_local_violates_second_order(l, l->a)) {
    for (int c = 0; c < columns; ++c)
      l->a[c] = 1.0 + 0.3 * km_uniform(&l->random);
    is_mobile = km_local_normalise(l, l->a) > 0.0 && km_local_solve_second_order(l, l->a);
  }
  memset(move, 0, (size_t)columns * sizeof *move);
  if (is_mobile)
    km_local_direction(l, l->a, move);
  for (int c = 0; c < columns; ++c)
    fastest = fmax(fastest, fabs(move[c]));
  for (int c = 0; c < columns && is_mobile; ++c)
    move[c] *= km_longest_arc_step / fastest;
  km_local_free(l);
  km_arena_free(&arena);
}

/* Moves a permanently shaky mechanism along its constant-rank tangents. False, with nothing changed, for other
 * mechanisms. */
static bool move_at_constant_rank(const km_mechanism *m, km_state *s, int index, double *saved, double *move) {
  const km_substructure *sub = &m->substructures[index];
  km_arena arena = {0};
  km_constant_rank motion = {0};
  km_closure evidence;
  km_state_save(s, sub, saved);
  km_constant_rank_begin(&motion, m, s, index, KM_NO_DRIVER, &arena);
  if (motion.is_active) {
    combine_motions(m, index, motion.Z, motion.count, move);
    km_state_move(m, s, sub, move);
    km_state_invalidate_pivots(s, index);
    motion.is_active = km_constant_rank_close(&motion, m, s, index, KM_NO_DRIVER, &evidence);
    if (motion.is_active) {
      km_poses_compute_in(m, s, index);
      km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, evidence.residual);
    } else {
      km_loops_restore_cached(m, s, index, saved);
      km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, 0.0);
    }
  }
  km_arena_free(&arena);
  return motion.is_active;
}

/* Moves to the neighbouring configuration q₁ and factors its Jacobian. */
bool km_generic_neighbour_enter(const km_mechanism *m, km_state *s, int index, double *saved, double *move) {
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  bool is_mobile = km_factor_freedom(p) > 0, sample = km_factor_freedom(p) > KM_MANY_VECTORS;
  km_closure evidence;
  if (!sample)
    combine_motions(m, index, km_state_basis(s, index), km_factor_freedom(p), move);
  if (!sample && is_mobile && move_at_constant_rank(m, s, index, saved, move))
    return true;
  if (sample)
    choose_random_motion(m, s, index, move);
  km_state_save(s, sub, saved);
  km_state_move(m, s, sub, move);
  km_state_invalidate_pivots(s, index);
  const km_pivoting pivoting = {.driver = KM_NO_DRIVER, .basis = sample ? KM_BASIS_NONE : KM_BASIS_SHORT};
  if (!is_mobile || km_loops_close_by(m, s, index, &pivoting, &evidence) != KM_CLOSED)
    return false;
  km_poses_compute_in(m, s, index);
  km_search_pivots_by(m, s, index, &pivoting, km_rank_tolerance(m, sub, evidence.residual));
  return true;
}

/* Restores the configuration and its poses. */
void km_generic_neighbour_leave(const km_mechanism *m, km_state *s, int index, const double *saved) {
  km_loops_restore_cached(m, s, index, saved);
  km_poses_compute_in(m, s, index);
}
