/* The last samples along a sweep: rows and intermediate steps, kept for the last two rows. */
#include "sweep/events/sample_window.h"

#include "base/memory.h"

#include <string.h>

void km_sample_window_free(km_sample_window *w) {
  km_free(w->s);
  km_free(w->value);
}

static double *sample_at(const km_sample_window *w, int i) {
  return w->value + (size_t)i * w->width;
}

/* Moves the samples from `from` on to `to`, overwriting those between. */
static void move_samples(km_sample_window *w, int from, int to) {
  size_t count = (size_t)(w->count - from);
  if (count > 0) {
    memmove(w->s + to, w->s + from, count * sizeof *w->s);
    memmove(sample_at(w, to), sample_at(w, from), count * w->width * sizeof *w->value);
  }
  w->count += to - from;
}

static bool reserve_sample(km_sample_window *w) {
  size_t capacity = (size_t)w->capacity, values = capacity * w->width, need = (size_t)w->count + 1;
  void *s = w->s, *value = w->value;
  if (w->count < w->capacity)
    return true;
  bool grown = km_reserve(&s, &capacity, need, sizeof *w->s);
  w->s = s;
  grown = grown && km_reserve(&value, &values, capacity * w->width, sizeof *w->value);
  w->value = value;
  w->capacity = grown ? (int)capacity : w->capacity;
  w->failed = w->failed || !grown;
  return grown;
}

/* Returns the distance of s from sample i, positive along the sweep. */
static double distance_ahead(const km_sample_window *w, double s, int i) {
  return w->sense * (s - w->s[i]);
}

double *km_sample_window_step(km_sample_window *w, double s) {
  if (w->row < 0 || !(distance_ahead(w, s, w->count - 1) > 0.0) || !reserve_sample(w))
    return NULL;
  w->s[w->count] = s;
  return sample_at(w, w->count++);
}

double *km_sample_window_row(km_sample_window *w, double s) {
  if (!reserve_sample(w))
    return NULL;
  int first = w->row > 0 ? w->row - 1 : 0; /* samples before the row that has been the present one */
  move_samples(w, first, 0);
  w->last = w->row - first;
  w->row = w->last + 1;
  while (w->last >= 0 && w->row < w->count &&
         distance_ahead(w, s, w->row) > km_same_position * distance_ahead(w, s, w->row - 1))
    ++w->row;
  int behind = w->row;
  while (behind < w->count && distance_ahead(w, s, behind) >= 0.0)
    ++behind;
  move_samples(w, behind, w->row);
  move_samples(w, w->row, w->row + 1);
  w->s[w->row] = s;
  return sample_at(w, w->row);
}

void km_sample_window_clear(km_sample_window *w) {
  w->count = 0;
  w->last = w->row = -1;
}
