#include "report/sweep_plot.h"

#include "report/sweep_strip.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST_COLOURED = 8 };

static bool broken(const km_sweep_picture *p, int sweep, double from, double to) {
  for (size_t i = 0; i < p->break_count; ++i)
    if (p->breaks[i].sweep == sweep && (p->breaks[i].s - from) * (to - p->breaks[i].s) >= 0.0)
      return true;
  return false;
}

/* A line's points from left to right, so that its name stands at its right end; a point that is none breaks it. */
static void fill_series(const km_sweep_picture *p, const km_swept_line *line, km_arena *arena, km_plot_series *out) {
  const km_table *table = p->sweeps[line->sweep].motion->table;
  size_t rows = km_table_rows(table);
  double *x = KM_ARENA_NEW(arena, double, 2 * rows), *y = KM_ARENA_NEW(arena, double, 2 * rows);
  *out = (km_plot_series){.name = line->name, .x = x, .y = y, .dash = p->sweep_count > 1 ? line->sweep : 0};
  bool backwards = rows > 1 && km_table_row(table, rows - 1)[1] < km_table_row(table, 0)[1];
  const double *last = NULL;
  for (size_t r = 0; r < rows && !arena->failed; ++r) {
    const double *row = km_table_row(table, backwards ? rows - 1 - r : r);
    if (last && broken(p, line->sweep, last[1], row[1])) {
      x[out->count] = row[1];
      y[out->count++] = nan("");
    }
    x[out->count] = row[1];
    y[out->count++] = row[line->column];
    last = row;
  }
}

static double largest_of(const double *y, size_t count) {
  double largest = 0.0;
  for (size_t i = 0; i < count; ++i)
    if (isfinite(y[i]))
      largest = fmax(largest, fabs(y[i]));
  return largest;
}

/* How many lines of the panel are larger. */
static int importance(const km_plot_series *series, size_t count, size_t index) {
  double own = largest_of(series[index].y, series[index].count);
  int larger = 0;
  for (size_t i = 0; i < count; ++i) {
    double other = largest_of(series[i].y, series[i].count);
    larger += other > own || (other == own && i < index);
  }
  return larger;
}

