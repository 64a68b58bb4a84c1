/* The data of SVG paths, as short as their digits allow: relative, on a grid. */
#ifndef KM_REPORT_CANVAS_SVG_PATH_H
#define KM_REPORT_CANVAS_SVG_PATH_H

#include "report/canvas/canvas_path.h"

enum { KM_SVG_HELD = 8 };

typedef struct km_svg_path {
  km_text *out;
  double slack;                      /* points that lie so near to the line past them are left out */
  int decimals;                      /* decimals of each number, 0 to 6 */
  long long x, y;                    /* current point, in grid steps */
  long long from_x, from_y;          /* start of this subpath */
  char last;                         /* the command that numbers now belong to */
  km_canvas_point kept;              /* the last point that is written */
  km_canvas_point held[KM_SVG_HELD]; /* points after it; the line to the last passes the others */
  int held_count;
} km_svg_path;

/* Adds 'M' or 'L' (one point), 'Q' (two), 'C' (three) or 'Z' (none). Rounding doesn't add up along the path. */
void km_svg_path_add(km_svg_path *path, char command, const km_canvas_point *points);
/* Writes what is held back. */
void km_svg_path_end(km_svg_path *path);
/* The data of a whole path. */
void km_svg_path_write(km_text *out, const km_canvas_path *path, int decimals, double slack);

/* Writes `value` with at most `decimals` decimals: "-.5", "12". */
void km_svg_number(km_text *out, double value, int decimals);

#endif
