/* Pages to draw on: shapes and text in the page's own points, handed to what writes SVG, PDF or PNG. */
#include "report/canvas/canvas.h"

#include "base/arguments.h"

#include "base/memory.h"
#include "report/canvas/canvas_device.h"

#include <math.h>

static const double page_limit = 14400; /* PDF's own limit: 200 inches */

struct km_canvas {
  const km_device *device;
  void *page;
  km_text *out; /* NULL: what is drawn is recorded */
  size_t start; /* size of `out` before the first byte */
  km_canvas_point origin;
  km_canvas_point *clips; /* origins before each clip */
  size_t clip_count, clip_room;
  km_canvas_path path;
  km_letters letters;
  km_pango *pango; /* NULL until a text needs it */
  bool page_refused, failed;
  km_status status; /* status of an element that can't be drawn, with its error */
  km_error error;
};

static bool size_fits(double width, double height) {
  return width >= 1 && height >= 1 && width <= page_limit && height <= page_limit;
}

static km_status make(km_canvas **canvas, km_error *error) {
  *canvas = KM_NEW(km_canvas, 1);
  return *canvas ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a page");
}

static void unmake(km_canvas **canvas) {
  km_free(*canvas);
  *canvas = NULL;
}

km_status km_canvas_create(km_picture_format format, double width, double height, km_text *out, km_canvas **canvas,
                           km_error *error) {
  *canvas = NULL;
  if (!size_fits(width, height))
    return km_fail(error, KM_USAGE, "a page of %g x %g points; expected 1 to %g each", width, height, page_limit);
  km_status status = make(canvas, error);
  if (status)
    return status;
  km_canvas *made = *canvas;
  made->out = out;
  made->start = out->size;
  if (format == KM_PICTURE_SVG) {
    made->device = &km_svg_device;
    status = km_svg_page_create(width, height, out, &made->page, error);
  } else {
    made->device = &km_cairo_device;
    status = km_cairo_page_create(format, width, height, out, &made->page, error);
  }
  if (status)
    unmake(canvas);
  return status;
}

km_status km_canvas_record(const km_canvas_recorder *recorder, km_canvas **canvas, km_error *error) {
  km_status status = make(canvas, error);
  if (status)
    return status;
  (*canvas)->device = &km_record_device;
  status = km_record_page_create(recorder, &(*canvas)->page, error);
  if (status)
    unmake(canvas);
  return status;
}

void km_canvas_fail(km_canvas *canvas) {
  canvas->failed = true;
}

static km_status finish(km_canvas *canvas, km_error *error) {
  if (canvas->page_refused)
    return km_fail(error, KM_USAGE, "a second page that can't be; only PDF has several, of 1 to %g points", page_limit);
  if (canvas->status) {
    if (error)
      *error = canvas->error;
    return canvas->status;
  }
  if (canvas->failed || canvas->path.failed || canvas->letters.failed)
    return km_fail(error, KM_MEMORY, "out of memory for a picture");
  return canvas->device->finish(canvas->page, error);
}

km_status km_canvas_finish(km_canvas *canvas, km_error *error) {
  km_status status = finish(canvas, error);
  if (status && canvas->out) {
    canvas->out->size = canvas->start;
    if (canvas->out->data)
      canvas->out->data[canvas->start] = 0;
  }
  return status;
}

void km_canvas_free(km_canvas *canvas) {
  if (!canvas)
    return;
  canvas->device->free(canvas->page);
  km_pango_free(canvas->pango);
  km_letters_free(&canvas->letters);
  km_canvas_path_free(&canvas->path);
  km_free(canvas->clips);
  km_free(canvas);
}

void km_canvas_page(km_canvas *canvas, double width, double height) {
  if (!size_fits(width, height) || !canvas->device->next(canvas->page, width, height))
    canvas->page_refused = true;
}

static km_canvas_point on_page(const km_canvas *canvas, km_canvas_point p) {
  return (km_canvas_point){p.x + canvas->origin.x, p.y + canvas->origin.y};
}

/* Hands on the path, which then is empty. */
static void paint(km_canvas *canvas, const km_colour *fill, const km_pen *pen) {
  if (!canvas->path.failed)
    canvas->device->shape(canvas->page, &canvas->path, fill, pen);
  km_canvas_path_clear(&canvas->path);
}

static void trace(km_canvas *canvas, const km_canvas_point *points, size_t count) {
  for (size_t i = 0; i < count; i++) {
    const km_canvas_point p = on_page(canvas, points[i]);
    km_canvas_path_add(&canvas->path, i ? 'L' : 'M', &p);
  }
}

void km_canvas_line(km_canvas *canvas, const km_pen *pen, km_canvas_point from, km_canvas_point to) {
  km_canvas_polyline(canvas, pen, (const km_canvas_point[]){from, to}, 2);
}

void km_canvas_polyline(km_canvas *canvas, const km_pen *pen, const km_canvas_point *points, size_t count) {
  trace(canvas, points, count);
  paint(canvas, NULL, pen);
}

