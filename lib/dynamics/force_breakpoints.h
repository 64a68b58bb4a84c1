/* Where forces and prescribed motions change their law: values of coordinates, and times. Between two steps an integrator sees
 * nothing, so that a long one can pass over a stop, or a short push of a motor. Private to dynamics/. */
#ifndef KM_DYNAMICS_FORCE_BREAKPOINTS_H
#define KM_DYNAMICS_FORCE_BREAKPOINTS_H

#include "dynamics/dynamics.h"

/* A value of a coordinate (radians, the model's length unit). */
typedef struct km_corner {
  int coordinate;
  double value;
} km_corner;

typedef struct km_corners {
  int count, time_count;
  /* Limits with a stop, knots of springs, by coordinate and value; not of balls, and not of distances between frames. */
  km_corner *corners;
  double *times; /* ascending: rows of tables, knots of motors */
} km_corners;

/* False when out of memory. O(corners log corners). */
bool km_corners_list(const km_dynamics *dynamics, km_arena *arena, km_corners *out);
/* The first corner of the coordinate above a value, or where it would stand. O(log corners). */
int km_corners_above(const km_corners *corners, int coordinate, double value);
/* The first time after `time`, infinity where there is none. */
double km_corners_next(const km_corners *corners, double time);

#endif
