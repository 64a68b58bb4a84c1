/* Pages of SVG. Text is drawn by outlines, which look the same everywhere: each glyph that occurs is defined once,
 * in the font's own units. */
#include "base/text.h"
#include "report/canvas/canvas_device.h"
#include "report/canvas/svg_path.h"

#include <math.h>

enum { GLYPHS = 65536 };                  /* bytes of a font file at most */
enum { DECIMALS = 3, SIZE_DECIMALS = 6 }; /* rounding of points: coordinates, and sizes of the page */

typedef enum glyph_state { UNKNOWN, OUTLINE, BLANK } glyph_state;

typedef struct svg_page {
  km_text *out;
  double width, height;
  km_text glyphs, body;
  unsigned char state[2][GLYPHS]; /* [glyph] state of regular and bold glyphs: glyph_state */
  int clips;
  km_canvas_path path; /* number of outlines that aren't the canvas's own */
} svg_page;

static void add_number(km_text *out, const char *before, double value) {
  km_text_add(out, before);
  km_svg_number(out, value, DECIMALS);
}

static void add_size(km_text *out, const char *before, double value) {
  km_text_add(out, before);
  km_svg_number(out, value, SIZE_DECIMALS);
}

/* fill or stroke, and how much of it is seen. */
static void add_colour(km_text *out, const char *property, km_colour c) {
  static const char hex[] = "0123456789abcdef";
  const double parts[] = {c.red, c.green, c.blue};
  char digits[6];
  for (int i = 0; i < 3; ++i) {
    int value = (int)lround(255 * fmin(fmax(parts[i], 0.0), 1.0));
    digits[2 * i] = hex[value >> 4];
    digits[2 * i + 1] = hex[value & 15];
  }
  km_text_add(out, " ");
  km_text_add(out, property);
  km_text_add(out, "=\"#");
  km_text_bytes(out, digits, sizeof digits);
  if (c.alpha < 1.0) {
    km_text_add(out, "\" ");
    km_text_add(out, property);
    add_number(out, "-opacity=\"", c.alpha);
  }
  km_text_add(out, "\"");
}

static void add_pen(km_text *out, const km_pen *pen) {
  add_colour(out, "stroke", pen->colour);
  add_number(out, " stroke-width=\"", pen->width);
  for (size_t i = 0; pen->dash && i < pen->dash_count; ++i)
    add_number(out, i ? " " : "\" stroke-linecap=\"butt\" stroke-dasharray=\"", pen->dash[i] * pen->width);
  km_text_add(out, "\"");
}

static void draw_shape(void *page, const km_canvas_path *path, const km_colour *fill, const km_pen *pen) {
  km_text *out = &((svg_page *)page)->body;
  km_text_add(out, "<path");
  if (fill)
    add_colour(out, "fill", *fill);
  if (pen)
    add_pen(out, pen);
  km_text_add(out, " d=\"");
  km_svg_path_write(out, path, DECIMALS, 0.0);
  km_text_add(out, "\"/>\n");
}

static void add_name(km_text *out, bool bold, uint32_t glyph) {
  km_text_format(out, "%c%u", bold ? 'b' : 'r', (unsigned)glyph);
}

/* Defines the glyph where it occurs for the first time. */
static glyph_state define(svg_page *page, bool bold, uint32_t glyph) {
  if (glyph >= GLYPHS)
    return BLANK;
  unsigned char *state = &page->state[bold][glyph];
  if (*state != UNKNOWN)
    return *state;
  km_canvas_path_clear(&page->path);
  km_letters_outline(bold, glyph, &page->path);
  *state = page->path.command_count ? OUTLINE : BLANK;
  if (*state == BLANK)
    return BLANK;
  km_text_add(&page->glyphs, "<path id=\"");
  add_name(&page->glyphs, bold, glyph);
  km_text_add(&page->glyphs, "\" d=\"");
  km_svg_path_write(&page->glyphs, &page->path, 0, 0.0);
  km_text_add(&page->glyphs, "\"/>\n");
  return OUTLINE;
}

