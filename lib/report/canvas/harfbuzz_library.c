/* Loads HarfBuzz and finds the files of the default font. */
#include "report/canvas/harfbuzz_library.h"

#include "base/dynamic_library.h"
#include "base/parallel.h"
#include "report/canvas/canvas_path.h"

#include <stdio.h>

static km_harfbuzz functions;

/* Folders of DejaVu: Debian, Fedora, Arch, local. fontconfig would take longer than drawing a picture. */
static const char *const folders[] = {"/usr/share/fonts/truetype/dejavu", "/usr/share/fonts/dejavu-sans-fonts",
                                      "/usr/share/fonts/dejavu", "/usr/share/fonts/TTF", "/usr/local/share/fonts"};
static const char *const names[] = {"DejaVuSans.ttf", "DejaVuSans-Bold.ttf"};

static bool load(void) {
#define X(name) #name,
  static const char *const symbols[] = {KM_HARFBUZZ_FUNCTIONS(X) NULL};
#undef X
  static const char *const files[] = {"libharfbuzz.so.0", NULL};
  static km_library library = {files, symbols, &functions, false};
  return km_library_load(&library) == NULL;
}

static bool open_face(const char *folder, const char *name, km_face *face) {
  snprintf(face->file, sizeof face->file, "%s/%s", folder, name);
  hb_blob_t *blob = functions.hb_blob_create_from_file_or_fail(face->file);
  if (!blob)
    return false;
  hb_face_t *made = functions.hb_face_create(blob, 0);
  functions.hb_blob_destroy(blob);
  face->units = functions.hb_face_get_upem(made);
  face->font = functions.hb_font_create(made);
  return face->units > 0;
}

static bool open_faces(km_faces *faces) {
  for (size_t i = 0; i < sizeof folders / sizeof *folders; ++i)
    if (open_face(folders[i], names[0], &faces->faces[0]))
      return open_face(folders[i], names[1], &faces->faces[1]);
  return false;
}

/* Font units with y up to those with y down. */
static km_canvas_point point(float x, float y) {
  return (km_canvas_point){(double)x, -(double)y};
}

static void move(hb_draw_funcs_t *d, void *path, hb_draw_state_t *state, float x, float y, void *user) {
  const km_canvas_point to = point(x, y);
  (void)d, (void)state, (void)user;
  km_canvas_path_add(path, 'M', &to);
}

static void line(hb_draw_funcs_t *d, void *path, hb_draw_state_t *state, float x, float y, void *user) {
  const km_canvas_point to = point(x, y);
  (void)d, (void)state, (void)user;
  km_canvas_path_add(path, 'L', &to);
}

static void quadratic(hb_draw_funcs_t *d, void *path, hb_draw_state_t *state, float cx, float cy, float x, float y,
                      void *user) {
  const km_canvas_point points[] = {point(cx, cy), point(x, y)};
  (void)d, (void)state, (void)user;
  km_canvas_path_add(path, 'Q', points);
}

static void cubic(hb_draw_funcs_t *d, void *path, hb_draw_state_t *state, float ax, float ay, float bx, float by,
                  float x, float y, void *user) {
  const km_canvas_point points[] = {point(ax, ay), point(bx, by), point(x, y)};
  (void)d, (void)state, (void)user;
  km_canvas_path_add(path, 'C', points);
}

static void close_path(hb_draw_funcs_t *d, void *path, hb_draw_state_t *state, void *user) {
  (void)d, (void)state, (void)user;
  km_canvas_path_add(path, 'Z', NULL);
}

static hb_draw_funcs_t *make_draw(void) {
  hb_draw_funcs_t *draw = functions.hb_draw_funcs_create();
  functions.hb_draw_funcs_set_move_to_func(draw, move, NULL, NULL);
  functions.hb_draw_funcs_set_line_to_func(draw, line, NULL, NULL);
  functions.hb_draw_funcs_set_quadratic_to_func(draw, quadratic, NULL, NULL);
  functions.hb_draw_funcs_set_cubic_to_func(draw, cubic, NULL, NULL);
  functions.hb_draw_funcs_set_close_path_func(draw, close_path, NULL, NULL);
  return draw;
}

/* The library and fonts, found once in a process. */
static struct {
  km_faces faces;
  bool asked, there;
} known;

static void find(void *context) {
  (void)context;
  if (known.asked)
    return;
  known.asked = true;
  known.there = open_faces(&known.faces);
  known.faces.lib = &functions;
  known.faces.draw = make_draw();
}

const km_faces *km_faces_find(void) {
  if (!load())
    return NULL;
  km_serially(find, NULL);
  return known.there ? &known.faces : NULL;
}
