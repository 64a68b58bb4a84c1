/* Axes and colours of the maps (report/charts/map_axes.h). */
#include "report/charts/map_axes.h"

static const km_colour ink = {0.15, 0.15, 0.15, 1};

km_colour km_map_shade(int number) {
  static const km_colour stops[] = {{0.19, 0.10, 0.33, 1}, {0.23, 0.32, 0.54, 1}, {0.13, 0.51, 0.55, 1},
                                    {0.28, 0.70, 0.46, 1}, {0.69, 0.84, 0.28, 1}, {0.99, 0.93, 0.55, 1}};
  enum { LAST = sizeof stops / sizeof *stops - 1 };
  double at = (number + 0.5) / KM_MAP_SHADES * LAST;
  int i = at >= LAST ? LAST - 1 : (int)at;
  const km_colour *a = &stops[i], *b = &stops[i + 1];
  double x = at - i;
  return (km_colour){a->red + x * (b->red - a->red), a->green + x * (b->green - a->green),
                     a->blue + x * (b->blue - a->blue), 1};
}

void km_map_axes_draw(km_canvas *canvas, const km_frame *f, const km_axis *x, const km_axis *y, double font_size,
                      double gap) {
  const km_font font = {.size = font_size};
  const km_pen pen = {.colour = ink, .width = 0.7};
  double bottom = f->top + f->height;
  char text[KM_AXIS_LABEL];
  for (size_t i = 0; i < x->count; ++i) {
    double at = km_frame_map(f, km_axis_tick(x, i), f->y_low).x;
    km_canvas_line(canvas, &pen, (km_canvas_point){at, bottom}, (km_canvas_point){at, bottom + 3});
    km_axis_label(x, i, text);
    km_canvas_text(canvas, &font, ink, text, (km_canvas_point){at, bottom + gap}, (km_anchor){0.5, 0, 0});
  }
  for (size_t i = 0; i < y->count; ++i) {
    double at = km_frame_map(f, f->x_low, km_axis_tick(y, i)).y;
    km_canvas_line(canvas, &pen, (km_canvas_point){f->left, at}, (km_canvas_point){f->left - 3, at});
    km_axis_label(y, i, text);
    km_canvas_text(canvas, &font, ink, text, (km_canvas_point){f->left - 5, at}, (km_anchor){1, 0.5, 0});
  }
  const km_canvas_point box[] = {{f->left, f->top},
                                 {f->left + f->width, f->top},
                                 {f->left + f->width, bottom},
                                 {f->left, bottom},
                                 {f->left, f->top}};
  km_canvas_polyline(canvas, &pen, box, 5);
}

void km_map_colours_draw(km_canvas *canvas, double low, double high, double left, double top, double height,
                         char multiplier[KM_AXIS_LABEL]) {
  const km_font font = {.size = 8.5};
  const double width = 12;
  for (int i = 0; i < KM_MAP_SHADES; ++i)
    km_canvas_rectangle(canvas, km_map_shade(i), left, top + height * (KM_MAP_SHADES - 1 - i) / KM_MAP_SHADES, width,
                        height / KM_MAP_SHADES + 0.3);
  km_axis axis = km_axis_fit(low, high, 6, false, false);
  for (size_t i = 0; i < axis.count; ++i) {
    char text[KM_AXIS_LABEL];
    double y = top + height * (1.0 - (km_axis_tick(&axis, i) - low) / (high - low));
    km_axis_label(&axis, i, text);
    km_canvas_text(canvas, &font, ink, text, (km_canvas_point){left + width + 4, y}, (km_anchor){0, 0.5, 0});
  }
  km_axis_multiplier(&axis, multiplier);
}
