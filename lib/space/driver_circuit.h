/* Motion of a driver on the circuit of a configuration (docs/theory.md 4.20).
 *
 *   dq_d/ds = 0   dead points: roots of the driver's rate along the arc length s, with all coordinates free
 *   t·Δq = 0      return of a motion with spinning rods: Δq from the start without spins of rods, t the first such
 *                 step; closed if |Δq| is 1e-6 at most there */
#ifndef KM_SPACE_DRIVER_CIRCUIT_H
#define KM_SPACE_DRIVER_CIRCUIT_H

#include "space/driver_surface.h"

enum { KM_MOST_CIRCUIT_STARTS = 256 };

typedef struct km_driver_swing {
  double low, high; /* radians or the model's length; low > high: no dead point, and no end of the motion */
  bool turns;       /* the driver goes fully round */
  int dead_points;
} km_driver_swing;

typedef struct km_driver_circuit {
  km_driver_surface *f; /* control[0]: the driver; of one part, with one freedom */
  double *rates;        /* [coordinate] workspace */
  double *place;        /* [saved size] the configuration at the start */
  double *sample, *now; /* [saved size] workspace */
  double *first_step;   /* [columns] from the start, without spins */
  double *starts;       /* [start_count × saved size] dead points, and configurations where the driver is slowest */
  int start_count;
} km_driver_circuit;

/* Creates the surface, whose m, s, frame, number and ranges are given, and its circuit, for a driver; then
 * km_driver_surface_begin. KM_USAGE: the driver is in no loop, or the surface can't be created; KM_MEMORY. */
km_status km_driver_circuit_create(km_driver_surface *surface, int driver, km_arena *arena, km_driver_circuit *out,
                                   km_error *error);
/* Follows the circuit of the state; `starts` are then those on it. The state returns. KM_MEMORY. */
km_status km_driver_circuit_follow(km_driver_circuit *circuit, km_driver_swing *swing, km_error *error);

#endif
