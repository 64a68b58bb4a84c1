/* Corners: values of coordinates and times at which forces and prescribed motions change their law. A long step
 * without evaluations near a corner could pass over a stop or a short force of a motor (docs/theory.md 11.6).
 * Private to dynamics/. */
#ifndef KM_DYNAMICS_FORCE_BREAKPOINTS_H
#define KM_DYNAMICS_FORCE_BREAKPOINTS_H

#include "dynamics/dynamics.h"

/* Value of a coordinate, radians or the model's length unit. */
typedef struct km_corner {
  int coordinate;
  double value;
} km_corner;

typedef struct km_corners {
  int count, time_count;
  /* Limits with a stop and knots of springs, sorted by coordinate and value; without balls and distances between
   * frames. */
  km_corner *corners;
  double *times; /* ascending times: rows of tables, knots of motors */
} km_corners;

/* Lists all corners. False: out of memory. O(corners log corners). */
bool km_corners_list(const km_dynamics *dynamics, km_arena *arena, km_corners *out);
/* Index of the coordinate's first corner above a value, or the index at which it would be inserted. O(log corners). */
int km_corners_above(const km_corners *corners, int coordinate, double value);
/* First corner time after `time`; infinity if there is none. */
double km_corners_next(const km_corners *corners, double time);

#endif
