/* Starts a continuation by arc length (theory 4.9).
 *
 *   t in range(D^-1 Z), |D t| = 1, nearest to the requested direction; default: the coordinate with the largest
 *   mobility number. A branch point takes the confirmed tangent (theory 5.3) nearest to it. */
#include "kmech/continuation.h"

#include "base/arguments.h"
#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/bifurcation.h"

#include <string.h>

static bool allocate(km_arc_motion *f) {
  size_t n = (size_t)km_arc_motion_sub(f)->columns;
  f->origin_t = KM_ARENA_NEW(&f->arena, double, n);
  f->branch_t = KM_ARENA_NEW(&f->arena, double, n);
  f->origin = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *n);
  f->branch_pose = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_node_curve_reserve(&f->curve, (int)n, &f->arena) && km_continuation_reserve(&f->c, &f->arena);
}

/* Computes the tangent in which `column` moves with `sign` and the others least. */
static bool first_tangent(km_arc_motion *f, int column, double sign) {
  memset(f->c.move, 0, (size_t)km_arc_motion_sub(f)->columns * sizeof *f->c.move);
  f->c.move[column] = sign;
  return km_continuation_tangent(&f->c, f->c.move, f->c.history.t);
}

/* Returns the column with the largest mobility number; the first of those that are equal to rounding. */
static int find_most_mobile_column(const km_arc_motion *f) {
  km_state *s = f->c.state;
  int best = 0;
  if (f->c.constant_rank.is_active)
    km_mobility_numbers(f->c.constant_rank.Z, km_arc_motion_sub(f)->columns, f->c.constant_rank.count, s->work);
  else
    km_state_mobility_numbers(f->c.mechanism, s, f->c.substructure, s->work);
  for (int k = 1; k < km_arc_motion_sub(f)->columns; ++k)
    if (s->work[k] > 1.000001 * s->work[best])
      best = k;
  return best;
}

/* Returns the first substructure with a freedom; -1: none. */
static int find_mobile_substructure(const km_mechanism *m, km_state *s) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_update_and_search_pivots(m, s, i, KM_NO_DRIVER, 0.0);
    if (km_factor_freedom(s->factor[i]) > 0)
      return i;
  }
  return -1;
}

static km_status start_at_regular_configuration(km_arc_motion *f, int coordinate, double sign, km_error *error) {
  const km_mechanism *m = f->c.mechanism;
  if (!allocate(f))
    return km_fail(error, KM_MEMORY, "out of memory for following a motion");
  km_update_and_search_pivots(m, f->c.state, f->c.substructure, KM_NO_DRIVER, 0.0);
  f->freedom = km_factor_freedom(f->c.state->factor[f->c.substructure]);
  if (!km_constant_rank_begin(&f->c.constant_rank, m, f->c.state, f->c.substructure, KM_NO_DRIVER, &f->arena))
    return km_fail(error, KM_MEMORY, "out of memory for following a motion");
  int column = coordinate >= 0 ? m->column_of[coordinate] : find_most_mobile_column(f);
  if (f->freedom == 0 || !first_tangent(f, column, sign))
    return km_fail(error, KM_NO_RESULT, "nothing moves: %s",
                   f->freedom ? "the joint that should is at a dead point"
                              : "the mechanism is a structure at this pose");
  km_step_history_set_reference(&f->c.history, f->c.state->factor[f->c.substructure]);
  km_arc_motion_save_start(f);
  km_arc_motion_set_origin(f);
  return KM_OK;
}

/* Selects a branch if the start is a branch point, where the null space mixes the directions of all branches. */
static km_status start_at_branch_point(km_arc_motion *f, km_error *error) {
  double *directions = KM_NEW(double, KM_MAX_BRANCHES *(size_t)km_arc_motion_sub(f)->columns);
  if (!directions)
    return km_fail(error, KM_MEMORY, "out of memory for the branch points");
  f->start_branches = km_branch_directions(f->c.mechanism, f->c.state, f->c.substructure, directions);
  if (f->start_branches > 0)
    km_arc_motion_start_branch(f, directions, f->start_branches);
  km_free(directions);
  return f->start_branches < 0 ? km_fail(error, KM_MEMORY, "out of memory for the branch points") : KM_OK;
}

km_status km_arc_motion_create(const km_mechanism *m, km_state *s, int coordinate, double sign, bool ignore_limits,
                               km_arc_motion **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_state(m, s, error);
  if (!fits)
    fits = coordinate == -1 ? KM_OK : km_check_index(coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  int substructure = coordinate >= 0 ? m->substructure_of[coordinate] : find_mobile_substructure(m, s);
  if (coordinate >= 0 && (substructure < 0 || km_state_is_fixed(s, coordinate)))
    return km_fail(error, KM_USAGE, "joint \"%s\" is %s; expected a free joint of a loop",
                   m->model->coordinates[coordinate].label, km_state_is_fixed(s, coordinate) ? "held" : "in no loop");
  if (substructure < 0)
    return km_fail(error, KM_NO_RESULT, "nothing moves: the mechanism has no loop with a freedom at this pose");
  km_arc_motion *f = KM_NEW(km_arc_motion, 1);
  if (!f)
    return km_fail(error, KM_MEMORY, "out of memory for following a motion");
  *f = (km_arc_motion){.c = {.mechanism = m,
                             .state = s,
                             .substructure = substructure,
                             .coordinate = KM_NO_DRIVER,
                             .column = KM_NO_DRIVER,
                             .ignore_limits = ignore_limits},
                       .largest = km_longest_arc_step,
                       .limit = -1};
  f->probe_start = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *(size_t)km_arc_motion_sub(f)->columns);
  if (!f->probe_start || !km_step_history_reserve(&f->probe_history, &f->c, &f->arena)) {
    km_arc_motion_free(f);
    return km_fail(error, KM_MEMORY, "out of memory for following a motion");
  }
  km_status status = start_at_regular_configuration(f, coordinate, sign < 0.0 ? -1.0 : 1.0, error);
  if (!status)
    status = f->c.constant_rank.is_active ? KM_OK : start_at_branch_point(f, error);
  if (status)
    km_arc_motion_free(f);
  else
    *out = f;
  return status;
}

void km_arc_motion_free(km_arc_motion *f) {
  if (!f)
    return;
  km_arena_free(&f->arena);
  km_free(f);
}

int km_arc_motion_start_branches(const km_arc_motion *f) {
  if (!f)
    return 0;
  return f->start_branches;
}

int km_arc_motion_substructure(const km_arc_motion *f) {
  if (!f)
    return -1;
  return f->c.substructure;
}
double km_arc_motion_length(const km_arc_motion *f) {
  if (!f)
    return nan("");
  return f->s;
}
int km_arc_motion_limit(const km_arc_motion *f) {
  if (!f)
    return -1;
  return f->limit;
}
