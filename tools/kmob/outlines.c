/* kmob draw --scale, --format dxf: the outlines of links. */
#include "kmob/draw.h"

static kt_exit write_format(const kmob_draw_options *o, const km_drawing *drawing, kt_format format, const char *base) {
  km_text out = {0};
  km_error error;
  km_status status = format == KT_DXF ? km_drawing_dxf(drawing, o->look.view, o->width, &out, &error)
                                      : km_drawing_outlines(drawing, o->look.view, o->width, o->drawn_scale,
                                                            kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->path, error.text);
  else
    result = kt_write(&o->common, base, "motion", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

kt_exit kmob_write_outlines(const kmob_draw_options *o, const km_drawing *drawing, const char *base) {
  kt_exit result = KT_DONE;
  for (int f = KT_SVG; f <= KT_DXF && result == KT_DONE; ++f)
    if (o->formats.wanted[f] && (f == KT_DXF || o->drawn_scale > 0.0))
      result = write_format(o, drawing, (kt_format)f, base);
  return result;
}
