/* Configurations of a path in order, each coordinate continuous from one to the next.
 *
 *   x_0 = 0,  x_i = x_{i-1} + |q_i − q_{i-1}|,   lengths over the size, hinges without limits the shorter way */
#ifndef KM_SPACE_PATH_POINTS_H
#define KM_SPACE_PATH_POINTS_H

#include "space/path/path_steps.h"

typedef struct km_path_points {
  double **saved; /* [count] as km_driver_surface_save */
  int count;
  double *x; /* [count] length so far */
  double *q; /* [count × columns] scaled coordinates */
} km_path_points;

/* Configurations of saved[count], which stay borrowed, without those equal to the one before. False when out of
 * memory. */
bool km_path_points_create(km_path_steps *steps, double *const *saved, int count, km_arena *arena, km_path_points *out);

#endif
