/* Another axis across a plot (plot_over.h). */
#include "report/plot/plot_over.h"

#include <math.h>

static double map(const km_plot_over *over, double x) {
  const size_t last = over->count - 1;
  const bool falls = over->from[last] < over->from[0];
  size_t low = 0, high = last;
  while (high > low + 1) {
    const size_t middle = (low + high) / 2;
    if (falls ? over->from[middle] >= x : over->from[middle] <= x)
      low = middle;
    else
      high = middle;
  }
  const double width = over->from[high] - over->from[low];
  const double part = width != 0.0 ? (x - over->from[low]) / width : 0.0;
  return part == 0.0   ? over->to[low]
         : part == 1.0 ? over->to[high]
                       : over->to[low] + part * (over->to[high] - over->to[low]);
}

static bool map_series(const km_plot_over *over, km_plot_series *series, km_arena *arena) {
  double *x = KM_ARENA_NEW(arena, double, series->count + 1);
  for (size_t i = 0; i < series->count && x; ++i)
    x[i] = isfinite(series->x[i]) ? map(over, series->x[i]) : series->x[i];
  series->x = x;
  return x != NULL;
}

static bool map_panel(const km_plot_over *over, km_plot_panel *panel, km_arena *arena) {
  km_plot_series *series = KM_ARENA_NEW(arena, km_plot_series, panel->series_count + 1);
  km_plot_mark *marks = KM_ARENA_NEW(arena, km_plot_mark, panel->mark_count + 1);
  bool is_done = series && marks;
  for (size_t i = 0; i < panel->series_count && is_done; ++i) {
    series[i] = panel->series[i];
    is_done = map_series(over, &series[i], arena);
  }
  for (size_t i = 0; i < panel->mark_count && is_done; ++i) {
    marks[i] = panel->marks[i];
    marks[i].x = map(over, marks[i].x);
  }
  panel->series = series;
  panel->marks = marks;
  return is_done;
}

bool km_plot_set_over(km_plot *plot, const km_plot_over *over, km_arena *arena) {
  km_plot_panel *panels = KM_ARENA_NEW(arena, km_plot_panel, plot->panel_count + 1);
  bool is_done = panels != NULL;
  for (size_t p = 0; p < plot->panel_count && is_done; ++p) {
    panels[p] = plot->panels[p];
    is_done = map_panel(over, &panels[p], arena);
  }
  plot->panels = panels;
  plot->x_label = over->label;
  return is_done;
}
