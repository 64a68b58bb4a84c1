/* Turns a plot into a film whose marks move. */
#include "report/plot/film_plot.h"

#include "report/canvas/palette.h"
#include "report/plot/plot_layout.h"

#include <math.h>

static const double outside = -99; /* points: nothing is seen there */

static void add_dot(km_film *film, const km_frame *frame, const km_plot_series *series, double radius) {
  km_film_mover *mover = km_film_add_mover(film, false);
  for (size_t f = 0; mover && f < film->frame_count; ++f) {
    km_canvas_point at = km_frame_map(frame, series->x[f], series->y[f]);
    bool shown = at.y >= frame->top - 1 && at.y <= frame->top + frame->height + 1; /* no number isn't */
    mover->x[f] = shown ? at.x : outside;
    mover->y[f] = shown ? at.y : outside;
  }
  if (!mover || !km_film_begin(film, (int)film->mover_count - 1))
    return;
  const km_pen rim = {.colour = {1, 1, 1, 1}, .width = 0.35 * radius};
  km_canvas_circle(film->canvas, km_palette_colour(series->colour), &rim, (km_canvas_point){0, 0}, radius);
}

/* A line from the top of a panel to its bottom, at the x of a frame's row. */
static void add_line(km_film *film, const km_frame *frame, const double *x) {
  km_film_mover *mover = km_film_add_mover(film, false);
  for (size_t f = 0; mover && f < film->frame_count; ++f) {
    mover->x[f] = km_frame_map(frame, x[f], frame->y_low).x;
    mover->y[f] = frame->top;
  }
  if (!mover || !km_film_begin(film, (int)film->mover_count - 1))
    return;
  const km_pen pen = {.colour = {0.70, 0.28, 0.0, 1}, .width = 1.4}; /* the colour of the page's slider */
  km_canvas_line(film->canvas, &pen, (km_canvas_point){0, 0}, (km_canvas_point){0, frame->height});
}

static void add_marks(km_film *film, const km_plot_layout *layout) {
  for (size_t p = 0; p < layout->plot->panel_count; ++p) {
    const km_plot_panel *panel = &layout->plot->panels[p];
    const km_frame frame = km_plot_layout_frame(layout, p);
    if (panel->series_count)
      add_line(film, &frame, panel->series[0].x);
    for (size_t s = 0; s < panel->series_count; ++s)
      if (panel->series[s].colour >= 0)
        add_dot(film, &frame, &panel->series[s], 2.6 * layout->scale);
  }
}

km_status km_plot_film(const km_plot *plot, double width, double height, size_t frame_count, km_arena *arena,
                       km_film *film, km_error *error) {
  km_status status = km_film_open(film, arena, width, height, frame_count, error);
  if (status)
    return status;
  km_film_begin(film, KM_FILM_STANDS);
  status = km_plot_place(plot, film->canvas, width, height, error);
  if (!status) {
    km_plot_layout layout = {.plot = plot, .canvas = film->canvas, .arena = arena};
    km_plot_layout_make(&layout, width, height);
    if (!arena->failed)
      add_marks(film, &layout);
  }
  return status ? status : km_film_end(film, error);
}
