/* Creates driven motions; stores and restores their snapshots. */
#include "continuation/batch/batch.h"

#include "base/arguments.h"
#include "kinematics/loop_equations.h"

#include <string.h>

static bool allocate_snapshot(km_driver_motion *d, km_driver_motion_snapshot *snapshot) {
  snapshot->pose =
      KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *(size_t)km_driver_motion_substructure(d)->columns);
  return km_step_history_reserve(&snapshot->history, &d->c, &d->arena);
}

static bool allocate(km_driver_motion *d) {
  size_t n = (size_t)km_driver_motion_substructure(d)->columns;
  d->regular.pose = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  d->from_bridge = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_node_curve_reserve(&d->bridge.curve, (int)n, &d->arena) &&
         km_minimum_norm_path_reserve(&d->path, (int)n, &d->arena) && km_continuation_reserve(&d->c, &d->arena) &&
         allocate_snapshot(d, &d->mark) && allocate_snapshot(d, &d->before_bridge);
}

static km_status check_driver(const km_mechanism *m, const km_state *s, int coordinate, km_error *error) {
  km_status fits = km_check_state(m, s, error);
  if (!fits)
    fits = km_check_index(coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  const char *label = m->model->coordinates[coordinate].label;
  if (km_state_is_fixed(s, coordinate))
    return km_fail(error, KM_USAGE, "joint \"%s\" is held; expected a driver that is free to move", label);
  if (m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE,
                   "\"%s\" is a component of a rotation vector; expected a driver with a coordinate of its own "
                   "(a spherical joint can be held, not driven)",
                   label);
  return KM_OK;
}

km_status km_driver_motion_create_in(km_arena *memory, const km_mechanism *m, km_state *s, int coordinate,
                                     bool ignore_limits, km_driver_motion **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = check_driver(m, s, coordinate, error);
  if (fits)
    return fits;
  km_arena arena = km_arena_reuse(memory);
  km_driver_motion *d = KM_ARENA_NEW(&arena, km_driver_motion, 1);
  if (!d) {
    km_arena_free(&arena); /* memory of an earlier motion can be too small */
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  *d = (km_driver_motion){.arena = arena,
                          .c = {.mechanism = m,
                                .state = s,
                                .coordinate = coordinate,
                                .substructure = m->substructure_of[coordinate],
                                .column = m->column_of[coordinate],
                                .ignore_limits = ignore_limits},
                          .current = {.s = s->q[coordinate] / m->unit[coordinate], .largest = km_longest_step}};
  if (d->c.substructure >= 0 && !allocate(d)) {
    km_driver_motion_free(d);
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  *out = d;
  return KM_OK;
}

km_status km_driver_motion_create(const km_mechanism *m, km_state *s, int coordinate, bool ignore_limits,
                                  km_driver_motion **out, km_error *error) {
  return km_driver_motion_create_in(NULL, m, s, coordinate, ignore_limits, out, error);
}

void km_driver_motion_free_into(km_arena *memory, km_driver_motion *d) {
  if (!d)
    return;
  km_arena arena = d->arena; /* the motion itself lies in its arena */
  km_arena_recycle(&arena, memory);
}

void km_driver_motion_free(km_driver_motion *d) {
  km_driver_motion_free_into(NULL, d);
}

void km_driver_motion_store(km_driver_motion *d, km_driver_motion_snapshot *snapshot) {
  snapshot->is_set = true;
  snapshot->position = d->current;
  snapshot->position.pivot_driver = d->c.state->pivot_driver[d->c.substructure];
  km_step_history_copy(&snapshot->history, &d->c.history, km_driver_motion_substructure(d)->columns);
  km_state_save(d->c.state, km_driver_motion_substructure(d), snapshot->pose);
}

void km_driver_motion_save(km_driver_motion *d) {
  if (!d)
    return;
  km_driver_motion_write_back(d);
  d->mark.is_set = true;
  if (d->c.substructure < 0)
    d->mark.position.s = d->c.state->q[d->c.coordinate];
  else
    km_driver_motion_store(d, &d->mark);
}

/* Restores the pivots of the snapshot and refactors J with them. False if they were searched for another driver or
 * became unstable. */
static bool restore_pivots(km_driver_motion *d) {
  km_state *s = d->c.state;
  int sub = d->c.substructure;
  km_factor *p = s->factor[sub];
  if (d->current.pivot_driver != d->c.column || km_factor_search_count(d->c.history.reference) == 0)
    return false;
  km_factor_copy_pivots(p, d->c.history.reference);
  s->pivot_driver[sub] = d->c.column;
  return km_factor_refactor(p, km_state_jacobian(s, km_driver_motion_substructure(d)), KM_BASIS_SHORT);
}

void km_driver_motion_restore_snapshot(km_driver_motion *d, const km_driver_motion_snapshot *snapshot) {
  km_driver_motion_write_back(d);
  d->current = snapshot->position;
  km_step_history_copy(&d->c.history, &snapshot->history, km_driver_motion_substructure(d)->columns);
  km_state_restore(d->c.state, km_driver_motion_substructure(d), snapshot->pose);
  km_loops_update(d->c.mechanism, d->c.state, km_driver_motion_substructure(d));
  if (!restore_pivots(d))
    km_state_invalidate_pivots(d->c.state, d->c.substructure);
}

void km_driver_motion_restore(km_driver_motion *d) {
  if (!d || !d->mark.is_set)
    return;
  if (d->c.substructure < 0)
    d->c.state->q[d->c.coordinate] = d->mark.position.s;
  else
    km_driver_motion_restore_snapshot(d, &d->mark);
}

bool km_driver_motion_save_passed(km_driver_motion *d) {
  if (d->c.substructure < 0 || km_factor_freedom(d->c.state->factor[d->c.substructure]) <= 1) {
    d->passed[0].is_set = d->passed[1].is_set = false;
    return true;
  }
  km_driver_motion_snapshot oldest = d->passed[1];
  d->passed[1] = d->passed[0];
  d->passed[0] = oldest;
  if (!oldest.pose && !allocate_snapshot(d, &d->passed[0]))
    return false;
  km_driver_motion_write_back(d);
  km_driver_motion_store(d, &d->passed[0]);
  return true;
}

bool km_driver_motion_restore_previous(km_driver_motion *d, double s) {
  double goal = s * km_driver_motion_factor(d);
  for (int i = 0; i < 2; ++i)
    if (d->passed[i].is_set && (goal - d->passed[i].position.s) * (d->mark.position.s - goal) > 0.0) {
      km_driver_motion_restore_snapshot(d, &d->passed[i]);
      return true;
    }
  return false;
}
