/* Interface from a canvas to the writer of a page: paths and lines of text, in points. Private to report/canvas. */
#ifndef KM_REPORT_CANVAS_CANVAS_DEVICE_H
#define KM_REPORT_CANVAS_CANVAS_DEVICE_H

#include "report/canvas/canvas_path.h"
#include "report/canvas/letters.h"
#include "report/canvas/pango_text.h"

/* Position of a text: rotated by `angle` (radians, clockwise) about `at`. */
typedef struct km_text_place {
  km_canvas_point at;
  double angle;
} km_text_place;

/* A point of turned text, `across` and `down` from its place. */
km_canvas_point km_text_point(const km_text_place *place, double across, double down);

/* Functions of a kind of page. Failures are sticky and returned by `finish`. */
typedef struct km_device {
  void (*shape)(void *page, const km_canvas_path *path, const km_colour *fill, const km_pen *pen);
  /* A line that was set by `letters`; its baseline begins at the place. */
  void (*line)(void *page, const km_letters *letters, size_t line, const km_font *font, km_colour colour,
               const km_text_place *place);
  /* All lines that Pango set; the origin of its layout is at the place. */
  void (*layout)(void *page, km_pango *pango, const km_font *font, km_colour colour, const km_text_place *place);
  /* Pixels of a PNG file, with their upper left corner at (x, y), `scale` points a pixel; NULL: the page takes none. */
  void (*pixels)(void *page, const km_text *png, double x, double y, double scale);
  void (*clip)(void *page, double x, double y, double width, double height);
  void (*release)(void *page);
  bool (*next)(void *page, double width, double height); /* a new page; false: there can be no other */
  /* Appends what is left of the picture's bytes. */
  km_status (*finish)(void *page, km_error *error);
  void (*free)(void *page);
} km_device;

extern const km_device km_svg_device, km_cairo_device, km_record_device;

/* Pages, which append to the borrowed `out`. */
km_status km_svg_page_create(double width, double height, km_text *out, void **page, km_error *error);
km_status km_cairo_page_create(km_picture_format format, double width, double height, km_text *out, void **page,
                               km_error *error);
km_status km_record_page_create(const km_canvas_recorder *recorder, void **page, km_error *error);

#endif