static void fill_panel(const km_sweep_picture *p, int panel, km_arena *arena, km_plot_panel *out) {
  km_plot_series *series = KM_ARENA_NEW(arena, km_plot_series, p->line_count);
  km_plot_mark *marks = KM_ARENA_NEW(arena, km_plot_mark, p->mark_count);
  out->title = p->panels ? p->panels[panel] : NULL;
  out->series = series;
  out->marks = marks;
  for (size_t i = 0; i < p->line_count && !arena->failed; ++i) {
    const km_swept_line *line = &p->lines[i];
    if (line->panel != panel)
      continue;
    fill_series(p, line, arena, &series[out->series_count++]);
  }
  int next = 0;
  for (size_t i = 0; i < out->series_count && !arena->failed; ++i) {
    bool coloured = importance(series, out->series_count, i) < MOST_COLOURED;
    series[i].colour = coloured ? next++ : -1;
    if (p->sweep_count == 1 && coloured && series[i].colour > 0)
      series[i].dash = series[i].colour;
  }
  for (size_t i = 0; i < p->mark_count && !arena->failed; ++i)
    if (p->marks[i].panel == panel)
      marks[out->mark_count++] = (km_plot_mark){p->marks[i].s, p->marks[i].name};
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* What of a line must be seen: all of it, or where values shoot up three times the size that nine tenths of them keep
 * to. */
static double seen_size(const km_plot_series *line, double *sizes) {
  size_t used = 0;
  for (size_t k = 0; k < line->count; ++k)
    if (isfinite(line->y[k]))
      sizes[used++] = fabs(line->y[k]);
  if (used == 0)
    return 0.0;
  qsort(sizes, used, sizeof *sizes, ascending);
  double usual = sizes[(used - 1) * 9 / 10], largest = sizes[used - 1];
  return largest > 6.0 * usual && usual > 0.0 ? 3.0 * usual : largest;
}

/* The axis ends where every line is seen. */
static void limit_axis(km_plot *plot, km_arena *arena) {
  double limit = 0.0, low = HUGE_VAL, high = -HUGE_VAL;
  for (size_t p = 0; p < plot->panel_count; ++p)
    for (size_t i = 0; i < plot->panels[p].series_count; ++i) {
      const km_plot_series *line = &plot->panels[p].series[i];
      double *sizes = KM_ARENA_NEW(arena, double, line->count);
      if (!sizes)
        return;
      limit = fmax(limit, seen_size(line, sizes));
      for (size_t k = 0; k < line->count; ++k) {
        low = isfinite(line->y[k]) ? fmin(low, line->y[k]) : low;
        high = isfinite(line->y[k]) ? fmax(high, line->y[k]) : high;
      }
    }
  if (fmax(high, -low) <= limit)
    return;
  plot->y_low = low >= 0.0 ? 0.0 : fmax(low, -limit);
  plot->y_high = high <= 0.0 ? 0.0 : fmin(high, limit);
}

static const char *subtitle(const km_sweep_picture *p, km_arena *arena) {
  const km_model *model = p->sweeps[0].mechanism->model;
  km_text text = {0};
  for (int i = 0; i < p->sweep_count; ++i)
    km_text_format(&text, "%s%s", i ? ", " : "", p->sweeps[i].name);
  km_text_format(&text, " · %s, %s, %s · characteristic length %g %s", model->units.angle->word,
                 model->units.length->word, model->units.force->word, p->sweeps[0].mechanism->length,
                 model->units.length->suffix);
  if (p->note)
    km_text_format(&text, " · %s", p->note);
  const char *result = text.failed ? NULL : km_arena_string(arena, text.data);
  arena->failed = arena->failed || text.failed;
  km_text_free(&text);
  return result;
}

static const char *x_label(const km_swept *sweep, km_arena *arena) {
  char text[400];
  const km_model *model = sweep->mechanism->model;
  if (sweep->plan->arclength > 0.0)
    snprintf(text, sizeof text, "arc length (radians, lengths over the characteristic length)");
  else
    snprintf(text, sizeof text, "driver %.300s (%s)", km_model_coordinate_label(model, sweep->plan->coordinate),
             km_model_coordinate_unit(model, sweep->plan->coordinate));
  return km_arena_string(arena, text);
}

bool km_sweep_plot_make(const km_sweep_picture *p, km_arena *arena, km_plot *out) {
  km_plot_panel *panels = KM_ARENA_NEW(arena, km_plot_panel, (size_t)p->panel_count);
  *out = (km_plot){.title = p->title,
                   .subtitle = subtitle(p, arena),
                   .x_label = x_label(&p->sweeps[0], arena),
                   .y_label = p->y_label,
                   .panels = panels,
                   .panel_count = (size_t)p->panel_count};
  for (int i = 0; i < p->panel_count && !arena->failed; ++i)
    fill_panel(p, i, arena, &panels[i]);
  if (!arena->failed)
    limit_axis(out, arena);
  km_sweep_strip *strip = KM_ARENA_NEW(arena, km_sweep_strip, 1);
  if (p->strip && !arena->failed)
    out->strip = km_sweep_strip_make(p->sweeps[0].mechanism, p->sweeps[0].plan, p->sweeps[0].motion, 3, arena, strip);
  return !arena->failed;
}

km_status km_sweep_plot(const km_sweep_picture *picture, km_canvas_format format, km_text *out, km_error *error) {
  km_arena arena = {0};
  km_plot plot;
  km_status status = km_sweep_plot_make(picture, &arena, &plot)
                         ? km_plot_render(&plot, format, out, error)
                         : km_fail(error, KM_MEMORY, "out of memory for the plot");
  km_arena_free(&arena);
  return status;
}
