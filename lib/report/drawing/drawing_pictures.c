/* Pictures of a drawing: pages, animated pictures, outlines of links. */
#include "base/arguments.h"
#include "base/memory.h"
#include "report/canvas/apng.h"
#include "report/drawing/drawing_poses.h"
#include "report/drawing/link_outlines.h"

enum {
  PICTURES = 72
};                                       /* limits of pixels of an animated picture, and of one frame: a few
                                          * megabytes in all */
static const double picture_width = 360; /* points */

km_status km_drawing_picture(const km_drawing *drawing, const km_drawing_look *look, km_picture_format format,
                             km_text *out, km_error *error) {
  km_drawing_def def;
  km_status status = km_check_picture(out, format, error);
  if (!status)
    status = km_drawing_define(drawing, look, &def, error);
  return status ? status : km_drawing_render(&def, format, out, error);
}

/* One picture of the drawing. */
static km_status add_picture(km_drawing_def *def, size_t pose, km_apng *apng, km_error *error) {
  km_text png = {0};
  def->full = pose;
  km_status status = km_drawing_render(def, KM_PICTURE_PNG, &png, error);
  if (!status)
    status = km_apng_add(apng, &png, error);
  km_text_free(&png);
  return status;
}

km_status km_drawing_apng(const km_drawing *drawing, const km_drawing_look *look, double seconds, km_text *out,
                          km_error *error) {
  km_drawing_def def;
  km_status status = km_check_picture(out, KM_PICTURE_PNG, error);
  if (!status)
    status = km_drawing_define(drawing, look, &def, error);
  if (!status && !(seconds > 0.0 && seconds < 1e6))
    status = km_fail(error, KM_USAGE, "%g seconds; expected more than 0, less than a million", seconds);
  if (status)
    return status;
  size_t stride = (def.pose_count - 1) / PICTURES + 1, kept = (def.pose_count - 1) / stride + 1;
  size_t frames = km_drawing_comes_round(drawing) ? kept - 1 : kept > 1 ? 2 * kept - 2 : 1;
  km_apng apng = {.out = out, .frames = (unsigned)frames};
  apng.milliseconds = (unsigned)lround(1000 * seconds / (double)kept);
  def.alone = def.steady = def.bare = true; /* names would jump from picture to picture */
  if (def.width <= 0.0)
    def.width = picture_width;
  size_t before = out->size;
  for (size_t f = 0; f < frames && !status; ++f)
    status = add_picture(&def, (f < kept ? f : 2 * kept - 2 - f) * stride, &apng, error);
  if (status)
    out->size = before;
  return status;
}

static km_status make_outlines(const km_drawing *drawing, km_view view, double width, km_arena *arena, km_outlines *out,
                               km_error *error) {
  km_drawing_def def;
  km_status status = km_drawing_define(drawing, &(km_drawing_look){.view = view}, &def, error);
  if (!status && !(width >= 0.0 && isfinite(width)))
    status = km_fail(error, KM_USAGE, "links of width %g; expected at least 0", width);
  return status ? status : km_outlines_make(&def, width, arena, out, error);
}

km_status km_drawing_outlines(const km_drawing *drawing, km_view view, double width, double scale,
                              km_picture_format format, km_text *out, km_error *error) {
  km_arena arena = {0};
  km_outlines outlines;
  km_status status = km_check_picture(out, format, error);
  if (!status && !(scale > 0.0 && isfinite(scale)))
    status = km_fail(error, KM_USAGE, "scale %g; expected more than 0", scale);
  if (!status)
    status = make_outlines(drawing, view, width, &arena, &outlines, error);
  if (!status)
    status = km_outlines_render(&outlines, scale, format, out, error);
  km_arena_free(&arena);
  return status;
}

km_status km_drawing_dxf(const km_drawing *drawing, km_view view, double width, km_text *out, km_error *error) {
  km_arena arena = {0};
  km_outlines outlines;
  km_status status = km_check_given(out != NULL, "place for the result", error);
  if (!status)
    status = make_outlines(drawing, view, width, &arena, &outlines, error);
  if (!status)
    status = km_outlines_dxf(&outlines, out, error);
  km_arena_free(&arena);
  return status;
}
