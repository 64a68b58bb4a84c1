/* Pages of PDF and PNG, by cairo. */
#include "base/memory.h"
#include "base/parallel.h"
#include "report/canvas/cairo_library.h"
#include "report/canvas/canvas_device.h"
#include "report/canvas/png.h"

#include <math.h>
#include <string.h>

static const double png_scale = 2; /* 144 dpi, */
static const unsigned png_per_metre = 5669;

typedef struct cairo_page {
  const km_cairo *lib;
  km_picture_format format;
  km_text *out; /* NULL: nothing more is taken */
  cairo_surface_t *surface;
  cairo_t *cairo;
  cairo_glyph_t *glyphs; /* bytes of a line */
  cairo_text_cluster_t *clusters;
  size_t glyph_room, cluster_room;
  bool failed;
} cairo_page;

static cairo_status_t append(void *closure, const unsigned char *bytes, unsigned size) {
  cairo_page *page = closure;
  if (!page->out)
    return CAIRO_STATUS_SUCCESS;
  km_text_bytes(page->out, bytes, size);
  return page->out->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

static cairo_surface_t *make_surface(cairo_page *page, double width, double height) {
  if (page->format == KM_PICTURE_PNG)
    return page->lib->cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)lround(width * png_scale),
                                                 (int)lround(height * png_scale));
  cairo_surface_t *surface = page->lib->cairo_pdf_surface_create_for_stream(append, page, width, height);
  /* Cairo would stamp the time of drawing: the same input must give the same bytes. */
  page->lib->cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  return surface;
}

static void paint_white(cairo_page *page) {
  page->lib->cairo_set_source_rgb(page->cairo, 1, 1, 1);
  page->lib->cairo_paint(page->cairo);
}

/* Opens the two faces of the default font for the process; cairo locks them during drawing. */
typedef struct open_font {
  const km_cairo *lib;
  const char *files[2];
  cairo_font_face_t *faces[2]; /* NULL: there was no memory */
} open_font;

static void open_faces(void *context) {
  static cairo_font_face_t *faces[2];
  open_font *o = context;
  FT_Library library;
  if (!faces[0] && !o->lib->FT_Init_FreeType(&library))
    for (int bold = 0; bold < 2; ++bold) {
      FT_Face face;
      if (o->lib->FT_New_Face(library, o->files[bold], 0, &face) == 0)
        faces[bold] = o->lib->cairo_ft_font_face_create_for_ft_face(face, 0);
    }
  o->faces[0] = faces[0];
  o->faces[1] = faces[1];
}

static cairo_font_face_t *face_of(cairo_page *page, bool bold) {
  open_font o = {.lib = page->lib, .files = {km_letters_file(false), km_letters_file(true)}};
  km_serially(open_faces, &o);
  page->failed = page->failed || !o.faces[bold];
  return o.faces[bold];
}

/* Nothing is hinted: sizes don't depend on the format. */
static void prepare_text(cairo_page *page) {
  cairo_font_options_t *options = page->lib->cairo_font_options_create();
  page->lib->cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  page->lib->cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  page->lib->cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  page->lib->cairo_set_font_options(page->cairo, options);
  page->lib->cairo_font_options_destroy(options);
}

km_status km_cairo_page_create(km_picture_format format, double width, double height, km_text *out, void **page,
                               km_error *error) {
  const km_cairo *lib = km_cairo_load(error);
  *page = NULL;
  if (!lib)
    return KM_IO;
  cairo_page *made = KM_NEW(cairo_page, 1);
  if (!made)
    return km_fail(error, KM_MEMORY, "out of memory for a page");
  made->lib = lib;
  made->format = format;
  made->out = out;
  made->surface = make_surface(made, width, height);
  made->cairo = lib->cairo_create(made->surface);
  if (format == KM_PICTURE_PNG)
    lib->cairo_scale(made->cairo, png_scale, png_scale);
  lib->cairo_set_line_join(made->cairo, CAIRO_LINE_JOIN_ROUND);
  prepare_text(made);
  paint_white(made);
  *page = made;
  return KM_OK;
}

static void set_colour(cairo_page *page, km_colour colour) {
  page->lib->cairo_set_source_rgba(page->cairo, colour.red, colour.green, colour.blue, colour.alpha);
}

enum { DASH_MOST = 8 };