void km_canvas_polygon(km_canvas *canvas, km_colour fill, const km_canvas_point *points, size_t count) {
  trace(canvas, points, count);
  paint(canvas, &fill, NULL);
}

void km_canvas_rectangle(km_canvas *canvas, km_colour fill, double x, double y, double width, double height) {
  km_canvas_path_rectangle(&canvas->path, canvas->origin.x + x, canvas->origin.y + y, width, height);
  paint(canvas, &fill, NULL);
}

void km_canvas_pixels(km_canvas *canvas, const km_text *png, double x, double y, double scale) {
  if (canvas->device->pixels)
    canvas->device->pixels(canvas->page, png, canvas->origin.x + x, canvas->origin.y + y, scale);
}

void km_canvas_circle(km_canvas *canvas, km_colour fill, const km_pen *pen, km_canvas_point centre, double radius) {
  km_canvas_path_circle(&canvas->path, on_page(canvas, centre), radius);
  paint(canvas, &fill, pen);
}

void km_canvas_clip(km_canvas *canvas, double x, double y, double width, double height) {
  void *clips = canvas->clips;
  if (!km_reserve(&clips, &canvas->clip_room, canvas->clip_count + 1, sizeof *canvas->clips)) {
    canvas->failed = true;
    return;
  }
  canvas->clips = clips;
  canvas->clips[canvas->clip_count++] = canvas->origin;
  canvas->device->clip(canvas->page, canvas->origin.x + x, canvas->origin.y + y, width, height);
}

void km_canvas_release(km_canvas *canvas) {
  if (canvas->clip_count == 0)
    return;
  canvas->origin = canvas->clips[--canvas->clip_count];
  canvas->device->release(canvas->page);
}

void km_canvas_shift(km_canvas *canvas, double right, double down) {
  canvas->origin = on_page(canvas, (km_canvas_point){right, down});
}

km_canvas_point km_text_point(const km_text_place *place, double across, double down) {
  double c = cos(place->angle), s = sin(place->angle);
  return (km_canvas_point){place->at.x + c * across - s * down, place->at.y + s * across + c * down};
}

/* Sets a text by HarfBuzz, otherwise by Pango. False if neither can; km_canvas_finish then returns the error. */
static bool set_text(km_canvas *canvas, const km_font *font, const char *text, bool *simple, km_text_box *box) {
  *box = (km_text_box){0};
  *simple = km_letters_set(&canvas->letters, font, text);
  if (*simple) {
    box->width = canvas->letters.width;
    box->height = KM_FONT_HEIGHT * font->size * (double)canvas->letters.line_count;
    return true;
  }
  if (!canvas->pango && !canvas->status)
    canvas->status = km_pango_create(&canvas->pango, &canvas->error);
  if (!canvas->pango)
    return false;
  *box = km_pango_set(canvas->pango, font, text);
  return true;
}

static void draw_lines(km_canvas *canvas, const km_font *font, km_colour colour, const km_text_place *corner) {
  for (size_t i = 0; i < canvas->letters.line_count; ++i) {
    double down = (KM_FONT_ASCENT + KM_FONT_HEIGHT * (double)i) * font->size;
    const km_text_place place = {km_text_point(corner, 0, down), corner->angle};
    canvas->device->line(canvas->page, &canvas->letters, i, font, colour, &place);
  }
}

void km_canvas_text(km_canvas *canvas, const km_font *font, km_colour colour, const char *text, km_canvas_point at,
                    km_anchor anchor) {
  bool simple;
  km_text_box box;
  if (!set_text(canvas, font, text, &simple, &box))
    return;
  km_text_place place = {on_page(canvas, at), anchor.angle};
  place.at = km_text_point(&place, -box.left - anchor.across * box.width, -box.top - anchor.down * box.height);
  if (simple)
    draw_lines(canvas, font, colour, &place);
  else
    canvas->device->layout(canvas->page, canvas->pango, font, colour, &place);
}

void km_canvas_words(km_canvas *canvas, const km_font *font, km_colour colour, km_text *words, km_canvas_point at,
                     km_anchor anchor) {
  if (words->failed)
    km_canvas_fail(canvas);
  else
    km_canvas_text(canvas, font, colour, words->data ? words->data : "", at, anchor);
  km_text_free(words);
}

km_canvas_point km_canvas_measure(km_canvas *canvas, const km_font *font, const char *text) {
  bool simple;
  km_text_box box;
  set_text(canvas, font, text, &simple, &box);
  return (km_canvas_point){box.width, box.height};
}

km_status km_check_picture(const km_text *out, km_picture_format format, km_error *error) {
  if ((int)format < KM_PICTURE_SVG || (int)format > KM_PICTURE_PNG)
    return km_fail(error, KM_USAGE, "found no format of pictures; expected SVG, PDF or PNG");
  return km_check_given(out != NULL, "place for the result", error);
}
