/* Columns of a map over two drivers that its picture and its page show. */
#ifndef KM_REPORT_CHARTS_SPACE_MAP_COLUMNS_H
#define KM_REPORT_CHARTS_SPACE_MAP_COLUMNS_H

#include "kmech/report.h"

/* Columns of the cells. */
enum { KM_MAP_SHEET = 2, KM_MAP_ASPECT = 3 };

typedef struct km_map_columns {
  size_t value, x, y;      /* columns of the cells: the colour, and both axes */
  size_t curve_x, curve_y; /* columns of the curves: both axes */
  size_t part;             /* KM_MAP_SHEET, or over the point's place KM_MAP_ASPECT */
} km_map_columns;

/* KM_USAGE: the map has no such column, or no point. */
km_status km_map_columns_choose(const km_space_map_def *def, const km_space_map *map, const km_map_look *look,
                                km_map_columns *out, km_error *error);
/* The name of a column on an axis: a coordinate's label. */
const char *km_map_column_name(const km_table *cells, size_t column);
/* Appends what the lines of the curves mean, each kind with " · " behind it. sheets: the sheets on which the drivers'
 * singularities are drawn, or "". */
void km_map_curve_words(const km_table *curves, const char *sheets, km_text *out);

#endif
