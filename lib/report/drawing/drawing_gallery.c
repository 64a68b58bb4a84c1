/* Grid of small drawings: each pose of a drawing by itself, in one view and at one scale, in frames of the colours of
 * their groups.
 *
 *   columns = max(2, ceil(√(1.4 count))): a page somewhat wider than high */
#include "base/arguments.h"
#include "report/canvas/palette.h"
#include "report/drawing/drawing_poses.h"

#include <math.h>

enum { MOST_GALLERY = 400 }; /* drawings of one page, so that its sides stay below those of a canvas */
static const double cell_size = 150, caption_height = 32, gap = 12, margin = 14, head_height = 40; /* points */
static const km_colour ink = {0.15, 0.15, 0.15, 1}, grey = {0.40, 0.40, 0.40, 1};

typedef struct gallery {
  km_drawing_def def;
  const km_gallery_caption *captions;
  int count, columns;
  km_canvas *canvas;
} gallery;

static double page_width(const gallery *g) {
  return 2 * margin + g->columns * (cell_size + gap) - gap;
}

static double page_height(const gallery *g) {
  int rows = (g->count + g->columns - 1) / g->columns;
  return margin + head_height + rows * (cell_size + caption_height + gap);
}

static void draw_frame(const gallery *g, km_rectangle place, int colour) {
  const km_pen pen = km_palette_pen(colour, 0, 1.6);
  double right = place.left + place.width, bottom = place.top + place.height;
  const km_canvas_point corners[] = {
      {place.left, place.top}, {right, place.top}, {right, bottom}, {place.left, bottom}, {place.left, place.top}};
  km_canvas_polyline(g->canvas, &pen, corners, 5);
}

static km_status draw_cell(gallery *g, int i, km_error *error) {
  const km_gallery_caption *caption = &g->captions[i];
  const km_font bold = {.size = 9.5, .bold = true, .width = cell_size}, plain = {.size = 8.5, .width = cell_size};
  const double inside = 6;
  int colour = caption->group > 0 ? caption->group - 1 : -1;
  km_rectangle place = {margin + i % g->columns * (cell_size + gap),
                        margin + head_height + i / g->columns * (cell_size + caption_height + gap), cell_size,
                        cell_size};
  km_rectangle drawn = {place.left + inside, place.top + inside, place.width - 2 * inside, place.height - 2 * inside};
  g->def.full = (size_t)i;
  km_status status = km_drawing_place(&g->def, g->canvas, drawn, error);
  draw_frame(g, place, colour);
  double below = place.top + cell_size + 4;
  km_canvas_text(g->canvas, &bold, colour < 0 ? ink : km_palette_text(colour), caption->title ? caption->title : "",
                 (km_canvas_point){place.left, below}, (km_anchor){0, 0, 0});
  km_canvas_text(g->canvas, &plain, grey, caption->text ? caption->text : "", (km_canvas_point){place.left, below + 13},
                 (km_anchor){0, 0, 0});
  return status;
}

static km_status draw_page(gallery *g, km_error *error) {
  const km_font title = {.size = 13, .bold = true, .width = page_width(g) - 2 * margin},
                name = {.size = 9, .width = page_width(g) - 2 * margin};
  km_canvas_text(g->canvas, &title, ink, g->def.title ? g->def.title : "", (km_canvas_point){margin, margin},
                 (km_anchor){0, 0, 0});
  km_canvas_text(g->canvas, &name, grey, g->def.name ? g->def.name : "", (km_canvas_point){margin, margin + 18},
                 (km_anchor){0, 0, 0});
  km_status status = KM_OK;
  for (int i = 0; !status && i < g->count; ++i)
    status = draw_cell(g, i, error);
  return status;
}

km_status km_drawing_gallery(const km_drawing *drawing, const km_drawing_look *look, const km_gallery_caption *captions,
                             km_picture_format format, km_text *out, km_error *error) {
  gallery g = {.captions = captions, .count = km_drawing_poses(drawing)};
  km_status status = km_check_picture(out, format, error);
  if (!status)
    status = km_check_given(captions != NULL, "captions", error);
  if (!status)
    status = km_drawing_define(drawing, look, &g.def, error);
  if (!status && g.count > MOST_GALLERY)
    status = km_fail(error, KM_USAGE, "%d drawings on one page; expected at most %d", g.count, MOST_GALLERY);
  if (status)
    return status;
  g.def.alone = g.def.bare = true;
  g.columns = (int)fmax(2.0, ceil(sqrt(1.4 * g.count)));
  status = km_canvas_create(format, page_width(&g), page_height(&g), out, &g.canvas, error);
  if (!status)
    status = draw_page(&g, error);
  if (!status)
    status = km_canvas_finish(g.canvas, error);
  km_canvas_free(g.canvas);
  return status;
}