static void stroke(cairo_page *page, const km_pen *pen) {
  double dash[DASH_MOST];
  size_t count = pen->dash && pen->dash_count <= DASH_MOST ? pen->dash_count : 0;
  for (size_t i = 0; i < count; i++)
    dash[i] = pen->dash[i] * pen->width;
  page->lib->cairo_set_dash(page->cairo, dash, (int)count, 0);
  page->lib->cairo_set_line_cap(page->cairo, count ? CAIRO_LINE_CAP_BUTT : CAIRO_LINE_CAP_ROUND);
  page->lib->cairo_set_line_width(page->cairo, pen->width);
  set_colour(page, pen->colour);
  page->lib->cairo_stroke(page->cairo);
}

static void trace(cairo_page *page, const km_canvas_path *path) {
  const km_canvas_point *p = path->points;
  for (size_t i = 0; i < path->command_count; ++i) {
    char command = path->commands[i];
    if (command == 'M')
      page->lib->cairo_move_to(page->cairo, p->x, p->y);
    else if (command == 'L')
      page->lib->cairo_line_to(page->cairo, p->x, p->y);
    else if (command == 'C')
      page->lib->cairo_curve_to(page->cairo, p[0].x, p[0].y, p[1].x, p[1].y, p[2].x, p[2].y);
    else
      page->lib->cairo_close_path(page->cairo);
    p += km_canvas_path_takes(command);
  }
}

static void draw_shape(void *context, const km_canvas_path *path, const km_colour *fill, const km_pen *pen) {
  cairo_page *page = context;
  trace(page, path);
  if (fill) {
    set_colour(page, *fill);
    page->lib->cairo_fill_preserve(page->cairo);
  }
  if (pen)
    stroke(page, pen);
  page->lib->cairo_new_path(page->cairo);
}

static bool reserve(cairo_page *page, size_t count) {
  void *glyphs = page->glyphs, *clusters = page->clusters;
  if (!km_reserve(&glyphs, &page->glyph_room, count, sizeof *page->glyphs) ||
      !km_reserve(&clusters, &page->cluster_room, count, sizeof *page->clusters))
    page->failed = true;
  page->glyphs = glyphs;
  page->clusters = clusters;
  return !page->failed;
}

/* Fills in glyphs and clusters (the bytes of each glyph, for copying text from a PDF). Returns the number of
 * clusters. */
static int copy_letters(cairo_page *page, const km_letters *letters, const km_letters_line *line) {
  int clusters = 0;
  for (size_t i = 0; i < line->count; ++i) {
    const km_letter *letter = &letters->items[line->first + i];
    bool last = i + 1 == line->count;
    size_t behind = last ? line->begin + line->size : letter[1].byte;
    page->glyphs[i] = (cairo_glyph_t){letter->glyph, letter->x * letters->unit, 0.0};
    if (i == 0 || letter->byte != letter[-1].byte)
      page->clusters[clusters++] = (cairo_text_cluster_t){0, 0};
    page->clusters[clusters - 1].num_glyphs++;
    page->clusters[clusters - 1].num_bytes += (int)(behind - letter->byte);
  }
  return clusters;
}

static void begin_text(cairo_page *page, km_colour colour, const km_text_place *place) {
  page->lib->cairo_save(page->cairo);
  page->lib->cairo_translate(page->cairo, place->at.x, place->at.y);
  page->lib->cairo_rotate(page->cairo, place->angle);
  set_colour(page, colour);
}

static void end_text(cairo_page *page) {
  page->lib->cairo_restore(page->cairo);
  page->lib->cairo_new_path(page->cairo);
}

static void draw_line(void *context, const km_letters *letters, size_t line, const km_font *font, km_colour colour,
                      const km_text_place *place) {
  cairo_page *page = context;
  const km_letters_line *l = &letters->lines[line];
  cairo_font_face_t *face = face_of(page, letters->bold);
  if (!face || !reserve(page, l->count))
    return;
  int clusters = copy_letters(page, letters, l);
  begin_text(page, colour, place);
  page->lib->cairo_set_font_face(page->cairo, face);
  page->lib->cairo_set_font_size(page->cairo, font->size);
  page->lib->cairo_show_text_glyphs(page->cairo, letters->text + l->begin, (int)l->size, page->glyphs, (int)l->count,
                                    page->clusters, clusters, 0);
  end_text(page);
}