static void draw_line(void *context, const km_letters *letters, size_t line, const km_font *font, km_colour colour,
                      const km_text_place *place) {
  svg_page *page = context;
  km_text *out = &page->body;
  (void)font;
  km_text_add(out, "<g");
  add_colour(out, "fill", colour);
  add_number(out, " transform=\"translate(", place->at.x);
  add_number(out, " ", place->at.y);
  if (place->angle != 0.0)
    add_number(out, ")rotate(", place->angle * 180.0 / M_PI);
  km_text_add(out, ")scale(");
  km_text_number(out, letters->unit);
  km_text_add(out, ")\">");
  for (size_t i = letters->lines[line].first, end = i + letters->lines[line].count; i < end; ++i) {
    const km_letter *letter = &letters->items[i];
    if (define(page, letters->bold, letter->glyph) == BLANK)
      continue;
    km_text_add(out, "<use xlink:href=\"#");
    add_name(out, letters->bold, letter->glyph);
    if (letter->x != 0)
      add_number(out, "\" x=\"", letter->x);
    km_text_add(out, "\"/>");
  }
  km_text_add(out, "</g>\n");
}

/* As one shape. */
static void draw_layout(void *context, km_pango *pango, const km_font *font, km_colour colour,
                        const km_text_place *place) {
  svg_page *page = context;
  (void)font;
  km_canvas_path_clear(&page->path);
  km_pango_outline(pango, &page->path);
  for (size_t i = 0; i < page->path.point_count; ++i)
    page->path.points[i] = km_text_point(place, page->path.points[i].x, page->path.points[i].y);
  draw_shape(page, &page->path, &colour, NULL);
}

static void clip(void *context, double x, double y, double width, double height) {
  svg_page *page = context;
  km_text *out = &page->body;
  int number = page->clips++;
  km_text_format(out, "<clipPath id=\"c%d\"><rect", number);
  add_number(out, " x=\"", x);
  add_number(out, "\" y=\"", y);
  add_number(out, "\" width=\"", width);
  add_number(out, "\" height=\"", height);
  km_text_format(out, "\"/></clipPath>\n<g clip-path=\"url(#c%d)\">\n", number);
}

static void release(void *context) {
  km_text_add(&((svg_page *)context)->body, "</g>\n");
}

static bool next(void *page, double width, double height) {
  (void)page, (void)width, (void)height;
  return false;
}

static km_status finish(void *context, km_error *error) {
  svg_page *page = context;
  km_text *out = page->out;
  km_text_add(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
                   "xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\"");
  add_size(out, " width=\"", page->width);
  add_size(out, "pt\" height=\"", page->height);
  add_size(out, "pt\" viewBox=\"0 0 ", page->width);
  add_size(out, " ", page->height);
  km_text_add(out, "\">\n");
  if (page->glyphs.size) {
    km_text_add(out, "<defs>\n");
    km_text_bytes(out, page->glyphs.data, page->glyphs.size);
    km_text_add(out, "</defs>\n");
  }
  km_text_add(out, "<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n");
  km_text_bytes(out, page->body.data, page->body.size);
  km_text_add(out, "</g>\n</svg>\n");
  bool failed = out->failed || page->glyphs.failed || page->body.failed || page->path.failed;
  return failed ? km_fail(error, KM_MEMORY, "out of memory for a picture") : KM_OK;
}

static void free_page(void *context) {
  svg_page *page = context;
  km_text_free(&page->glyphs);
  km_text_free(&page->body);
  km_canvas_path_free(&page->path);
  km_free(page);
}

const km_device km_svg_device = {draw_shape, draw_line, draw_layout, NULL, clip, release, next, finish, free_page};

km_status km_svg_page_create(double width, double height, km_text *out, void **page, km_error *error) {
  const km_colour white = {1, 1, 1, 1};
  svg_page *made = KM_NEW(svg_page, 1);
  *page = made;
  if (!made)
    return km_fail(error, KM_MEMORY, "out of memory for a page");
  made->out = out;
  made->width = width;
  made->height = height;
  km_canvas_path_rectangle(&made->path, 0, 0, width, height);
  draw_shape(made, &made->path, &white, NULL);
  return KM_OK;
}
