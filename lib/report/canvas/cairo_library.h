/* The functions of cairo, FreeType and Pango that pages are drawn with. cairo and FreeType are loaded for the first
 * page of a PDF or PNG, Pango and what it needs for the first text that needs it: linked, they would cost every
 * start of a tool 4 ms. Private to report/. */
#ifndef KM_REPORT_CANVAS_CAIRO_LIBRARY_H
#define KM_REPORT_CANVAS_CAIRO_LIBRARY_H

#include "kmech/base.h"

#include <cairo-ft.h>
#include <cairo-pdf.h>
#include <pango/pangocairo.h>

/* clang-format off */
#define KM_CAIRO_FUNCTIONS(X)                                                                                          \
  X(FT_Init_FreeType) X(FT_New_Face) X(cairo_clip) X(cairo_close_path) X(cairo_create) X(cairo_curve_to)               \
  X(cairo_destroy) X(cairo_fill_preserve) X(cairo_font_options_create) X(cairo_font_options_destroy)                   \
  X(cairo_font_options_set_antialias) X(cairo_font_options_set_hint_metrics) X(cairo_font_options_set_hint_style)      \
  X(cairo_ft_font_face_create_for_ft_face) X(cairo_image_surface_create)                                               \
  X(cairo_image_surface_create_from_png_stream) X(cairo_image_surface_get_data) X(cairo_image_surface_get_height)      \
  X(cairo_image_surface_get_stride) X(cairo_image_surface_get_width) X(cairo_line_to) X(cairo_move_to)                 \
  X(cairo_new_path) X(cairo_paint) X(cairo_pdf_surface_create_for_stream) X(cairo_pdf_surface_set_metadata)            \
  X(cairo_pdf_surface_set_size) X(cairo_rectangle) X(cairo_restore) X(cairo_rotate) X(cairo_save) X(cairo_scale)       \
  X(cairo_set_dash) X(cairo_set_font_face) X(cairo_set_font_options) X(cairo_set_font_size) X(cairo_set_line_cap)      \
  X(cairo_set_line_join) X(cairo_set_line_width) X(cairo_set_source_rgb) X(cairo_set_source_rgba)                      \
  X(cairo_set_source_surface) X(cairo_show_page) X(cairo_show_text_glyphs) X(cairo_status) X(cairo_status_to_string)   \
  X(cairo_stroke) X(cairo_surface_destroy) X(cairo_surface_finish) X(cairo_surface_flush) X(cairo_surface_status)      \
  X(cairo_translate)

#define KM_PANGO_FUNCTIONS(X)                                                                                          \
  X(cairo_copy_path) X(cairo_create) X(cairo_destroy) X(cairo_font_options_create) X(cairo_font_options_destroy)       \
  X(cairo_font_options_set_antialias) X(cairo_font_options_set_hint_metrics) X(cairo_font_options_set_hint_style)      \
  X(cairo_path_destroy) X(cairo_recording_surface_create) X(cairo_surface_destroy) X(g_free) X(g_object_unref) \
  X(g_utf8_make_valid) X(pango_cairo_context_set_font_options) X(pango_cairo_font_map_get_default)                     \
  X(pango_cairo_layout_path) X(pango_cairo_show_layout) X(pango_context_set_language)                                  \
  X(pango_context_set_round_glyph_positions) X(pango_font_description_free) X(pango_font_description_from_string)      \
  X(pango_font_description_set_absolute_size) X(pango_font_description_set_weight) X(pango_font_map_create_context)    \
  X(pango_language_from_string) X(pango_layout_get_baseline) X(pango_layout_get_extents) X(pango_layout_get_iter)      \
  X(pango_layout_get_line_count) X(pango_layout_get_text) X(pango_layout_iter_free) X(pango_layout_iter_get_baseline)  \
  X(pango_layout_iter_get_line_extents) X(pango_layout_iter_get_line_readonly) X(pango_layout_iter_next_line)          \
  X(pango_layout_new) X(pango_layout_set_ellipsize) X(pango_layout_set_font_description) X(pango_layout_set_height)    \
  X(pango_layout_set_single_paragraph_mode) X(pango_layout_set_text) X(pango_layout_set_width)
/* clang-format on */

/* A pointer to each of them, under its own name. */
#define X(name) __typeof__(&(name)) name;
typedef struct km_cairo {
  KM_CAIRO_FUNCTIONS(X)
} km_cairo;

typedef struct km_pango_functions {
  KM_PANGO_FUNCTIONS(X)
} km_pango_functions;
#undef X

/* Loads the libraries once; thread-safe. NULL with KM_IO if they aren't installed. Never unloaded. */
const km_cairo *km_cairo_load(km_error *error);
const km_pango_functions *km_pango_load(km_error *error);

#endif
