/* The map of self-motions along a path: at stations of it, every pose that the arm can get to without moving the
 * effector. */
#ifndef KM_ARM_SELFMOTION_SELFMOTION_MAP_H
#define KM_ARM_SELFMOTION_SELFMOTION_MAP_H

#include "arm/ik/ik_branches.h"
#include "arm/path/path.h"
#include "kmech/arm.h"

/* A station: the self-motion through the reference pose there. u counts from it; on a closed curve from −length/2 to
 * length/2. */
typedef struct km_station {
  int sample;
  double s; /* model's unit */
  bool closed;
  double low, high; /* of u */
  int count;
  double *u, *value; /* [count] increasing; the objective there */
  km_arc_span *arcs; /* [arc_count] within the limits, cut to low … high */
  int arc_count;
  double *q; /* [count × n] in the arm's units */
} km_station;

typedef struct km_motion_map {
  km_arena arena;
  const km_arm *arm;
  int count;
  km_station *stations;
  double reached; /* share of the path over which the reference could be carried */
} km_motion_map;

/* About `stations` stations. The reference is the start, carried along by the path-control column whatever the limits.
 * One spare freedom only (KM_USAGE). Free `*out` in any case. */
km_status km_motion_map_make(const km_arm *arm, const km_path *path, const double *start, const km_objective *objective,
                             int stations, km_motion_map *out, km_error *error);
void km_motion_map_free(km_motion_map *map);

/* Where q[n] lies on a station's curve; NaN if it lies on another one. */
double km_station_find(const km_motion_map *map, const km_station *station, const double *q);

#endif
