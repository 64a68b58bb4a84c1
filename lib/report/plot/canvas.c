/* Pages to draw on, over cairo and Pango: lines, areas and text as SVG, PDF or PNG. */
#include "report/plot/canvas.h"

#include "base/memory.h"
#include "report/plot/cairo_library.h"
#include "report/plot/canvas_bytes.h"
#include "report/plot/png.h"
#include "report/plot/svg_path.h"

#include <math.h>
#include <string.h>

static const char *const font_family = "DejaVu Sans";
/* The font's ascent and height in em. Single lines are placed by these, whatever font a foreign
 * script falls back to, so that names of different scripts share a baseline. */
static const double font_ascent = 0.928, font_height = 1.164;
static const double png_scale = 2; /* 144 dpi, */
static const unsigned png_per_metre = 5669;
static const double page_limit = 14400; /* PDF's own limit: 200 inches */

struct km_canvas {
  const km_cairo *lib;
  km_picture_format format;
  km_text *out;
  size_t start; /* size of `out` before the first byte */
  cairo_surface_t *surface;
  cairo_t *cairo;
  PangoLayout *layout; /* one for all texts: making layouts costs more than filling them */
  PangoFontDescription *font;
  bool page_refused;
  const km_canvas_recorder *recorder; /* NULL: there is a page */
};

static cairo_status_t append(void *closure, const unsigned char *bytes, unsigned size) {
  km_canvas *canvas = closure;
  if (!canvas->out)
    return CAIRO_STATUS_SUCCESS;
  km_text_bytes(canvas->out, bytes, size);
  return canvas->out->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

static cairo_surface_t *make_surface(km_canvas *canvas, double width, double height) {
  if (canvas->format == KM_PICTURE_SVG)
    return canvas->lib->cairo_svg_surface_create_for_stream(append, canvas, width, height);
  if (canvas->format == KM_PICTURE_PNG)
    return canvas->lib->cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)lround(width * png_scale),
                                                   (int)lround(height * png_scale));
  cairo_surface_t *surface = canvas->lib->cairo_pdf_surface_create_for_stream(append, canvas, width, height);
  /* Cairo would stamp the time of drawing: the same input must give the same bytes. */
  canvas->lib->cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  return surface;
}

static void paint_white(km_canvas *canvas) {
  canvas->lib->cairo_set_source_rgb(canvas->cairo, 1, 1, 1);
  canvas->lib->cairo_paint(canvas->cairo);
}

/* Unhinted metrics in a fixed language: a layout depends on neither the format nor the locale. */
static void prepare_text(km_canvas *canvas) {
  PangoContext *context = canvas->lib->pango_font_map_create_context(canvas->lib->pango_cairo_font_map_get_default());
  cairo_font_options_t *options = canvas->lib->cairo_font_options_create();
  canvas->lib->cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  canvas->lib->cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  canvas->lib->cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  canvas->lib->pango_cairo_context_set_font_options(context, options);
  canvas->lib->cairo_font_options_destroy(options);
  canvas->lib->pango_context_set_round_glyph_positions(context, FALSE);
  canvas->lib->pango_context_set_language(context, canvas->lib->pango_language_from_string("en"));
  canvas->layout = canvas->lib->pango_layout_new(context);
  canvas->lib->g_object_unref(context);
  canvas->lib->pango_layout_set_single_paragraph_mode(canvas->layout, TRUE);
  canvas->lib->pango_layout_set_ellipsize(canvas->layout, PANGO_ELLIPSIZE_MIDDLE);
  canvas->font = canvas->lib->pango_font_description_from_string(font_family);
}

static bool size_fits(double width, double height) {
  return width >= 1 && height >= 1 && width <= page_limit && height <= page_limit;
}

km_status km_canvas_create(km_picture_format format, double width, double height, km_text *out, km_canvas **canvas,
                           km_error *error) {
  *canvas = NULL;
  if (!size_fits(width, height))
    return km_fail(error, KM_USAGE, "a page of %g x %g points; expected 1 to %g each", width, height, page_limit);
  const km_cairo *lib = km_cairo_load(error);
  if (!lib)
    return KM_IO;
  km_canvas *made = KM_NEW(km_canvas, 1);
  if (!made)
    return km_fail(error, KM_MEMORY, "out of memory for a page");
  made->lib = lib;
  made->format = format;
  made->out = out;
  made->start = out->size;
  made->surface = make_surface(made, width, height);
  made->cairo = lib->cairo_create(made->surface);
  if (format == KM_PICTURE_PNG)
    lib->cairo_scale(made->cairo, png_scale, png_scale);
  lib->cairo_set_line_join(made->cairo, CAIRO_LINE_JOIN_ROUND);
  prepare_text(made);
  paint_white(made);
  *canvas = made;
  return KM_OK;
}

