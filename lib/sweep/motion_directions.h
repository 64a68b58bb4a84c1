/* Unit directions of motion at the rows of a sweep and at the steps that led there, in the order in which the motion passes them.
 * Private to analysis/. */
#ifndef KM_SWEEP_MOTION_DIRECTIONS_H
#define KM_SWEEP_MOTION_DIRECTIONS_H

#include "kinematics/state.h"

typedef struct km_directions {
  size_t coordinates;
  double sense;  /* of s along the sweep, ±1 */
  double *s, *z; /* [count], [count × coordinates] lengths over the characteristic length */
  int count, room;
  int last, row; /* the row before the present one, and that, -1: none; behind it are steps that lead on */
  bool failed;   /* out of memory: some steps are missing */
} km_directions;

/* The unit direction at these rates: z[coordinate]. */
void km_unit_direction(const km_mechanism *mechanism, const double *rates, double *z);

void km_directions_free(km_directions *directions);
/* The motion has made a step to s, where it has these rates. Nothing happens unless it leads on from the last row. */
void km_directions_step(km_directions *directions, const km_mechanism *mechanism, double s, const double *rates);
/* Adds a row at s behind the steps that led there, and returns the place for its direction. NULL when out of memory. */
double *km_directions_row(km_directions *directions, double s);
/* Nothing is known of the row any more, since it has no direction. */
void km_directions_forget(km_directions *directions);
/* The next row isn't the one behind the last one. */
void km_directions_skip(km_directions *directions);

/* The entry of a coordinate at the i-th place. */
static inline double km_directions_entry(const km_directions *d, int i, int coordinate) {
  return d->z[(size_t)i * d->coordinates + (size_t)coordinate];
}

#endif
