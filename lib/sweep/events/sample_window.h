/* The last samples of functions along a sweep: rows and steps between, in the order of the motion. Private to
 * sweep/. */
#ifndef KM_SWEEP_SAMPLE_WINDOW_H
#define KM_SWEEP_SAMPLE_WINDOW_H

#include <stdbool.h>
#include <stddef.h>

/* Relative distance of positions that are one: an event is located to 1e-9 of its position, and a step so near to a row
 * counts as the row. */
static const double km_same_position = 1e-8;

typedef struct km_sample_window {
  size_t width;      /* values in a sample */
  double sense;      /* sign of s along the sweep, ±1 */
  double *s, *value; /* [count], [count × width] */
  int count, capacity;
  int last, row; /* indices of the previous row and of the present one, -1: none; behind it are later steps */
  bool failed;   /* no memory: some steps are missing */
} km_sample_window;

void km_sample_window_free(km_sample_window *window);
/* Adds a step to s. Returns its values; NULL: it does not continue from the last row, or without memory. */
double *km_sample_window_step(km_sample_window *window, double s);
/* Adds a row at s after the steps that led to it. Returns its values; NULL without memory. Only the previous row, the
 * one before it and the steps between stay. */
double *km_sample_window_row(km_sample_window *window, double s);
/* Removes all samples: the next row does not follow the last one. */
void km_sample_window_clear(km_sample_window *window);

/* Returns value i of a sample. */
static inline double km_sample(const km_sample_window *window, int sample, int i) {
  return window->value[(size_t)sample * window->width + (size_t)i];
}

#endif
