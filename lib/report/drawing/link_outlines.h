/* The links of a planar mechanism as they could be cut: outlines and holes at true scale. */
#ifndef KM_REPORT_DRAWING_LINK_OUTLINES_H
#define KM_REPORT_DRAWING_LINK_OUTLINES_H

#include "report/drawing/drawing.h"

typedef struct km_outline_part {
  enum { KM_OUTLINE_LINE, KM_OUTLINE_ARC, KM_OUTLINE_CIRCLE } kind;
  int body, colour;         /* colour: of the palette, as the drawing has it */
  km_canvas_point from, to; /* LINE: its ends; else from is the centre. Model's length unit, y upwards */
  double radius;
  double begin, end; /* ARC: radians, counterclockwise */
} km_outline_part;

/* Outlines in the fully drawn configuration: each body extends `width` around its points, with a hole of half that
 * at each revolute joint; the inertial frame has holes only. */
typedef struct km_outlines {
  const km_model *model;
  km_outline_part *parts; /* body by body */
  size_t count;
  double width; /* model's length unit */
  double low[2], high[2];
} km_outlines;

/* `width` 0: as the drawing has it, two digits of it. KM_USAGE: the mechanism doesn't move in a plane of this view;
 * KM_MEMORY. */
km_status km_outlines_make(const km_drawing_def *drawing, double width, km_arena *arena, km_outlines *out,
                           km_error *error);

/* AutoCAD's exchange format, release 12: lines, arcs and circles in the model's length unit, a layer for each body. */
km_status km_outlines_dxf(const km_outlines *outlines, km_text *out, km_error *error);

/* A page on which a length is `scale` times as long as it is. KM_USAGE: the page would be too large. */
km_status km_outlines_render(const km_outlines *outlines, double scale, km_picture_format format, km_text *out,
                             km_error *error);

#endif
