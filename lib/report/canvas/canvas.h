/* Canvas: a page in points (1/72 inch) from the top left corner, y down, written as SVG, PDF or PNG. No type of a
 * graphics library occurs here. Failures are sticky and reported by km_canvas_finish. */
#ifndef KM_REPORT_CANVAS_CANVAS_H
#define KM_REPORT_CANVAS_CANVAS_H

#include "base/text.h"
#include "kmech/base.h"
#include "kmech/report.h"

typedef struct km_canvas km_canvas;

typedef struct km_colour {
  double red, green, blue, alpha; /* 0 to 1; alpha 1 is opaque */
} km_colour;

typedef struct km_canvas_point {
  double x, y;
} km_canvas_point;

typedef struct km_pen {
  km_colour colour;
  double width;       /* points */
  const double *dash; /* lengths on, off, on, ... in widths of the pen; NULL: solid */
  size_t dash_count;
} km_pen;

typedef struct km_font {
  double size; /* points */
  bool bold;
  double width; /* longer text is wrapped, then ends in an ellipsis; 0: no limit */
  int lines;    /* most lines the text may wrap to; 0 is 1 */
} km_font;

/* Anchor of a text's box: 0 left or top, 0.5 middle, 1 right or bottom; the box is rotated about it. */
typedef struct km_anchor {
  double across, down;
  double angle; /* radians, clockwise on the page */
} km_anchor;

/* A white page of width x height points, each from 1 to 14400. Bytes are appended to the borrowed
 * `out` until the canvas is freed. KM_USAGE (size), KM_MEMORY, KM_IO (cairo is needed, and isn't installed). */
km_status km_canvas_create(km_picture_format format, double width, double height, km_text *out, km_canvas **canvas,
                           km_error *error);
/* Completes the bytes and returns the first failure since the creation; `out` is then unchanged. KM_USAGE (a second
 * page outside PDF), KM_MEMORY, KM_IO (cairo or Pango is needed and isn't installed), KM_INTERNAL. */
km_status km_canvas_finish(km_canvas *canvas, km_error *error);
void km_canvas_free(km_canvas *canvas);

/* Receives what is drawn, piece by piece, in SVG's own words. `path`: the data of an SVG path; no fill or pen: NULL. */
typedef struct km_canvas_recorder {
  void (*shape)(void *context, const char *path, const km_colour *fill, const km_pen *pen);
  /* One line of text whose baseline begins at `at`, `width` long; turned by `angle` about it. */
  void (*line)(void *context, const char *text, const km_font *font, km_colour colour, km_canvas_point at, double width,
               double angle);
  void *context;
  int decimals; /* digits of the paths' numbers; digits and slack may change between paths */
  double slack; /* points: corners that lie so near to a line past them are left out */
} km_canvas_recorder;

/* A canvas without a page, whose drawing goes to the borrowed recorder. Clips don't count. KM_MEMORY. */
km_status km_canvas_record(const km_canvas_recorder *recorder, km_canvas **canvas, km_error *error);

/* Ends this page and begins a white one of another size. PDF only. */
void km_canvas_page(km_canvas *canvas, double width, double height);

void km_canvas_line(km_canvas *canvas, const km_pen *pen, km_canvas_point from, km_canvas_point to);
void km_canvas_polyline(km_canvas *canvas, const km_pen *pen, const km_canvas_point *points, size_t count);
void km_canvas_polygon(km_canvas *canvas, km_colour fill, const km_canvas_point *points, size_t count);
void km_canvas_rectangle(km_canvas *canvas, km_colour fill, double x, double y, double width, double height);
/* A filled disc; `pen` (may be NULL) draws its rim. */
void km_canvas_circle(km_canvas *canvas, km_colour fill, const km_pen *pen, km_canvas_point centre, double radius);

/* The pixels of a PNG file, `scale` points each, their upper left corner at (x, y). Pages of PDF and PNG only; others
 * stay as they are. */
void km_canvas_pixels(km_canvas *canvas, const km_text *png, double x, double y, double scale);

/* Clips everything until the matching release to the rectangle. Clips can be nested. */
void km_canvas_clip(km_canvas *canvas, double x, double y, double width, double height);
void km_canvas_release(km_canvas *canvas);
/* Moves the origin of whatever is drawn from now on. */
void km_canvas_shift(km_canvas *canvas, double right, double down);

/* UTF-8 in any script; markup is not interpreted, bad bytes become U+FFFD. Sizes don't depend on
 * the format: nothing is hinted. */
void km_canvas_text(km_canvas *canvas, const km_font *font, km_colour colour, const char *text, km_canvas_point at,
                    km_anchor anchor);
/* Draws a composed text and frees it. The canvas fails if the text ran out of memory. */
void km_canvas_words(km_canvas *canvas, const km_font *font, km_colour colour, km_text *words, km_canvas_point at,
                     km_anchor anchor);
/* Sets the failure "out of memory", which km_canvas_finish returns. */
void km_canvas_fail(km_canvas *canvas);
/* The box that km_canvas_text would fill: x across, y down. */
km_canvas_point km_canvas_measure(km_canvas *canvas, const km_font *font, const char *text);

/* KM_USAGE unless there is a place for the bytes and the format is one. */
km_status km_check_picture(const km_text *out, km_picture_format format, km_error *error);

#endif
