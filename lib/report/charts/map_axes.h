/* Axes and colours of the maps: cells in shades over two coordinates. */
#ifndef KM_REPORT_CHARTS_MAP_AXES_H
#define KM_REPORT_CHARTS_MAP_AXES_H

#include "report/canvas/canvas.h"
#include "report/plot/axis_ticks.h"
#include "report/plot/data_curve.h"

enum { KM_MAP_SHADES = 16 };

/* Dark blue to pale yellow: light and dark survive a grey print and every kind of colour blindness. */
km_colour km_map_shade(int shade);
/* The frame's box, and ticks with labels below and to the left, `gap` points below the frame. */
void km_map_axes_draw(km_canvas *canvas, const km_frame *frame, const km_axis *x, const km_axis *y, double font_size,
                      double gap);
/* A bar of all shades from `low` to `high` with ticks. multiplier: the factor that its labels omit, or "". */
void km_map_colours_draw(km_canvas *canvas, double low, double high, double left, double top, double height,
                         char multiplier[KM_AXIS_LABEL]);

#endif
