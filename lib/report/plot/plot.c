/* Line plots: fits the axes to the data and draws panel by panel. */
#include "report/plot/plot.h"

#include "report/canvas/palette.h"
#include "report/plot/overlapping_lines.h"
#include "report/plot/plot_layout.h"

static const double size_least = 120; /* points: less can't hold axes and a title */

/* A run that the frame cuts off goes on beyond it. */
static void draw_arrow(const km_plot_layout *layout, const km_frame *frame, km_colour colour, km_canvas_point end) {
  double size = 3.2 * layout->scale, bottom = frame->top + frame->height;
  double out = end.y < frame->top ? -1 : end.y > bottom ? 1 : 0, border = out < 0 ? frame->top : bottom;
  const km_canvas_point head[] = {{end.x, border},
                                  {end.x - 0.6 * size, border - out * 1.6 * size},
                                  {end.x + 0.6 * size, border - out * 1.6 * size}};
  if (out != 0)
    km_canvas_polygon(layout->canvas, colour, head, 3);
}

/* The area from `begin` up to `end` between a line and its base. */
static void draw_area(const km_plot_layout *layout, const km_frame *frame, const km_plot_series *s, size_t begin,
                      size_t end) {
  size_t count = end - begin;
  km_canvas_point *corners = KM_ARENA_NEW(layout->arena, km_canvas_point, 2 * count);
  km_colour colour = km_palette_colour(s->colour);
  colour.alpha = 0.2;
  for (size_t i = 0; i < count && corners; i++) {
    corners[i] = km_frame_map(frame, s->x[begin + i], s->y[begin + i]);
    corners[2 * count - 1 - i] = km_frame_map(frame, s->x[begin + i], s->base[begin + i]);
  }
  if (corners && count > 1)
    km_canvas_polygon(layout->canvas, colour, corners, 2 * count);
}

static void draw_areas(const km_plot_layout *layout, const km_frame *frame, const km_plot_series *s) {
  size_t begin = 0;
  km_canvas_clip(layout->canvas, frame->left, frame->top, frame->width, frame->height);
  for (size_t i = 0; i <= s->count; i++) {
    if (i < s->count && km_axis_takes(s->x[i]) && km_axis_takes(s->y[i]) && km_axis_takes(s->base[i]))
      continue;
    draw_area(layout, frame, s, begin, i);
    begin = i + 1;
  }
  km_canvas_release(layout->canvas);
}

static void draw_curve(const km_plot_layout *layout, const km_frame *frame, const km_plot_series *series,
                       const km_curve *curves, size_t index) {
  const km_curve *curve = &curves[index];
  const km_pen pen = km_overlap_pen(series, curves, index, layout->scale * (series[index].colour < 0 ? 0.7 : 1.3));
  size_t begin = 0;
  for (size_t r = 0; r < curve->run_count; r++) {
    size_t count = curve->run_ends[r] - begin;
    draw_arrow(layout, frame, pen.colour, curve->points[begin]);
    draw_arrow(layout, frame, pen.colour, curve->points[begin + count - 1]);
    if (count == 1)
      km_canvas_circle(layout->canvas, pen.colour, NULL, curve->points[begin], pen.width);
    else
      km_canvas_polyline(layout->canvas, &pen, curve->points + begin, count);
    begin = curve->run_ends[r];
  }
}

static void draw_lines(const km_plot_layout *layout, size_t panel) {
  const km_plot_panel *source = &layout->plot->panels[panel];
  const km_frame frame = km_plot_layout_frame(layout, panel);
  km_curve *curves = KM_ARENA_NEW(layout->arena, km_curve, source->series_count + 1);
  if (!curves)
    return;
  bool any = false;
  for (size_t i = 0; i < source->series_count; i++) {
    curves[i] = km_curve_make(&frame, &source->series[i], layout->arena);
    any = any || curves[i].has_end;
  }
  for (size_t i = 0; i < source->series_count; i++)
    if (source->series[i].base)
      draw_areas(layout, &frame, &source->series[i]);
  for (int context = 1; context >= 0; context--) /* grey lines lie beneath the others */
    for (size_t i = 0; i < source->series_count; i++)
      if ((source->series[i].colour < 0) == context)
        draw_curve(layout, &frame, source->series, curves, i);
  km_plot_names_draw(layout, panel, curves);
  if (!any)
    km_canvas_text(layout->canvas, &layout->label, km_palette_text(-1), "no data",
                   (km_canvas_point){frame.left + frame.width / 2, frame.top + frame.height / 2},
                   (km_anchor){0.5, 0.5, 0});
}

static km_status draw(const km_plot *plot, km_canvas *canvas, km_arena *arena, double width, double height,
                      km_error *error) {
  km_plot_layout layout = {.plot = plot, .canvas = canvas, .arena = arena};
  km_plot_layout_make(&layout, width, height);
  if (!arena->failed && !layout.fits)
    return km_fail(error, KM_USAGE, "%zu panels on %g x %g points; expected a larger page", plot->panel_count, width,
                   height);
  for (size_t panel = 0; panel < plot->panel_count && !arena->failed; panel++) {
    km_plot_axes_draw(&layout, panel);
    km_plot_flags_draw(&layout, panel);
    draw_lines(&layout, panel);
  }
  if (!arena->failed)
    km_plot_titles_draw(&layout);
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory for a plot") : KM_OK;
}

km_status km_plot_place(const km_plot *plot, km_canvas *canvas, double width, double height, km_error *error) {
  km_arena arena = {0};
  km_status status = draw(plot, canvas, &arena, width, height, error);
  km_arena_free(&arena);
  return status;
}

km_status km_plot_render(const km_plot *plot, km_picture_format format, km_text *out, km_error *error) {
  double width, height;
  km_plot_layout_size(plot, &width, &height);
  if (!(width >= size_least && height >= size_least))
    return km_fail(error, KM_USAGE, "a plot of %g x %g points; expected at least %g each", width, height, size_least);
  km_canvas *canvas;
  km_status status = km_canvas_create(format, width, height + plot->strip.height, out, &canvas, error);
  if (status != KM_OK)
    return status;
  km_arena arena = {0};
  status = draw(plot, canvas, &arena, width, height, error);
  if (status == KM_OK && plot->strip.height > 0)
    plot->strip.draw(plot->strip.context, canvas, height, width);
  if (status == KM_OK)
    status = km_canvas_finish(canvas, error);
  km_canvas_free(canvas);
  km_arena_free(&arena);
  return status;
}
