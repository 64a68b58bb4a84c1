/* The data of SVG paths, as short as their digits allow: relative, on a grid. */
#ifndef KM_REPORT_PLOT_SVG_PATH_H
#define KM_REPORT_PLOT_SVG_PATH_H

#include "report/plot/canvas.h"

typedef struct km_svg_path {
  km_text *out;
  int decimals;             /* of every number: 0 to 3 */
  long long x, y;           /* where the path has come to, in steps of the grid */
  long long from_x, from_y; /* where this part of it began */
  char last;                /* the command that numbers now belong to */
} km_svg_path;

/* Adds 'M' or 'L' (one point), 'C' (three) or 'Z' (none). Rounding doesn't add up along the path. */
void km_svg_path_add(km_svg_path *path, char command, const km_canvas_point *points);

/* A number with at most so many decimals: "-.5", "12". */
void km_svg_number(km_text *out, double value, int decimals);

#endif
