/* Unit directions of motion at the rows of a sweep and at the steps between, in the order of the motion. Private to
 * sweep/. */
#ifndef KM_SWEEP_MOTION_DIRECTIONS_H
#define KM_SWEEP_MOTION_DIRECTIONS_H

#include "kinematics/state.h"

typedef struct km_directions {
  size_t coordinates;
  double sense;  /* sign of s along the sweep, ±1 */
  double *s, *z; /* [count], [count × coordinates] lengths over the characteristic length */
  int count, capacity;
  int last, row; /* indices of the previous row and of the present one, -1: none; behind it are later steps */
  bool failed;   /* no memory: some steps are missing */
} km_directions;

/* Computes the unit direction D q̇/|D q̇| of these rates: z[coordinate]. */
void km_unit_direction(const km_mechanism *mechanism, const double *rates, double *z);

void km_directions_free(km_directions *directions);
/* Adds a step to s with these rates, unless it does not continue from the last row. */
void km_directions_step(km_directions *directions, const km_mechanism *mechanism, double s, const double *rates);
/* Adds a row at s after the steps that led to it and returns its direction's array. NULL without memory. */
double *km_directions_row(km_directions *directions, double s);
/* Removes all directions: the row has none. */
void km_directions_clear(km_directions *directions);
/* Removes the previous rows: the next row does not follow the last one. */
void km_directions_skip(km_directions *directions);

/* Returns the entry of a coordinate in the i-th direction. */
static inline double km_directions_entry(const km_directions *d, int i, int coordinate) {
  return d->z[(size_t)i * d->coordinates + (size_t)coordinate];
}

#endif
