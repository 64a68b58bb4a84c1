/* Corners: values of coordinates and times at which forces and prescribed motions change their law. A long step
 * without evaluations near a corner could pass over a stop or a short force of a motor (docs/theory.md 11.6).
 * Private to dynamics/. */
#ifndef KM_DYNAMICS_FORCE_BREAKPOINTS_H
#define KM_DYNAMICS_FORCE_BREAKPOINTS_H

#include "dynamics/dynamics.h"

enum { KM_CORNER_TIME = -1 };

/* Value of a coordinate, radians or the model's length unit; or (coordinate KM_CORNER_TIME) of the time. */
typedef struct km_corner {
  int coordinate;
  double value;
  double period; /* > 0: the corner repeats at value + k · period, k = … −1, 0, 1 … */
} km_corner;

typedef struct km_corners {
  /* Limits with a stop, knots of springs, rows of tables; sorted by coordinate and value, the periodic ones after the
   * others; without balls and distances between frames. */
  int count, single_count; /* number of corners; of those that don't repeat */
  km_corner *corners;
} km_corners;

/* Lists all corners. False: out of memory. O(corners log corners). */
bool km_corners_list(const km_dynamics *dynamics, km_arena *arena, km_corners *out);
/* Next corner of a coordinate above a value; infinity if there is none. O(log corners + periodic corners). */
double km_corners_above(const km_corners *corners, int coordinate, double value);
/* Next corner of a coordinate at or below a value; −infinity if there is none. */
double km_corners_up_to(const km_corners *corners, int coordinate, double value);

#endif
