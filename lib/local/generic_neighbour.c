/* Going a short way along the motion and back. */
#include "local/generic_neighbour.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/constant_rank_motion.h"
#include "local/partition_stash.h"
#include "local/sampled_tangents.h"

#include <string.h>

/* All motions Z[count × columns] at once, each by another amount, so that none hides another. */
static void choose_move(const km_mechanism *m, int index, const double *Z, int freedom, double *move) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start;
  memset(move, 0, (size_t)sub->columns * sizeof *move);
  for (int c = 0; c < sub->columns; ++c)
    for (int i = 0; i < freedom; ++i)
      move[c] += 0.02 * (1.0 + 0.3 * i) * Z[(size_t)i * (size_t)sub->columns + (size_t)c] / weight[c];
}

/* Of many motions a random mixture that may be real, with the fastest coordinate by as much. */
static void choose_of_many(const km_mechanism *m, km_state *s, int index, double *move) {
  static const double short_way = 0.05;
  int columns = m->substructures[index].columns;
  double fastest = 0.0;
  km_arena arena = {0};
  km_tangents f;
  km_sampled_tangents many = {0};
  bool moves = km_tangents_create(&f, m, s, index, &arena) && km_sampled_tangents_create(&many, &f) &&
               km_sampled_tangents_draw_second_order(&many);
  for (int c = 0; c < columns && moves; ++c)
    fastest = fmax(fastest, fabs(many.x[c]));
  for (int c = 0; c < columns; ++c)
    move[c] = moves ? short_way / fastest * many.x[c] : 0.0;
  km_sampled_tangents_free(&many);
  km_arena_free(&arena);
}

/* Of a mechanism that shakes all along its motion. False: it doesn't, and nothing has happened. */
static bool go_steadily(const km_mechanism *m, km_state *s, int index, double *saved, double *move) {
  const km_substructure *sub = &m->substructures[index];
  km_arena arena = {0};
  km_constant_rank steady = {0};
  km_closure evidence;
  km_state_save(s, sub, saved);
  km_constant_rank_begin(&steady, m, s, index, KM_NO_DRIVER, &arena);
  if (steady.is_active) {
    choose_move(m, index, steady.Z, steady.count, move);
    km_state_move(m, s, sub, move);
    km_state_invalidate_pivots(s, index);
    steady.is_active = km_constant_rank_close(&steady, m, s, index, KM_NO_DRIVER, &evidence);
    if (steady.is_active) {
      km_poses_compute_in(m, s, index);
      km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, evidence.residual);
    } else {
      km_loops_restore_cached(m, s, index, saved);
      km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, 0.0);
    }
  }
  km_arena_free(&arena);
  return steady.is_active;
}

bool km_generic_neighbour_enter(const km_mechanism *m, km_state *s, int index, double *saved, double *move) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  bool moves = km_partition_freedom(p) > 0, many = km_partition_freedom(p) > KM_MANY_VECTORS;
  km_closure evidence;
  if (!many)
    choose_move(m, index, km_state_basis(s, index), km_partition_freedom(p), move);
  km_partition_stash(s, index);
  if (!many && moves && go_steadily(m, s, index, saved, move))
    return true;
  s->partition[index].rows_only = p->sparse && many;
  if (many)
    choose_of_many(m, s, index, move);
  s->partition[index].kept_row_tolerance = s->partition[index].rows_only ? km_rank_tolerance(m, sub, 0.0) : 0.0;
  km_state_save(s, sub, saved);
  km_state_move(m, s, sub, move);
  km_state_invalidate_pivots(s, index);
  if (!moves || km_loops_close(m, s, index, KM_NO_DRIVER, &evidence) != KM_CLOSED)
    return false;
  km_poses_compute_in(m, s, index);
  km_search_pivots(m, s, index, KM_NO_DRIVER, km_rank_tolerance(m, sub, evidence.residual));
  return true;
}

void km_generic_neighbour_leave(const km_mechanism *m, km_state *s, int index, const double *saved) {
  s->partition[index].rows_only = false;
  s->partition[index].kept_row_tolerance = 0.0;
  km_partition_unstash(s, index);
  km_loops_restore_cached(m, s, index, saved);
  km_poses_compute_in(m, s, index);
}
