/* Unit directions of motion along a sweep: rows and intermediate steps, kept for the last two rows. */
#include "sweep/motion_directions.h"

#include <math.h>
#include <string.h>

/* A step nearer to a row than this part of the interval counts as the row itself. */
static const double same_position = 1e-6;

void km_unit_direction(const km_mechanism *m, const double *rates, double *z) {
  double sum = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    z[c] = m->scale[c] * rates[c];
    sum += z[c] * z[c];
  }
  double inverse = 1.0 / sqrt(sum);
  for (int c = 0; c < m->coordinate_count; ++c)
    z[c] *= inverse;
}

void km_directions_free(km_directions *d) {
  km_free(d->s);
  km_free(d->z);
}

static double *direction_at(const km_directions *d, int i) {
  return d->z + (size_t)i * d->coordinates;
}

/* Moves the entries from `from` on to `to`, overwriting those between. */
static void move_entries(km_directions *d, int from, int to) {
  size_t count = (size_t)(d->count - from);
  memmove(d->s + to, d->s + from, count * sizeof *d->s);
  memmove(direction_at(d, to), direction_at(d, from), count * d->coordinates * sizeof *d->z);
  d->count += to - from;
}

static bool reserve_entry(km_directions *d) {
  size_t entries_reserved = (size_t)d->capacity, entries = entries_reserved * d->coordinates,
         need = (size_t)d->count + 1;
  void *s = d->s, *z = d->z;
  if (d->count < d->capacity)
    return true;
  bool grown = km_reserve(&s, &entries_reserved, need, sizeof *d->s);
  d->s = s;
  grown = grown && km_reserve(&z, &entries, entries_reserved * d->coordinates, sizeof *d->z);
  d->z = z;
  d->capacity = grown ? (int)entries_reserved : d->capacity;
  d->failed = d->failed || !grown;
  return grown;
}

/* Returns the distance of s from the i-th entry, positive along the sweep. */
static double distance_ahead(const km_directions *d, double s, int i) {
  return d->sense * (s - d->s[i]);
}

void km_directions_step(km_directions *d, const km_mechanism *m, double s, const double *rates) {
  if (d->row < 0 || !(distance_ahead(d, s, d->count - 1) > 0.0) || !reserve_entry(d))
    return;
  d->s[d->count] = s;
  km_unit_direction(m, rates, direction_at(d, d->count++));
}

double *km_directions_row(km_directions *d, double s) {
  if (!reserve_entry(d))
    return NULL;
  int first = d->row > 0 ? d->row - 1 : 0; /* entries before the row that has been the present one */
  move_entries(d, first, 0);
  d->last = d->row - first;
  d->row = d->last + 1;
  while (d->last >= 0 && d->row < d->count &&
         distance_ahead(d, s, d->row) > same_position * distance_ahead(d, s, d->row - 1))
    ++d->row;
  int behind = d->row;
  while (behind < d->count && distance_ahead(d, s, behind) >= 0.0)
    ++behind;
  move_entries(d, behind, d->row);
  move_entries(d, d->row, d->row + 1);
  d->s[d->row] = s;
  return direction_at(d, d->row);
}

void km_directions_clear(km_directions *d) {
  d->count = 0;
  d->last = d->row = -1;
}

void km_directions_skip(km_directions *d) {
  move_entries(d, d->row + 1, 0);
  d->last = d->row = -1;
}
