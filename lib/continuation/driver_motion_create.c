/* Making drives, and coming back to a place of one. */
#include "continuation/batch/batch.h"

#include "base/arguments.h"
#include "kinematics/loop_equations.h"

#include <string.h>

static bool reserve(km_driver_motion *d, km_driver_motion_snapshot *kept) {
  kept->pose = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *(size_t)km_driver_motion_substructure(d)->columns);
  return km_step_history_reserve(&kept->course, &d->c, &d->arena);
}

static bool allocate(km_driver_motion *d) {
  size_t n = (size_t)km_driver_motion_substructure(d)->columns;
  double **poses[] = {&d->near, &d->regular.pose, &d->from_bridge};
  for (size_t i = 0; i < sizeof poses / sizeof *poses; ++i)
    *poses[i] = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  d->bridge.nodes = KM_ARENA_NEW(&d->arena, double, KM_BRIDGE_NODES *KM_SAVED_PER_COLUMN *n);
  d->bridge.tangents = KM_ARENA_NEW(&d->arena, double, KM_BRIDGE_NODES *n);
  return km_minimum_norm_path_reserve(&d->path, (int)n, &d->arena) && km_continuation_reserve(&d->c, &d->arena) &&
         reserve(d, &d->mark) && reserve(d, &d->before_bridge);
}

static km_status check(const km_mechanism *m, const km_state *s, int coordinate, km_error *error) {
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
  km_status fits = check(m, s, coordinate, error);
  if (fits)
    return fits;
  km_arena arena = km_arena_take(memory);
  km_driver_motion *d = KM_ARENA_NEW(&arena, km_driver_motion, 1);
  if (!d) {
    km_arena_free(&arena); /* what was taken may be too small for a drive */
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  *d = (km_driver_motion){.arena = arena,
                          .c = {.mechanism = m,
                                .state = s,
                                .coordinate = coordinate,
                                .substructure = m->substructure_of[coordinate],
                                .column = m->column_of[coordinate],
                                .ignore_limits = ignore_limits},
                          .here = {.s = s->q[coordinate] / m->unit[coordinate], .largest = km_driver_longest_step}};
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
  km_arena arena = d->arena; /* in which `d` lies */
  km_arena_give(&arena, memory);
}

void km_driver_motion_free(km_driver_motion *d) {
  km_driver_motion_free_into(NULL, d);
}

void km_driver_motion_store(km_driver_motion *d, km_driver_motion_snapshot *kept) {
  kept->is_one = true;
  kept->place = d->here;
  kept->place.pivoted = d->c.state->pivot_driver[d->c.substructure];
  km_step_history_copy(&kept->course, &d->c.course, km_driver_motion_substructure(d)->columns);
  km_state_save(d->c.state, km_driver_motion_substructure(d), kept->pose);
}

void km_driver_motion_save(km_driver_motion *d) {
  if (!d)
    return;
  km_driver_motion_write_back(d);
  d->mark.is_one = true;
  if (d->c.substructure < 0)
    d->mark.place.s = d->c.state->q[d->c.coordinate];
  else
    km_driver_motion_store(d, &d->mark);
}

/* The pivots of the place serve again. False where they were another's, or don't fit. */
static bool take_pivots_back(km_driver_motion *d) {
  km_state *s = d->c.state;
  int sub = d->c.substructure;
  km_partition *p = &s->partition[sub];
  if (d->here.pivoted != d->c.column || d->c.course.reference.search_count == 0)
    return false;
  km_partition_copy_pivots(p, &d->c.course.reference);
  s->pivot_driver[sub] = d->c.column;
  return km_partition_refactor(p, km_state_jacobian(s, km_driver_motion_substructure(d)));
}

void km_driver_motion_recall(km_driver_motion *d, const km_driver_motion_snapshot *kept) {
  km_driver_motion_write_back(d);
  d->here = kept->place;
  km_step_history_copy(&d->c.course, &kept->course, km_driver_motion_substructure(d)->columns);
  km_state_restore(d->c.state, km_driver_motion_substructure(d), kept->pose);
  km_loops_update(d->c.mechanism, d->c.state, km_driver_motion_substructure(d));
  if (!take_pivots_back(d))
    km_state_invalidate_pivots(d->c.state, d->c.substructure);
}

void km_driver_motion_restore(km_driver_motion *d) {
  if (!d || !d->mark.is_one)
    return;
  if (d->c.substructure < 0)
    d->c.state->q[d->c.coordinate] = d->mark.place.s;
  else
    km_driver_motion_recall(d, &d->mark);
}

bool km_driver_motion_pass(km_driver_motion *d) {
  if (d->c.substructure < 0 || km_partition_freedom(&d->c.state->partition[d->c.substructure]) <= 1) {
    d->passed[0].is_one = d->passed[1].is_one = false;
    return true;
  }
  km_driver_motion_snapshot oldest = d->passed[1];
  d->passed[1] = d->passed[0];
  d->passed[0] = oldest;
  if (!oldest.pose && !reserve(d, &d->passed[0]))
    return false;
  km_driver_motion_write_back(d);
  km_driver_motion_store(d, &d->passed[0]);
  return true;
}

bool km_driver_motion_restore_previous(km_driver_motion *d, double s) {
  double goal = s * km_driver_motion_factor(d);
  for (int i = 0; i < 2; ++i)
    if (d->passed[i].is_one && (goal - d->passed[i].place.s) * (d->mark.place.s - goal) > 0.0) {
      km_driver_motion_recall(d, &d->passed[i]);
      return true;
    }
  return false;
}
