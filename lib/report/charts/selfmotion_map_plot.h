/* The map of self-motions as a picture. */
#ifndef KM_REPORT_CHARTS_SELFMOTION_MAP_PLOT_H
#define KM_REPORT_CHARTS_SELFMOTION_MAP_PLOT_H

#include "arm/selfmotion/selfmotion_map.h"
#include "report/charts/map_axes.h"
#include "report/record/track_record.h"

enum { KM_MAP_CELLS = 80 };

/* A part of a station's strip in one shade. */
typedef struct km_map_cell {
  double from, to; /* name of the self-motion */
  int shade;       /* 0: the lowest values … KM_MAP_SHADES − 1: the highest */
  bool outside;    /* the joint limits: pale */
} km_map_cell;
/* A station's strip from its low to its high end, for values from `low` to `high`; cells of one colour in a row are
 * one. Returns their number, at most KM_MAP_CELLS. */
int km_map_cells(const km_station *station, double low, double high, km_map_cell *out);

#endif
