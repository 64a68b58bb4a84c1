/* Draws a panel's frame, grid, ticks and labels. */
#include "report/plot/plot_layout.h"

#include <math.h>

static const km_colour ink = {0.15, 0.15, 0.15, 1}, grey = {0.40, 0.40, 0.40, 1};
static const km_colour light = {0.88, 0.88, 0.88, 1};
static const double tick_length = 2.5;

static void line(const km_plot_layout *layout, km_colour colour, double width, double x1, double y1, double x2,
                 double y2) {
  const km_pen pen = {.colour = colour, .width = width};
  km_canvas_line(layout->canvas, &pen, (km_canvas_point){x1, y1}, (km_canvas_point){x2, y2});
}

/* True if no panel is below, so that this one labels its own x ticks. */
static bool is_lowest(const km_plot_layout *layout, size_t panel) {
  return panel + layout->columns >= layout->plot->panel_count;
}

static void draw_x(const km_plot_layout *layout, const km_frame *frame, bool labelled) {
  char text[KM_AXIS_LABEL];
  double bottom = frame->top + frame->height;
  for (size_t i = 0; i < layout->x.count; i++) {
    double x = km_frame_map(frame, km_axis_tick(&layout->x, i), frame->y_low).x;
    line(layout, light, 0.5, x, frame->top, x, bottom);
    line(layout, ink, 0.6, x, bottom, x, bottom + tick_length);
    km_axis_label(&layout->x, i, text);
    if (labelled)
      km_canvas_text(layout->canvas, &layout->tick, ink, text, (km_canvas_point){x, bottom + layout->mark_room + 3},
                     (km_anchor){0.5, 0, 0});
  }
}

static void draw_y(const km_plot_layout *layout, const km_frame *frame, const km_axis *axis, bool labelled) {
  char text[KM_AXIS_LABEL];
  for (size_t i = 0; i < axis->count; i++) {
    double y = km_frame_map(frame, frame->x_low, km_axis_tick(axis, i)).y;
    line(layout, light, 0.5, frame->left, y, frame->left + frame->width, y);
    line(layout, ink, 0.6, frame->left, y, frame->left - tick_length, y);
    km_axis_label(axis, i, text);
    if (labelled)
      km_canvas_text(layout->canvas, &layout->tick, ink, text, (km_canvas_point){frame->left - 5, y},
                     (km_anchor){1, 0.5, 0});
  }
  km_axis_multiplier(axis, text);
  if (labelled && *text)
    km_canvas_text(layout->canvas, &layout->tick, ink, text,
                   (km_canvas_point){frame->left - 5, frame->top - 0.6 * layout->tick.size}, (km_anchor){1, 1, 0});
}

/* A long label is scaled down before its end, the unit, is cut. */
static km_font fit_label(const km_plot_layout *layout, const char *text, double room) {
  const double shrink_most = 0.7;
  km_font font = layout->label;
  double width = km_canvas_measure(layout->canvas, &font, text).x;
  font.size *= fmax(shrink_most, fmin(1, room / width));
  font.width = fmax(room, 1) + 0.5; /* rounding must not cost a letter */
  return font;
}

static void draw_y_label(const km_plot_layout *layout, const char *label, double top, double bottom) {
  if (!label)
    return;
  km_font font = fit_label(layout, label, bottom - top);
  km_canvas_text(layout->canvas, &font, ink, label, (km_canvas_point){layout->margin, 0.5 * (top + bottom)},
                 (km_anchor){0.5, 0, -acos(0)});
}

void km_plot_axes_draw(const km_plot_layout *layout, size_t panel) {
  const km_frame frame = km_plot_layout_frame(layout, panel);
  draw_x(layout, &frame, is_lowest(layout, panel));
  draw_y(layout, &frame, &layout->y[panel], panel % layout->columns == 0);
  if (layout->plot->own_y)
    draw_y_label(layout, layout->plot->panels[panel].y_label, frame.top, frame.top + frame.height);
  double bottom = frame.top + frame.height;
  line(layout, ink, 0.7, frame.left, bottom, frame.left + frame.width, bottom);
  line(layout, ink, 0.7, frame.left, bottom, frame.left, frame.top);
  const char *title = layout->plot->panels[panel].title;
  if (title)
    km_canvas_text(layout->canvas, &layout->heading, ink, title,
                   (km_canvas_point){frame.left, frame.top - layout->head}, (km_anchor){0, 0, 0});
}

static void draw_axis_labels(const km_plot_layout *layout) {
  const km_frame first = km_plot_layout_frame(layout, 0);
  const km_frame last = km_plot_layout_frame(layout, layout->rows * layout->columns - 1);
  double right = last.left + last.width, bottom = last.top + last.height;
  char multiplier[KM_AXIS_LABEL];
  km_axis_multiplier(&layout->x, multiplier);
  double aside = km_canvas_measure(layout->canvas, &layout->tick, multiplier).x;
  double room = right - first.left - (aside > 0 ? 2 * aside + 8 : 0);
  const km_canvas_point below = {0.5 * (first.left + right), bottom + layout->foot};
  const char *label = layout->plot->x_label;
  if (label) {
    km_font font = fit_label(layout, label, room);
    km_canvas_text(layout->canvas, &font, ink, label, below, (km_anchor){0.5, 0, 0});
  }
  if (*multiplier)
    km_canvas_text(layout->canvas, &layout->tick, ink, multiplier, (km_canvas_point){right, below.y},
                   (km_anchor){1, 0, 0});
  draw_y_label(layout, layout->plot->y_label, layout->grid_top, bottom);
}

void km_plot_titles_draw(const km_plot_layout *layout) {
  const km_plot *plot = layout->plot;
  km_canvas_point at = {layout->margin, layout->margin};
  if (plot->title && *plot->title) {
    km_canvas_text(layout->canvas, &layout->title, ink, plot->title, at, (km_anchor){0, 0, 0});
    at.y += km_canvas_measure(layout->canvas, &layout->title, plot->title).y;
  }
  if (plot->subtitle && *plot->subtitle)
    km_canvas_text(layout->canvas, &layout->subtitle, grey, plot->subtitle, at, (km_anchor){0, 0, 0});
  draw_axis_labels(layout);
}