km_status km_canvas_record(const km_canvas_recorder *recorder, km_canvas **canvas, km_error *error) {
  const km_cairo *lib = km_cairo_load(error);
  *canvas = NULL;
  if (!lib)
    return KM_IO;
  km_canvas *made = *canvas = KM_NEW(km_canvas, 1);
  if (!made)
    return km_fail(error, KM_MEMORY, "out of memory for a page");
  made->lib = lib;
  made->recorder = recorder;
  made->surface = lib->cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1); /* only its paths are asked for */
  made->cairo = lib->cairo_create(made->surface);
  prepare_text(made);
  return KM_OK;
}

static cairo_status_t write_pixels(km_canvas *canvas) {
  const km_cairo *lib = canvas->lib;
  lib->cairo_surface_flush(canvas->surface);
  const km_pixels pixels = {.data = lib->cairo_image_surface_get_data(canvas->surface),
                            .width = lib->cairo_image_surface_get_width(canvas->surface),
                            .height = lib->cairo_image_surface_get_height(canvas->surface),
                            .stride = lib->cairo_image_surface_get_stride(canvas->surface),
                            .per_metre = png_per_metre};
  return pixels.data && km_png_write(&pixels, canvas->out) ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_NO_MEMORY;
}

static cairo_status_t write_out(km_canvas *canvas) {
  cairo_status_t status = canvas->lib->cairo_status(canvas->cairo);
  if (status == CAIRO_STATUS_SUCCESS && canvas->format == KM_PICTURE_PNG)
    status = write_pixels(canvas);
  canvas->lib->cairo_surface_finish(canvas->surface);
  if (status == CAIRO_STATUS_SUCCESS)
    status = canvas->lib->cairo_surface_status(canvas->surface);
  if (status != CAIRO_STATUS_SUCCESS)
    return status;
  if (canvas->format == KM_PICTURE_SVG)
    km_svg_drop_id(canvas->out, canvas->start);
  return canvas->out->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

void km_canvas_fail(km_canvas *canvas) {
  canvas->out->failed = true;
}

void km_canvas_words(km_canvas *canvas, const km_font *font, km_colour colour, km_text *words, km_canvas_point at,
                     km_anchor anchor) {
  if (words->failed)
    km_canvas_fail(canvas);
  else
    km_canvas_text(canvas, font, colour, words->data ? words->data : "", at, anchor);
  km_text_free(words);
}

km_status km_canvas_finish(km_canvas *canvas, km_error *error) {
  cairo_status_t status = write_out(canvas);
  if (status == CAIRO_STATUS_SUCCESS && !canvas->page_refused)
    return KM_OK;
  canvas->out->size = canvas->start;
  if (canvas->out->data)
    canvas->out->data[canvas->start] = 0;
  if (canvas->page_refused)
    return km_fail(error, KM_USAGE, "a second page that can't be; only PDF has several, of 1 to %g points", page_limit);
  if (status == CAIRO_STATUS_NO_MEMORY)
    return km_fail(error, KM_MEMORY, "out of memory for a picture");
  return km_fail(error, KM_INTERNAL, "the picture failed: %s", canvas->lib->cairo_status_to_string(status));
}

void km_canvas_free(km_canvas *canvas) {
  if (!canvas)
    return;
  canvas->out = NULL; /* an unfinished surface writes its rest when it is destroyed */
  canvas->lib->pango_font_description_free(canvas->font);
  canvas->lib->g_object_unref(canvas->layout);
  canvas->lib->cairo_destroy(canvas->cairo);
  canvas->lib->cairo_surface_destroy(canvas->surface);
  km_free(canvas);
}

void km_canvas_page(km_canvas *canvas, double width, double height) {
  if (canvas->format != KM_PICTURE_PDF || !size_fits(width, height)) {
    canvas->page_refused = true;
    return;
  }
  canvas->lib->cairo_show_page(canvas->cairo);
  canvas->lib->cairo_pdf_surface_set_size(canvas->surface, width, height);
  paint_white(canvas);
}

static void set_colour(km_canvas *canvas, km_colour colour) {
  canvas->lib->cairo_set_source_rgba(canvas->cairo, colour.red, colour.green, colour.blue, colour.alpha);
}

enum { DASH_MOST = 8 };

static void stroke(km_canvas *canvas, const km_pen *pen) {
  double dash[DASH_MOST];
  size_t count = pen->dash && pen->dash_count <= DASH_MOST ? pen->dash_count : 0;
  for (size_t i = 0; i < count; i++)
    dash[i] = pen->dash[i] * pen->width;
  canvas->lib->cairo_set_dash(canvas->cairo, dash, (int)count, 0);
  canvas->lib->cairo_set_line_cap(canvas->cairo, count ? CAIRO_LINE_CAP_BUTT : CAIRO_LINE_CAP_ROUND);
  canvas->lib->cairo_set_line_width(canvas->cairo, pen->width);
  set_colour(canvas, pen->colour);
  canvas->lib->cairo_stroke(canvas->cairo);
}

/* Gives the path to the recorder, as it lies on the page. */
static void record(km_canvas *canvas, const km_colour *fill, const km_pen *pen) {
  static const char commands[] = {[CAIRO_PATH_MOVE_TO] = 'M',
                                  [CAIRO_PATH_LINE_TO] = 'L',
                                  [CAIRO_PATH_CURVE_TO] = 'C',
                                  [CAIRO_PATH_CLOSE_PATH] = 'Z'};
  km_text text = {0};
  km_svg_path written = {.out = &text, .decimals = canvas->recorder->decimals, .slack = canvas->recorder->slack};
  cairo_path_t *path = canvas->lib->cairo_copy_path(canvas->cairo);
  for (int i = 0; i < path->num_data; i += path->data[i].header.length) {
    km_canvas_point points[3] = {{0, 0}};
    for (int k = 1; k < path->data[i].header.length; ++k) {
      points[k - 1] = (km_canvas_point){path->data[i + k].point.x, path->data[i + k].point.y};
      canvas->lib->cairo_user_to_device(canvas->cairo, &points[k - 1].x, &points[k - 1].y);
    }
    km_svg_path_add(&written, commands[path->data[i].header.type], points);
  }
  km_svg_path_end(&written);
  canvas->lib->cairo_path_destroy(path);
  canvas->lib->cairo_new_path(canvas->cairo);
  canvas->recorder->shape(canvas->recorder->context, text.failed ? NULL : text.data ? text.data : "", fill, pen);
  km_text_free(&text);
}

/* Fills the path, draws its rim, or both. */
static void paint(km_canvas *canvas, const km_colour *fill, const km_pen *pen) {
  if (canvas->recorder) {
    record(canvas, fill, pen);
    return;
  }
  if (fill) {
    set_colour(canvas, *fill);
    canvas->lib->cairo_fill_preserve(canvas->cairo);
  }
  if (pen)
    stroke(canvas, pen);
  canvas->lib->cairo_new_path(canvas->cairo);
}

static void trace(km_canvas *canvas, const km_canvas_point *points, size_t count) {
  for (size_t i = 0; i < count; i++)
    canvas->lib->cairo_line_to(canvas->cairo, points[i].x, points[i].y);
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
  canvas->lib->cairo_rectangle(canvas->cairo, x, y, width, height);
  paint(canvas, &fill, NULL);
}

void km_canvas_circle(km_canvas *canvas, km_colour fill, const km_pen *pen, km_canvas_point centre, double radius) {
  canvas->lib->cairo_new_sub_path(canvas->cairo);
  canvas->lib->cairo_arc(canvas->cairo, centre.x, centre.y, radius, 0, 2 * G_PI);
  paint(canvas, &fill, pen);
}

void km_canvas_clip(km_canvas *canvas, double x, double y, double width, double height) {
  canvas->lib->cairo_save(canvas->cairo);
  canvas->lib->cairo_rectangle(canvas->cairo, x, y, width, height);
  canvas->lib->cairo_clip(canvas->cairo);
}

void km_canvas_release(km_canvas *canvas) {
  canvas->lib->cairo_restore(canvas->cairo);
}

void km_canvas_shift(km_canvas *canvas, double right, double down) {
  canvas->lib->cairo_translate(canvas->cairo, right, down);
}

static void set_text(km_canvas *canvas, const char *text) {
  char *valid = canvas->lib->g_utf8_make_valid(text, -1); /* Pango would complain on stderr */
  canvas->lib->pango_layout_set_text(canvas->layout, valid, -1);
  canvas->lib->g_free(valid);
}

typedef struct text_box {
  double left, top, width, height; /* relative to the layout's own origin */
} text_box;

static text_box lay_text(km_canvas *canvas, const km_font *font, const char *text) {
  canvas->lib->pango_font_description_set_absolute_size(canvas->font, font->size * PANGO_SCALE);
  canvas->lib->pango_font_description_set_weight(canvas->font, font->bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
  canvas->lib->pango_layout_set_font_description(canvas->layout, canvas->font);
  canvas->lib->pango_layout_set_width(canvas->layout, font->width > 0 ? (int)(font->width * PANGO_SCALE) : -1);
  canvas->lib->pango_layout_set_height(canvas->layout, font->lines > 1 ? -font->lines : -1);
  set_text(canvas, text);
  PangoRectangle box;
  canvas->lib->pango_layout_get_extents(canvas->layout, NULL, &box);
  text_box result = {(double)box.x / PANGO_SCALE, (double)box.y / PANGO_SCALE, (double)box.width / PANGO_SCALE,
                     (double)box.height / PANGO_SCALE};
  if (canvas->lib->pango_layout_get_line_count(canvas->layout) == 1) {
    double baseline = (double)canvas->lib->pango_layout_get_baseline(canvas->layout) / PANGO_SCALE;
    result.top = baseline - font_ascent * font->size;
    result.height = font_height * font->size;
  }
  return result;
}

/* Every line of the layout whose box begins at (left, top) before it is turned. */
static void record_lines(km_canvas *canvas, const km_font *font, km_colour colour, double left, double top,
                         double angle) {
  const char *text = canvas->lib->pango_layout_get_text(canvas->layout);
  PangoLayoutIter *iter = canvas->lib->pango_layout_get_iter(canvas->layout);
  do {
    PangoLayoutLine *line = canvas->lib->pango_layout_iter_get_line_readonly(iter);
    PangoRectangle box;
    canvas->lib->pango_layout_iter_get_line_extents(iter, NULL, &box);
    double x = left + (double)box.x / PANGO_SCALE;
    double y = top + (double)canvas->lib->pango_layout_iter_get_baseline(iter) / PANGO_SCALE;
    km_canvas_point at = {x, y};
    canvas->lib->cairo_user_to_device(canvas->cairo, &at.x, &at.y);
    char *part = canvas->lib->g_strndup(text + line->start_index, (gsize)line->length);
    canvas->recorder->line(canvas->recorder->context, part, font, colour, at, (double)box.width / PANGO_SCALE, angle);
    canvas->lib->g_free(part);
  } while (canvas->lib->pango_layout_iter_next_line(iter));
  canvas->lib->pango_layout_iter_free(iter);
}

void km_canvas_text(km_canvas *canvas, const km_font *font, km_colour colour, const char *text, km_canvas_point at,
                    km_anchor anchor) {
  text_box box = lay_text(canvas, font, text);
  canvas->lib->cairo_save(canvas->cairo);
  canvas->lib->cairo_translate(canvas->cairo, at.x, at.y);
  canvas->lib->cairo_rotate(canvas->cairo, anchor.angle);
  double left = -box.left - anchor.across * box.width, top = -box.top - anchor.down * box.height;
  if (canvas->recorder) {
    record_lines(canvas, font, colour, left, top, anchor.angle);
  } else {
    canvas->lib->cairo_move_to(canvas->cairo, left, top);
    set_colour(canvas, colour);
    canvas->lib->pango_cairo_show_layout(canvas->cairo, canvas->layout);
  }
  canvas->lib->cairo_restore(canvas->cairo);
  canvas->lib->cairo_new_path(canvas->cairo);
}

km_canvas_point km_canvas_measure(km_canvas *canvas, const km_font *font, const char *text) {
  text_box box = lay_text(canvas, font, text);
  return (km_canvas_point){box.width, box.height};
}
