/* Directions of the branches through a branch point, and departure along one of them (docs/theory.md 4.10).
 *
 *   q₀ + h t with h max|t_j| = 5e-3, closed; with several freedoms the configuration nearest to q₀ (4.8)
 *
 * The branch is the one that moves the driver fastest, or with several freedoms the one with the shortest step. A
 * motion by arc length that starts at a branch point takes the branch nearest to its tangent instead
 * (continuation/arc_branch_point.c); a sweep by arc length takes the branch of its plan (sweep/arc_sweep.c). */
#include "base/number/tolerances.h"
#include "local/bifurcation.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/nearest_configuration.h"
#include "local/constant_rank.h"
#include "local/local_private.h"

#include <string.h>

/* Branch directions: confirmed or undecided tangents at a configuration of deficient rank. */
int km_local_find_branches(km_local *l, double *directions) {
  int found = 0;
  double length;
  if (!l->has_redundant_rows || !km_local_reserve_tangents(l, l->has_basis))
    return 0;
  double *known = KM_ARENA_NEW(l->arena, double, KM_MAX_BRANCHES *(size_t)l->size);
  l->min_verdict = KM_TANGENT_UNDECIDED; /* undecided tangents count, since rounded data have branches too */
  if (!known || km_local_is_regular(l))
    return 0;
  while (found < KM_MAX_BRANCHES && km_local_find_next(l, known, found, &length)) {
    memcpy(known + (size_t)found * (size_t)l->size, l->a, (size_t)l->size * sizeof *known);
    km_local_direction(l, l->a, directions + (size_t)found++ * (size_t)l->sub->columns);
  }
  return found;
}

int km_branch_directions(const km_mechanism *m, km_state *s, int index, double *directions) {
  km_arena arena = {0};
  km_local *l = km_local_create(m, s, index, NULL, 0.0, &arena);
  int found = l ? km_local_find_branches(l, directions) : 0;
  if (l && !arena.failed && !km_local_has_full_row_rank(l)) {
    km_state_restore(s, l->sub, l->origin);
    km_update_and_search_pivots(m, s, index, KM_NO_DRIVER, 0.0);
  }
  found = arena.failed ? -1 : found;
  km_local_free(l);
  km_arena_free(&arena);
  return found;
}

/* True for a permanently shaky mechanism: its rank deficiency is no branch point. */
static bool is_permanently_shaky(const km_local *l) {
  km_constant_rank motion = {0};
  km_constant_rank_begin(&motion, l->m, l->s, l->index, KM_NO_DRIVER, l->arena);
  return motion.is_active;
}

/* Direction that moves a column fastest, near-ties by position; -1: none moves it. */
static int fastest_direction(const double *directions, int count, int columns, int column) {
  int best = -1;
  double largest = 0.0;
  for (int i = 0; i < count; ++i) {
    double rate = fabs(directions[(size_t)i * (size_t)columns + (size_t)column]);
    if (rate > 1.000001 * largest) {
      largest = rate;
      best = i;
    }
  }
  return best;
}

/* A step from a branch point. */
typedef struct branch_departure {
  const km_mechanism *m;
  km_state *s;
  int index, column;
  const km_substructure *sub;
  km_arena *arena;
  double *origin, *last_accepted,
      *best;    /* saved configurations: the branch point, the last accepted one, the best one */
  double *step; /* [columns] */
} branch_departure;

/* Restores the branch point and moves by length · direction. */
static void move_from_branch_point(const branch_departure *d, const double *direction, double length) {
  for (int k = 0; k < d->sub->columns; ++k)
    d->step[k] = length * direction[k];
  km_state_restore(d->s, d->sub, d->origin);
  km_state_move(d->m, d->s, d->sub, d->step);
  km_state_invalidate_pivots(d->s, d->index);
}

/* Closes the loops with `driver` fixed: `is_full` by full closing, else with the present pivots of a nearby
 * configuration. Only rows are requested: few rows are far from dependent here, and null vectors
 * would be long. */
static bool close_with_fixed(const branch_departure *d, int driver, bool is_full) {
  const km_pivoting pivoting = {.driver = driver, .driver_never_pivot = true, .basis = KM_BASIS_NONE};
  km_closure evidence;
  return (is_full ? km_loops_close_fully : km_loops_close_by)(d->m, d->s, d->index, &pivoting, &evidence) == KM_CLOSED;
}

/* Moves to the closed configuration nearest to the branch point q₀, with the driver fixed. Homotopy: nearest
 * configurations to y = q − fraction (q − q₀), from the last one q; fraction grows to 1, where y = q₀ and all rows
 * close the loops. The state stays if a stage finds none. */