static void draw_layout(void *context, km_pango *pango, const km_font *font, km_colour colour,
                        const km_text_place *place) {
  cairo_page *page = context;
  (void)font;
  begin_text(page, colour, place);
  page->lib->cairo_move_to(page->cairo, 0, 0);
  km_pango_show(pango, page->cairo);
  end_text(page);
}

/* The rest of a PNG file that is read. */
typedef struct png_reader {
  const char *data;
  size_t size;
} png_reader;

static cairo_status_t read_png(void *closure, unsigned char *out, unsigned size) {
  png_reader *reader = closure;
  if (size > reader->size)
    return CAIRO_STATUS_READ_ERROR;
  memcpy(out, reader->data, size);
  reader->data += size;
  reader->size -= size;
  return CAIRO_STATUS_SUCCESS;
}

/* A file that can't be decoded leaves cairo's context with its status, which `finish` returns. */
static void draw_pixels(void *context, const km_text *png, double x, double y, double scale) {
  cairo_page *page = context;
  png_reader reader = {png->data, png->size};
  cairo_surface_t *pixels = page->lib->cairo_image_surface_create_from_png_stream(read_png, &reader);
  page->lib->cairo_save(page->cairo);
  page->lib->cairo_translate(page->cairo, x, y);
  page->lib->cairo_scale(page->cairo, scale, scale);
  page->lib->cairo_set_source_surface(page->cairo, pixels, 0, 0);
  page->lib->cairo_paint(page->cairo);
  page->lib->cairo_restore(page->cairo);
  page->lib->cairo_surface_destroy(pixels);
}

static void clip(void *context, double x, double y, double width, double height) {
  cairo_page *page = context;
  page->lib->cairo_save(page->cairo);
  page->lib->cairo_rectangle(page->cairo, x, y, width, height);
  page->lib->cairo_clip(page->cairo);
}

static void release(void *context) {
  cairo_page *page = context;
  page->lib->cairo_restore(page->cairo);
}

static bool next(void *context, double width, double height) {
  cairo_page *page = context;
  if (page->format != KM_PICTURE_PDF)
    return false;
  page->lib->cairo_show_page(page->cairo);
  page->lib->cairo_pdf_surface_set_size(page->surface, width, height);
  paint_white(page);
  return true;
}

static cairo_status_t write_pixels(cairo_page *page) {
  const km_cairo *lib = page->lib;
  lib->cairo_surface_flush(page->surface);
  const km_pixels pixels = {.data = lib->cairo_image_surface_get_data(page->surface),
                            .width = lib->cairo_image_surface_get_width(page->surface),
                            .height = lib->cairo_image_surface_get_height(page->surface),
                            .stride = lib->cairo_image_surface_get_stride(page->surface),
                            .per_metre = png_per_metre};
  return pixels.data && km_png_write(&pixels, page->out) ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_NO_MEMORY;
}

static km_status finish(void *context, km_error *error) {
  cairo_page *page = context;
  cairo_status_t status = page->lib->cairo_status(page->cairo);
  if (status == CAIRO_STATUS_SUCCESS && page->format == KM_PICTURE_PNG)
    status = write_pixels(page);
  page->lib->cairo_surface_finish(page->surface);
  if (status == CAIRO_STATUS_SUCCESS)
    status = page->lib->cairo_surface_status(page->surface);
  if (status == CAIRO_STATUS_NO_MEMORY || page->failed || page->out->failed)
    return km_fail(error, KM_MEMORY, "out of memory for a picture");
  if (status != CAIRO_STATUS_SUCCESS)
    return km_fail(error, KM_INTERNAL, "the picture failed: %s", page->lib->cairo_status_to_string(status));
  return KM_OK;
}

static void free_page(void *context) {
  cairo_page *page = context;
  page->out = NULL; /* an unfinished surface writes its rest when it is destroyed */
  page->lib->cairo_destroy(page->cairo);
  page->lib->cairo_surface_destroy(page->surface);
  km_free(page->glyphs);
  km_free(page->clusters);
  km_free(page);
}

const km_device km_cairo_device = {draw_shape, draw_line, draw_layout, draw_pixels, clip,
                                   release,    next,      finish,      free_page};
