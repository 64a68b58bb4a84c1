/* Text in any script and font. */
#include "report/canvas/pango_text.h"

#include "base/memory.h"
#include "report/canvas/cairo_library.h"
#include "report/canvas/letters.h"

static const char font_family[] = "DejaVu Sans";

struct km_pango {
  const km_pango_functions *lib;
  PangoLayout *layout; /* one for all texts: making layouts costs more than filling them */
  PangoFontDescription *font;
};

/* Unhinted metrics in a fixed language: a layout depends on neither the format nor the locale. */
static void prepare(km_pango *p) {
  const km_pango_functions *lib = p->lib;
  PangoContext *context = lib->pango_font_map_create_context(lib->pango_cairo_font_map_get_default());
  cairo_font_options_t *options = lib->cairo_font_options_create();
  lib->cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  lib->cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  lib->cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  lib->pango_cairo_context_set_font_options(context, options);
  lib->cairo_font_options_destroy(options);
  lib->pango_context_set_round_glyph_positions(context, FALSE);
  lib->pango_context_set_language(context, lib->pango_language_from_string("en"));
  p->layout = lib->pango_layout_new(context);
  lib->g_object_unref(context);
  lib->pango_layout_set_single_paragraph_mode(p->layout, TRUE);
  lib->pango_layout_set_ellipsize(p->layout, PANGO_ELLIPSIZE_MIDDLE);
  p->font = lib->pango_font_description_from_string(font_family);
}

km_status km_pango_create(km_pango **pango, km_error *error) {
  const km_pango_functions *lib = km_pango_load(error);
  *pango = NULL;
  if (!lib)
    return KM_IO;
  *pango = KM_NEW(km_pango, 1);
  if (!*pango)
    return km_fail(error, KM_MEMORY, "out of memory for a page");
  (*pango)->lib = lib;
  prepare(*pango);
  return KM_OK;
}

void km_pango_free(km_pango *pango) {
  if (!pango)
    return;
  pango->lib->pango_font_description_free(pango->font);
  pango->lib->g_object_unref(pango->layout);
  km_free(pango);
}

static void set_string(km_pango *p, const char *text) {
  char *valid = p->lib->g_utf8_make_valid(text, -1); /* Pango would complain on stderr */
  p->lib->pango_layout_set_text(p->layout, valid, -1);
  p->lib->g_free(valid);
}

km_text_box km_pango_set(km_pango *p, const km_font *font, const char *text) {
  const km_pango_functions *lib = p->lib;
  lib->pango_font_description_set_absolute_size(p->font, font->size * PANGO_SCALE);
  lib->pango_font_description_set_weight(p->font, font->bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
  lib->pango_layout_set_font_description(p->layout, p->font);
  lib->pango_layout_set_width(p->layout, font->width > 0 ? (int)(font->width * PANGO_SCALE) : -1);
  lib->pango_layout_set_height(p->layout, font->lines > 1 ? -font->lines : -1);
  set_string(p, text);
  PangoRectangle box;
  lib->pango_layout_get_extents(p->layout, NULL, &box);
  km_text_box result = {(double)box.x / PANGO_SCALE, (double)box.y / PANGO_SCALE, (double)box.width / PANGO_SCALE,
                        (double)box.height / PANGO_SCALE};
  if (lib->pango_layout_get_line_count(p->layout) == 1) {
    double baseline = (double)lib->pango_layout_get_baseline(p->layout) / PANGO_SCALE;
    result.top = baseline - KM_FONT_ASCENT * font->size;
    result.height = KM_FONT_HEIGHT * font->size;
  }
  return result;
}

const char *km_pango_string(const km_pango *p) {
  return p->lib->pango_layout_get_text(p->layout);
}

void km_pango_lines(const km_pango *p, void (*take)(void *context, const km_pango_line *line), void *context) {
  PangoLayoutIter *iter = p->lib->pango_layout_get_iter(p->layout);
  do {
    const PangoLayoutLine *line = p->lib->pango_layout_iter_get_line_readonly(iter);
    PangoRectangle box;
    p->lib->pango_layout_iter_get_line_extents(iter, NULL, &box);
    const km_pango_line found = {.begin = (size_t)line->start_index,
                                 .size = (size_t)line->length,
                                 .x = (double)box.x / PANGO_SCALE,
                                 .baseline = (double)p->lib->pango_layout_iter_get_baseline(iter) / PANGO_SCALE,
                                 .width = (double)box.width / PANGO_SCALE};
    take(context, &found);
  } while (p->lib->pango_layout_iter_next_line(iter));
  p->lib->pango_layout_iter_free(iter);
}

/* Cairo's path, whose commands have the order of its enumeration. */
static void copy_path(const cairo_path_t *from, km_canvas_path *path) {
  static const char commands[] = {[CAIRO_PATH_MOVE_TO] = 'M',
                                  [CAIRO_PATH_LINE_TO] = 'L',
                                  [CAIRO_PATH_CURVE_TO] = 'C',
                                  [CAIRO_PATH_CLOSE_PATH] = 'Z'};
  for (int i = 0; i < from->num_data; i += from->data[i].header.length) {
    km_canvas_point points[3] = {{0, 0}};
    for (int k = 1; k < from->data[i].header.length; ++k)
      points[k - 1] = (km_canvas_point){from->data[i + k].point.x, from->data[i + k].point.y};
    km_canvas_path_add(path, commands[from->data[i].header.type], points);
  }
}

void km_pango_outline(km_pango *p, km_canvas_path *path) {
  /* Unbounded: an image surface would drop glyphs outside of it. */
  cairo_surface_t *surface = p->lib->cairo_recording_surface_create(CAIRO_CONTENT_ALPHA, NULL);
  cairo_t *cairo = p->lib->cairo_create(surface);
  p->lib->pango_cairo_layout_path(cairo, p->layout);
  cairo_path_t *outline = p->lib->cairo_copy_path(cairo);
  path->failed = path->failed || outline->status != CAIRO_STATUS_SUCCESS;
  copy_path(outline, path);
  p->lib->cairo_path_destroy(outline);
  p->lib->cairo_destroy(cairo);
  p->lib->cairo_surface_destroy(surface);
}

void km_pango_show(km_pango *pango, void *cairo) {
  pango->lib->pango_cairo_show_layout(cairo, pango->layout);
}
