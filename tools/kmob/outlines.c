/* kmob draw --scale, --format dxf: the outlines of links. */
#include "kmob/draw.h"

#include "kmech/memory.h"
#include "report/drawing/outlines.h"

static kt_exit write_format(const kmob_draw_options *o, const km_outlines *outlines, kt_format format,
                            const char *base) {
  km_text out = {0};
  km_error error;
  km_status status = format == KT_DXF
                         ? km_outlines_dxf(outlines, &out, &error)
                         : km_outlines_render(outlines, o->drawn_scale, kt_canvas_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s: %s", o->path, error.text);
  else
    result = kt_write(&o->common, base, "motion", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

kt_exit kmob_write_outlines(const kmob_draw_options *o, const km_drawing *drawing, const char *base) {
  km_arena arena = {0};
  km_outlines outlines;
  km_error error;
  km_status status = km_outlines_make(drawing, o->width, &arena, &outlines, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s: %s", o->path, error.text);
  for (int f = KT_SVG; f <= KT_DXF && !status; ++f)
    if (o->formats.wanted[f] && (f == KT_DXF || o->drawn_scale > 0.0))
      result = kt_worse(result, write_format(o, &outlines, (kt_format)f, base));
  km_arena_free(&arena);
  return result;
}
