/* Making drives, and coming back to a place of one. */
#include "kinematics/drive.h"

#include "base/check.h"
#include "kinematics/loops.h"

#include <string.h>

static bool reserve_place(km_drive *d, const km_substructure *sub, km_drive_place *place) {
  size_t n = (size_t)sub->columns;
  place->t = KM_ARENA_NEW(&d->arena, double, n);
  place->last_t = KM_ARENA_NEW(&d->arena, double, n);
  place->last_move = KM_ARENA_NEW(&d->arena, double, n);
  return km_partition_reserve_like(&place->reference, &d->state->partition[d->substructure], sub->rows, sub->columns,
                                   &d->arena);
}

static bool allocate(km_drive *d, const km_substructure *sub) {
  size_t n = (size_t)sub->columns;
  double **poses[] = {&d->saved, &d->near, &d->far, &d->mark_pose};
  d->next_t = KM_ARENA_NEW(&d->arena, double, n);
  d->move = KM_ARENA_NEW(&d->arena, double, n);
  for (size_t i = 0; i < sizeof poses / sizeof *poses; ++i)
    *poses[i] = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_least_path_reserve(&d->path, sub->columns, &d->arena) && reserve_place(d, sub, &d->here) &&
         reserve_place(d, sub, &d->mark);
}

km_status km_drive_create(const km_mechanism *m, km_state *s, int coordinate, bool ignore_limits, km_drive **out,
                          km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_state(m, s, error);
  if (!fits)
    fits = km_check_index(coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  const char *label = m->model->coordinates[coordinate].label;
  if (m->held[coordinate])
    return km_fail(error, KM_USAGE, "joint \"%s\" is held; expected a driver that is free to move", label);
  if (m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE,
                   "\"%s\" is a component of a rotation vector; expected a driver with a coordinate of its own "
                   "(a spherical joint can be held, not driven)",
                   label);
  km_drive *d = KM_NEW(km_drive, 1);
  if (!d)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  *d = (km_drive){.mechanism = m,
                  .state = s,
                  .coordinate = coordinate,
                  .substructure = m->substructure_of[coordinate],
                  .column = m->column_of[coordinate],
                  .ignore_limits = ignore_limits,
                  .here = {.s = s->q[coordinate] / m->unit[coordinate], .largest = km_drive_longest}};
  const km_substructure *sub = d->substructure >= 0 ? &m->substructures[d->substructure] : NULL;
  if (sub && !allocate(d, sub)) {
    km_drive_free(d);
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  *out = d;
  return KM_OK;
}

void km_drive_free(km_drive *d) {
  if (!d)
    return;
  km_arena_free(&d->arena);
  km_free(d);
}

/* Each place keeps its own arrays. */
static void copy_place(km_drive_place *to, const km_drive_place *from, int columns) {
  size_t bytes = (size_t)columns * sizeof *to->t;
  to->s = from->s;
  to->largest = from->largest;
  to->stopped = from->stopped;
  to->crossings = from->crossings;
  to->known = from->known;
  to->last_h = from->last_h;
  memcpy(to->t, from->t, bytes);
  memcpy(to->last_t, from->last_t, bytes);
  memcpy(to->last_move, from->last_move, bytes);
  km_partition_copy_pivots(&to->reference, &from->reference);
}

void km_drive_mark(km_drive *d) {
  if (!d)
    return;
  d->marked = true;
  if (d->substructure < 0) {
    d->mark.s = d->state->q[d->coordinate];
    return;
  }
  copy_place(&d->mark, &d->here, km_drive_driven(d)->columns);
  km_state_save(d->state, km_drive_driven(d), d->mark_pose);
}

void km_drive_return(km_drive *d) {
  if (!d || !d->marked)
    return;
  if (d->substructure < 0) {
    d->state->q[d->coordinate] = d->mark.s;
    return;
  }
  copy_place(&d->here, &d->mark, km_drive_driven(d)->columns);
  km_state_restore(d->state, km_drive_driven(d), d->mark_pose);
  km_loops_update(d->mechanism, d->state, km_drive_driven(d));
  km_state_forget_pivots(d->state, d->substructure);
}
