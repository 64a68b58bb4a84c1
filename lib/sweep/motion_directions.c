/* Unit directions of motion along a sweep. */
#include "sweep/motion_directions.h"

#include <math.h>
#include <string.h>

/* A step that is nearer to a row, as part of the way to it, is the row itself. */
static const double same = 1e-6;

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

/* Those from `from` on come to `to`; the others up to there are lost. */
static void move(km_directions *d, int from, int to) {
  size_t count = (size_t)(d->count - from);
  memmove(d->s + to, d->s + from, count * sizeof *d->s);
  memmove(direction_at(d, to), direction_at(d, from), count * d->coordinates * sizeof *d->z);
  d->count += to - from;
}

static bool make_room(km_directions *d) {
  size_t places = (size_t)d->room, entries = places * d->coordinates, need = (size_t)d->count + 1;
  void *s = d->s, *z = d->z;
  if (d->count < d->room)
    return true;
  bool grown = km_reserve(&s, &places, need, sizeof *d->s);
  d->s = s;
  grown = grown && km_reserve(&z, &entries, places * d->coordinates, sizeof *d->z);
  d->z = z;
  d->room = grown ? (int)places : d->room;
  d->failed = d->failed || !grown;
  return grown;
}

/* How far s is from the i-th place, along the sweep. */
static double ahead(const km_directions *d, double s, int i) {
  return d->sense * (s - d->s[i]);
}

void km_directions_step(km_directions *d, const km_mechanism *m, double s, const double *rates) {
  if (d->row < 0 || !(ahead(d, s, d->count - 1) > 0.0) || !make_room(d))
    return;
  d->s[d->count] = s;
  km_unit_direction(m, rates, direction_at(d, d->count++));
}

double *km_directions_row(km_directions *d, double s) {
  if (!make_room(d))
    return NULL;
  int first = d->row > 0 ? d->row - 1 : 0; /* what lies before the row that was the present one up to now */
  move(d, first, 0);
  d->last = d->row - first;
  d->row = d->last + 1;
  while (d->last >= 0 && d->row < d->count && ahead(d, s, d->row) > same * ahead(d, s, d->row - 1))
    ++d->row;
  int behind = d->row;
  while (behind < d->count && ahead(d, s, behind) >= 0.0)
    ++behind;
  move(d, behind, d->row);
  move(d, d->row, d->row + 1);
  d->s[d->row] = s;
  return direction_at(d, d->row);
}

void km_directions_forget(km_directions *d) {
  d->count = 0;
  d->last = d->row = -1;
}

void km_directions_skip(km_directions *d) {
  move(d, d->row + 1, 0);
  d->last = d->row = -1;
}
