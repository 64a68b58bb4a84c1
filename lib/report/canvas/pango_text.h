/* Text in any script and font, set by Pango. Private to report/. */
#ifndef KM_REPORT_CANVAS_PANGO_TEXT_H
#define KM_REPORT_CANVAS_PANGO_TEXT_H

#include "report/canvas/canvas_path.h"

typedef struct km_pango km_pango;

typedef struct km_text_box {
  double left, top, width, height; /* relative to the layout's own origin */
} km_text_box;

/* A line of the text that was set last; where its baseline begins, from the layout's origin. */
typedef struct km_pango_line {
  size_t begin, size; /* bytes of km_pango_string */
  double x, baseline, width;
} km_pango_line;

/* KM_IO where Pango isn't installed, KM_MEMORY. */
km_status km_pango_create(km_pango **pango, km_error *error);
void km_pango_free(km_pango *pango);

/* Sets a text, which is valid until the next one. */
km_text_box km_pango_set(km_pango *pango, const km_font *font, const char *text);
/* The text itself; bad bytes are U+FFFD. */
const char *km_pango_string(const km_pango *pango);
/* Hands its lines to `take`. */
void km_pango_lines(const km_pango *pango, void (*take)(void *context, const km_pango_line *line), void *context);
/* Adds the outlines of all its glyphs, from the layout's origin. */
void km_pango_outline(km_pango *pango, km_canvas_path *path);
/* Shows it on a cairo_t, at its current point. */
void km_pango_show(km_pango *pango, void *cairo);

#endif
