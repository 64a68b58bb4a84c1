/* The arm along its path as a film beside the curves of its joints, and as a strip of configurations. */
#include "report/document/track_film.h"

#include "report/drawing/film_drawing.h"
#include "report/plot/film_plot.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>

enum { MOST_FRAMES = 100, STRIP = 6 };
static const double plot_width = 300, panel_height = 130; /* points: letters fit a phone */
static const double drawing_width = 430, drawing_height = 330;
static const double least_seconds = 3.0, most_seconds = 20.0;

/* Keeps the points of a series at the rows of the frames. */
static void thin(km_plot_series *series, const km_track *t, size_t frames, km_arena *arena) {
  double *values = KM_ARENA_NEW(arena, double, 2 * frames);
  for (size_t f = 0; f < frames && values; ++f) {
    values[f] = series->x[km_track_row(t, f, frames)];
    values[frames + f] = series->y[km_track_row(t, f, frames)];
  }
  series->x = values;
  series->y = values ? values + frames : NULL;
  series->count = frames;
}

/* A plot of the best track alone: its joints between their limits (angles, where there are none), and the fastest
 * joint's rate. */
static bool make_plot(const km_tracks *tracks, int best, size_t frames, km_arena *arena, km_plot *out) {
  km_track **items = KM_ARENA_NEW(arena, km_track *, (size_t)tracks->count);
  km_plot *plots = KM_ARENA_NEW(arena, km_plot, KM_TRACK_PLOTS);
  km_plot_panel *panels = KM_ARENA_NEW(arena, km_plot_panel, 2);
  if (arena->failed)
    return false;
  items[best] = tracks->items[best];
  const km_tracks one = {tracks->study, tracks->name, tracks->model, items, tracks->count};
  const size_t count = km_tracks_plots_make(&one, false, arena, plots);
  if (count < 2)
    return false;
  bool limited = false;
  for (int k = 0; k < items[best]->arm->n; ++k)
    limited = limited || items[best]->arm->high[k] - items[best]->arm->low[k] < HUGE_VAL;
  const km_plot *shown[2] = {&plots[limited ? 1 : 0], &plots[count - 1]};
  for (int i = 0; i < 2; ++i) {
    panels[i] = shown[i]->panels[0];
    panels[i].title = shown[i]->title;
    panels[i].y_label = shown[i]->y_label;
    panels[i].y_low = shown[i]->y_low;
    panels[i].y_high = shown[i]->y_high;
    km_plot_series *series = KM_ARENA_NEW(arena, km_plot_series, panels[i].series_count);
    for (size_t k = 0; k < panels[i].series_count && series; ++k) {
      series[k] = panels[i].series[k];
      thin(&series[k], items[best], frames, arena);
    }
    panels[i].series = series;
  }
  *out = (km_plot){.x_label = shown[0]->x_label, .panels = panels, .panel_count = 2, .own_y = true};
  return !arena->failed;
}

/* Stops by frame, from those by row. */
static const km_motion_stop *place_stops(const km_track *t, const km_motion_stop *stops, size_t count, size_t frames,
                                         km_arena *arena) {
  km_motion_stop *out = KM_ARENA_NEW(arena, km_motion_stop, count + 1);
  const double rows = (double)km_table_rows(t->table);
  for (size_t i = 0; i < count && out; ++i)
    out[i] = (km_motion_stop){rows > 1.0 ? stops[i].pose * (double)(frames - 1) / (rows - 1.0) : 0.0, stops[i].name};
  return out;
}

km_status km_track_film_make(const km_tracks *tracks, const km_motion_stop *stops, size_t stop_count, km_arena *arena,
                             km_track_film *out, km_error *error) {
  const int best = km_tracks_best(tracks);
  const km_track *t = tracks->items[best];
  const int s = km_table_find(t->table, "s");
  km_plot plot;
  *out = (km_track_film){.films = {&out->arm, &out->curves},
                         .alt = {"the arm along its path", "its joints between their limits, and the fastest one"}};
  km_status status = km_tracks_drawing_make(tracks, MOST_FRAMES, arena, &out->drawing, error);
  if (status)
    return status;
  out->drawing.width = drawing_width;
  out->drawing.height = drawing_height;
  const size_t frames = out->drawing.pose_count;
  double *values = KM_ARENA_NEW(arena, double, frames);
  for (size_t f = 0; f < frames && values; ++f)
    values[f] = km_table_row(t->table, km_track_row(t, f, frames))[s];
  if (!values || !make_plot(tracks, best, frames, arena, &plot))
    return km_fail(error, KM_MEMORY, "out of memory for the film of a track");
  status = km_drawing_film(&out->drawing, arena, &out->arm, error);
  if (!status)
    status = km_plot_film(&plot, plot_width, 2 * panel_height, frames, arena, &out->curves, error);
  const double time = km_path_time(t->plan.path, t->plan.path->samples - 1);
  out->page = (km_film_page){.films = out->films,
                             .alt = out->alt,
                             .film_count = 2,
                             .quantity = "s",
                             .unit = t->arm->mechanism->model->units.length->suffix,
                             .values = values,
                             .stops = place_stops(t, stops, stop_count, frames, arena),
                             .stop_count = stop_count,
                             .seconds = fmin(fmax(time, least_seconds), most_seconds)};
  return status || !arena->failed ? status : km_fail(error, KM_MEMORY, "out of memory for the film of a track");
}

void km_track_film_close(km_track_film *film) {
  km_film_close(&film->arm);
  km_film_close(&film->curves);
}

km_status km_track_film_strip(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  static const double caption = 14;
  const km_track_film *film = context;
  const km_font font = {.size = 7};
  const km_colour grey = {0.42, 0.42, 0.42, 1};
  const size_t frames = film->drawing.pose_count, count = frames < STRIP ? frames : STRIP;
  const double cell = width / (double)count;
  km_status status = KM_OK;
  for (size_t i = 0; i < count && !status; ++i) {
    km_drawing_def drawing = film->drawing;
    char text[80];
    drawing.full = count > 1 ? i * (frames - 1) / (count - 1) : 0;
    drawing.alone = drawing.steady = drawing.bare = true;
    snprintf(text, sizeof text, "s = %.4g %s", film->page.values[drawing.full], film->page.unit);
    status = km_drawing_place(&drawing, canvas, (km_rectangle){cell * (double)i, 0, cell, height - caption}, error);
    km_canvas_text(canvas, &font, grey, text, (km_canvas_point){cell * ((double)i + 0.5), height - caption},
                   (km_anchor){0.5, 0, 0});
  }
  return status;
}
