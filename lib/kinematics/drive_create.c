/* Making drives, and coming back to a place of one. */
#include "kinematics/drive_lanes.h"

#include "base/check.h"
#include "kinematics/loops.h"

#include <string.h>

static bool allocate(km_drive *d) {
  size_t n = (size_t)km_drive_driven(d)->columns;
  double **poses[] = {&d->near, &d->far, &d->mark_pose};
  for (size_t i = 0; i < sizeof poses / sizeof *poses; ++i)
    *poses[i] = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_least_path_reserve(&d->path, (int)n, &d->arena) && km_continuation_reserve(&d->c, &d->arena) &&
         km_course_reserve(&d->mark_course, &d->c, &d->arena);
}

static km_status check(const km_mechanism *m, const km_state *s, int coordinate, km_error *error) {
  km_status fits = km_check_state(m, s, error);
  if (!fits)
    fits = km_check_index(coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  const char *label = m->model->coordinates[coordinate].label;
  if (km_state_holds(s, coordinate))
    return km_fail(error, KM_USAGE, "joint \"%s\" is held; expected a driver that is free to move", label);
  if (m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE,
                   "\"%s\" is a component of a rotation vector; expected a driver with a coordinate of its own "
                   "(a spherical joint can be held, not driven)",
                   label);
  return KM_OK;
}

km_status km_drive_create_in(km_arena *memory, const km_mechanism *m, km_state *s, int coordinate, bool ignore_limits,
                             km_drive **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = check(m, s, coordinate, error);
  if (fits)
    return fits;
  km_arena arena = km_arena_take(memory);
  km_drive *d = KM_ARENA_NEW(&arena, km_drive, 1);
  if (!d) {
    km_arena_free(&arena); /* what was taken may be too small for a drive */
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  *d = (km_drive){.arena = arena,
                  .c = {.mechanism = m,
                        .state = s,
                        .coordinate = coordinate,
                        .substructure = m->substructure_of[coordinate],
                        .column = m->column_of[coordinate],
                        .ignore_limits = ignore_limits},
                  .here = {.s = s->q[coordinate] / m->unit[coordinate], .largest = km_drive_longest}};
  if (d->c.substructure >= 0 && !allocate(d)) {
    km_drive_free(d);
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  *out = d;
  return KM_OK;
}

km_status km_drive_create(const km_mechanism *m, km_state *s, int coordinate, bool ignore_limits, km_drive **out,
                          km_error *error) {
  return km_drive_create_in(NULL, m, s, coordinate, ignore_limits, out, error);
}

void km_drive_free_into(km_arena *memory, km_drive *d) {
  if (!d)
    return;
  km_arena arena = d->arena; /* in which `d` lies */
  km_arena_give(&arena, memory);
}

void km_drive_free(km_drive *d) {
  km_drive_free_into(NULL, d);
}

void km_drive_mark(km_drive *d) {
  if (!d)
    return;
  km_drive_settle(d);
  d->marked = true;
  if (d->c.substructure < 0) {
    d->mark.s = d->c.state->q[d->c.coordinate];
    return;
  }
  d->mark = d->here;
  d->mark.pivoted = d->c.state->pivoted[d->c.substructure];
  km_course_copy(&d->mark_course, &d->c.course, km_drive_driven(d)->columns);
  km_state_save(d->c.state, km_drive_driven(d), d->mark_pose);
}

/* The pivots of the mark serve again. False where they were another's, or don't fit. */
static bool take_pivots_back(km_drive *d) {
  km_state *s = d->c.state;
  int sub = d->c.substructure;
  km_partition *p = &s->partition[sub];
  if (d->here.pivoted != d->c.column || d->c.course.reference.searches == 0)
    return false;
  km_partition_copy_pivots(p, &d->c.course.reference);
  s->pivoted[sub] = d->c.column;
  return km_partition_refactor(p, km_state_jacobian(s, km_drive_driven(d)));
}

void km_drive_return(km_drive *d) {
  if (!d || !d->marked)
    return;
  if (d->c.substructure < 0) {
    d->c.state->q[d->c.coordinate] = d->mark.s;
    return;
  }
  km_drive_settle(d);
  d->here = d->mark;
  km_course_copy(&d->c.course, &d->mark_course, km_drive_driven(d)->columns);
  km_state_restore(d->c.state, km_drive_driven(d), d->mark_pose);
  km_loops_update(d->c.mechanism, d->c.state, km_drive_driven(d));
  if (!take_pivots_back(d))
    km_state_forget_pivots(d->c.state, d->c.substructure);
}