static void approach_nearest(branch_departure *d) {
  enum { MAX_STEPS = 20 };
  km_nearest_configuration closest;
  if (d->m->ball_count > 0 || !km_nearest_configuration_reserve(&closest, d->m, d->sub, d->arena))
    return;
  double fraction = 0.5, *displacement = closest.displacement;
  bool is_nearest = false;
  for (int i = 0; i < MAX_STEPS && !is_nearest; ++i) {
    km_state_save(d->s, d->sub, d->last_accepted);
    km_state_difference(d->s, d->sub, d->origin, displacement);
    double distance_before = km_step_length(d->m, d->sub, displacement);
    for (int k = 0; k < d->sub->columns; ++k)
      displacement[k] *= fraction;
    bool found =
        km_nearest_configuration_find(&closest, d->m, d->s, d->index, d->column, d->s->factor[d->index], displacement);
    km_state_difference(d->s, d->sub, d->origin, displacement);
    double distance_after = km_step_length(d->m, d->sub, displacement);
    const bool last = fraction == 1.0;
    found = found && distance_after <= distance_before && close_with_fixed(d, d->column, last);
    is_nearest = found && last;
    fraction = !found ? 0.5 * fraction : distance_after > 0.9 * distance_before ? fmin(1.0, 2.0 * fraction) : fraction;
    if (!found)
      km_state_restore(d->s, d->sub, d->last_accepted);
  }
}

/* Departs along a direction. False if one freedom remains there, where the step is complete. */
static bool depart_along(branch_departure *d, const double *direction, double driver_step) {
  double most = 0.0, rate = direction[d->column], side = driver_step * rate < 0.0 ? -1.0 : 1.0;
  for (int k = 0; k < d->sub->columns; ++k)
    most = fmax(most, fabs(direction[k]));
  double length = 0.1 * km_longest_arc_step / most;
  move_from_branch_point(d, direction, length);
  close_with_fixed(d, KM_NO_DRIVER, true);
  if (km_factor_freedom(d->s->factor[d->index]) <= 1)
    return false;
  km_state_save(d->s, d->sub, d->last_accepted);
  length = driver_step != 0.0 ? fmin(length, fabs(driver_step / rate)) : length;
  move_from_branch_point(d, direction, side * length);
  if (!close_with_fixed(d, d->column, true))
    km_state_restore(d->s, d->sub, d->last_accepted);
  else if (length * fabs(rate) > 10.0 * sqrt(km_solved_rounding)) /* loops open by the square of the step */
    approach_nearest(d);
  return true;
}

/* Length of the step from the branch point, relative to the coordinate's part. */
static double relative_length(const branch_departure *d) {
  km_state_difference(d->s, d->sub, d->origin, d->step);
  return km_step_length(d->m, d->sub, d->step) / fabs(d->step[d->column]);
}

/* Several freedoms: moves to the result of the direction with the shortest relative step. */
static void choose_shortest(branch_departure *d, const double *directions, int count, int first, double driver_step) {
  double shortest = relative_length(d);
  km_state_save(d->s, d->sub, d->best);
  for (int i = 0; i < count; ++i) {
    const double *direction = directions + (size_t)i * (size_t)d->sub->columns;
    if (i == first || direction[d->column] == 0.0 || !depart_along(d, direction, driver_step) ||
        !(relative_length(d) < shortest))
      continue;
    shortest = relative_length(d);
    km_state_save(d->s, d->sub, d->best);
  }
  km_state_restore(d->s, d->sub, d->best);
}

/* Departs from the branch point of an analysis. */
static km_branch_exit depart(km_local *l, int column, double driver_step, km_arena *arena) {
  size_t n = (size_t)l->sub->columns;
  km_branch_exit out = {0};
  branch_departure d = {.m = l->m, .s = l->s, .index = l->index, .column = column, .sub = l->sub, .arena = arena};
  double *directions = KM_ARENA_NEW(arena, double, KM_MAX_BRANCHES *n);
  d.origin = l->origin;
  d.last_accepted = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  d.best = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *n);
  d.step = KM_ARENA_NEW(arena, double, n);
  out.branch_count = arena->failed ? 0 : km_local_find_branches(l, directions);
  km_local_restore(l);
  int best = fastest_direction(directions, out.branch_count, l->sub->columns, column);
  if (best >= 0) {
    out.has_further_freedoms = depart_along(&d, directions + (size_t)best * n, driver_step);
    if (out.has_further_freedoms)
      choose_shortest(&d, directions, out.branch_count, best, driver_step);
    km_state_invalidate_pivots(l->s, l->index);
  }
  return out;
}

/* Leaves a branch point along the branch that moves the coordinate fastest. */
km_branch_exit km_branch_depart(const km_mechanism *m, km_state *s, int coordinate, double driver_step) {
  int index = m->substructure_of[coordinate];
  km_branch_exit out = {0};
  km_arena arena = {0};
  if (index < 0 || km_state_is_fixed(s, coordinate))
    return out; /* a fixed coordinate cannot parametrise a branch */
  km_local *l = km_local_create(m, s, index, NULL, 0.0, &arena);
  if (l && l->has_redundant_rows && km_local_reserve_tangents(l, l->has_basis) && !is_permanently_shaky(l))
    out = depart(l, m->column_of[coordinate], driver_step * m->factor[coordinate] / m->unit[coordinate], &arena);
  out.branch_count = arena.failed ? -1 : out.branch_count;
  km_local_free(l);
  km_arena_free(&arena);
  return out;
}
