/* Making drives, and coming back to a place of one. */
#include "kinematics/drive.h"

#include "base/check.h"
#include "kinematics/loops.h"

#include <string.h>

static bool allocate(km_drive *d, const km_substructure *sub) {
  size_t n = (size_t)sub->columns;
  double **arrays[] = {&d->t, &d->last_t, &d->last_move, &d->next_t, &d->move};
  double **poses[] = {&d->saved, &d->near, &d->far};
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i)
    *arrays[i] = KM_ARENA_NEW(&d->arena, double, n);
  for (size_t i = 0; i < sizeof poses / sizeof *poses; ++i)
    *poses[i] = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_least_path_reserve(&d->path, sub->columns, &d->arena) &&
         km_partition_reserve_like(&d->reference, &d->state->partition[d->substructure], sub->rows, sub->columns,
                                   &d->arena);
}

static bool allocate_mark(km_drive *d, const km_substructure *sub) {
  km_drive_place *k = &d->mark;
  size_t n = (size_t)sub->columns;
  k->t = KM_ARENA_NEW(&d->arena, double, n);
  k->last_t = KM_ARENA_NEW(&d->arena, double, n);
  k->last_move = KM_ARENA_NEW(&d->arena, double, n);
  k->pose = KM_ARENA_NEW(&d->arena, double, KM_SAVED_PER_COLUMN *n);
  return km_partition_reserve_like(&k->reference, &d->state->partition[d->substructure], sub->rows, sub->columns,
                                   &d->arena);
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
                  .s = s->q[coordinate] / m->unit[coordinate],
                  .largest = km_drive_longest};
  const km_substructure *sub = d->substructure >= 0 ? &m->substructures[d->substructure] : NULL;
  if (sub && (!allocate(d, sub) || !allocate_mark(d, sub))) {
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

void km_drive_mark(km_drive *d) {
  if (!d)
    return;
  km_drive_place *k = &d->mark;
  d->marked = true;
  if (d->substructure < 0) {
    k->s = d->state->q[d->coordinate];
    return;
  }
  size_t bytes = (size_t)km_drive_driven(d)->columns * sizeof *d->t;
  k->s = d->s;
  k->largest = d->largest;
  k->stopped = d->stopped;
  k->last_h = d->last_h;
  k->crossings = d->crossings;
  k->known = d->known;
  memcpy(k->t, d->t, bytes);
  memcpy(k->last_t, d->last_t, bytes);
  memcpy(k->last_move, d->last_move, bytes);
  km_state_save(d->state, km_drive_driven(d), k->pose);
  km_partition_copy_pivots(&k->reference, &d->reference);
}

void km_drive_return(km_drive *d) {
  if (!d || !d->marked)
    return;
  const km_drive_place *k = &d->mark;
  if (d->substructure < 0) {
    d->state->q[d->coordinate] = k->s;
    return;
  }
  size_t bytes = (size_t)km_drive_driven(d)->columns * sizeof *d->t;
  d->s = k->s;
  d->largest = k->largest;
  d->stopped = k->stopped;
  d->last_h = k->last_h;
  d->crossings = k->crossings;
  d->known = k->known;
  memcpy(d->t, k->t, bytes);
  memcpy(d->last_t, k->last_t, bytes);
  memcpy(d->last_move, k->last_move, bytes);
  km_state_restore(d->state, km_drive_driven(d), k->pose);
  km_partition_copy_pivots(&d->reference, &k->reference);
  km_loops_update(d->mechanism, d->state, km_drive_driven(d));
  km_state_forget_pivots(d->state, d->substructure);
}
