/* HarfBuzz, loaded with the first text, and the two faces of the default font. Private to report/. */
#ifndef KM_REPORT_CANVAS_HARFBUZZ_LIBRARY_H
#define KM_REPORT_CANVAS_HARFBUZZ_LIBRARY_H

#include <hb.h>
#include <stdbool.h>

#define KM_HARFBUZZ_FUNCTIONS(X)                                                                                       \
  X(hb_blob_create_from_file_or_fail)                                                                                  \
  X(hb_blob_destroy)                                                                                                   \
  X(hb_buffer_add_utf8)                                                                                                \
  X(hb_buffer_allocation_successful)                                                                                   \
  X(hb_buffer_clear_contents)                                                                                          \
  X(hb_buffer_create)                                                                                                  \
  X(hb_buffer_destroy)                                                                                                 \
  X(hb_buffer_get_glyph_infos)                                                                                         \
  X(hb_buffer_get_glyph_positions)                                                                                     \
  X(hb_buffer_set_direction)                                                                                           \
  X(hb_buffer_set_language)                                                                                            \
  X(hb_buffer_set_script)                                                                                              \
  X(hb_draw_funcs_create)                                                                                              \
  X(hb_draw_funcs_set_close_path_func)                                                                                 \
  X(hb_draw_funcs_set_cubic_to_func)                                                                                   \
  X(hb_draw_funcs_set_line_to_func)                                                                                    \
  X(hb_draw_funcs_set_move_to_func)                                                                                    \
  X(hb_draw_funcs_set_quadratic_to_func)                                                                               \
  X(hb_face_create)                                                                                                    \
  X(hb_face_get_upem)                                                                                                  \
  X(hb_font_create)                                                                                                    \
  X(hb_font_get_glyph_h_advance)                                                                                       \
  X(hb_font_get_glyph_shape)                                                                                           \
  X(hb_font_get_nominal_glyph)                                                                                         \
  X(hb_language_from_string)                                                                                           \
  X(hb_shape)                                                                                                          \
  X(hb_unicode_funcs_get_default)                                                                                      \
  X(hb_unicode_script)

/* A pointer to each of them, under its own name. */
typedef struct km_harfbuzz {
#define X(name) __typeof__(&(name)) name;
  KM_HARFBUZZ_FUNCTIONS(X)
#undef X
} km_harfbuzz;

/* The default font, for the whole process: nothing of it changes. */
typedef struct km_face {
  hb_font_t *font;
  char file[256];
  unsigned units; /* units of an em */
} km_face;

typedef struct km_faces {
  const km_harfbuzz *lib;
  km_face faces[2];      /* regular, bold */
  hb_draw_funcs_t *draw; /* adds to the km_canvas_path that it is given */
} km_faces;

/* Loads HarfBuzz and the fonts once; thread-safe. NULL if HarfBuzz or a font file is missing. */
const km_faces *km_faces_find(void);

#endif
