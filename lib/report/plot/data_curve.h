/* Curves of data: mapped into a frame, clipped, and thinned to visible resolution. */
#ifndef KM_REPORT_PLOT_DATA_CURVE_H
#define KM_REPORT_PLOT_DATA_CURVE_H

#include "base/memory.h"
#include "report/canvas/canvas.h"
#include "report/plot/plot.h"

/* A rectangle of the page and the ranges of data it shows. */
typedef struct km_frame {
  double left, top, width, height; /* points */
  double x_low, x_high, y_low, y_high;
} km_frame;

/* Runs of points joined by straight lines; a run of one point is a dot. */
typedef struct km_curve {
  km_canvas_point *points;
  size_t count;
  size_t *run_ends; /* run r is points[run_ends[r - 1]] up to, without, points[run_ends[r]] */
  size_t run_count;
  bool has_end;
  km_canvas_point end; /* the last drawable datum, moved into the frame if above or below it */
  double before;       /* height of the line a little before its end */
} km_curve;

km_canvas_point km_frame_map(const km_frame *frame, double x, double y);

/* No dropped point is farther than 0.05 pt from the line drawn. Memory is the arena's; when it
 * fails the curve is empty. */
km_curve km_curve_make(const km_frame *frame, const km_plot_series *series, km_arena *arena);

/* In how many places the curve crosses a rectangle's area. */
size_t km_curve_hits(const km_curve *curve, double left, double top, double right, double bottom);

#endif
