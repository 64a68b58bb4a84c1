/* Map of self-motions along a path: at stations of the path, all configurations that are reachable from a reference
 * without moving the effector (docs/theory.md 12.8). */
#ifndef KM_ARM_SELFMOTION_SELFMOTION_MAP_H
#define KM_ARM_SELFMOTION_SELFMOTION_MAP_H

#include "arm/ik/ik_branches.h"
#include "arm/path/path.h"
#include "kmech/arm.h"

/* Station of a path: the self-motion through the reference configuration there. u is the arc length from the
 * reference; on a closed curve −length/2 … length/2. */
typedef struct km_station {
  int sample;
  double s; /* path metric, model's unit */
  bool closed;
  double low, high; /* range of u */
  int count;
  double *u, *value; /* [count] increasing arc length; [count] objective */
  km_arc_span *arcs; /* [arc_count] arcs within the limits, cut to low … high */
  int arc_count;
  double *q; /* [count × n] configurations in the arm's units */
} km_station;

typedef struct km_motion_map {
  km_arena arena;
  const km_arm *arm;
  int count;
  km_station *stations;
  double reached; /* part of the path over which the reference was continued */
} km_motion_map;

/* Computes a map with about `stations` stations. The reference begins at start[n] and follows the path-control
 * column, limits ignored. KM_USAGE: the arm hasn't one spare freedom; KM_MEMORY. Free `*out` in any case. */
km_status km_motion_map_create(const km_arm *arm, const km_path *path, const double *start,
                               const km_objective *objective, int stations, km_motion_map *out, km_error *error);
void km_motion_map_free(km_motion_map *map);

/* Arc length u of q[n] on a station's curve; NaN if q lies on another curve. */
double km_station_find(const km_motion_map *map, const km_station *station, const double *q);

#endif
