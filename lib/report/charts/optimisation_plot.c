/* Pictures of optimisations: the way to the best design, and fronts of two goals. */
#include "report/charts/designs_plot.h"

#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_FRONT = 512 };

static int figure_of(const km_designs_shown *p, int goal) {
  int figure = 0;
  while (strcmp(km_design_study_figure(p->study, figure)->name, p->def->optimise->goals[goal].figure) != 0)
    ++figure;
  return figure;
}

static const char *label_of(const km_designs_shown *p, int goal, km_arena *arena) {
  char text[256];
  int figure = figure_of(p, goal);
  const char *unit = km_design_study_figure_unit(p->study, figure);
  snprintf(text, sizeof text, *unit ? "%.200s (%.30s)" : "%.200s", km_design_study_figure(p->study, figure)->name,
           unit);
  return km_arena_string(arena, text);
}

static km_status nothing(km_arena *arena, km_error *error) {
  km_arena_free(arena);
  return km_fail(error, KM_NO_RESULT, "there is nothing to draw");
}

/* Dots of all designs that are good enough, each followed by a gap; and the best so far. */
km_status km_designs_progress(const km_designs_shown *p, km_text *out, km_error *error) {
  km_arena arena = {0};
  int count = km_design_study_designs(p->study), figure = figure_of(p, 0), good = 0;
  bool largest = p->def->optimise->goals[0].largest;
  size_t room = 2 * (size_t)count + 2;
  double *x = KM_ARENA_NEW(&arena, double, room), *y = KM_ARENA_NEW(&arena, double, room);
  double *best_x = KM_ARENA_NEW(&arena, double, room), *best = KM_ARENA_NEW(&arena, double, room);
  double now = nan("");
  for (int i = 0; i < count && best; ++i) {
    km_design_result r;
    bool accepted = !km_design_study_result(p->study, i, &r, NULL) && km_design_study_accepts(p->study, &r);
    x[2 * i] = best_x[2 * i] = best_x[2 * i + 1] = i + 1;
    y[2 * i] = accepted ? r.figures[figure] : nan("");
    x[2 * i + 1] = y[2 * i + 1] = nan("");
    best[2 * i] = now; /* a stair */
    if (accepted && (isnan(now) || (largest ? y[2 * i] > now : y[2 * i] < now)))
      now = y[2 * i];
    best[2 * i + 1] = now;
    good += accepted;
  }
  if (!good && !arena.failed)
    return nothing(&arena, error);
  const km_plot_series series[] = {{.x = x, .y = y, .count = 2 * (size_t)count, .colour = 1},
                                   {.name = "best so far", .x = best_x, .y = best, .count = 2 * (size_t)count}};
  km_plot_panel panel = {.series = series, .series_count = 2};
  char title[256], subtitle[512];
  snprintf(title, sizeof title, "The way to the %s %.200s", largest ? "greatest" : "least",
           p->def->optimise->goals[0].figure);
  snprintf(subtitle, sizeof subtitle, "%.300s · %s, %d designs; the dots are the %d that are good enough", p->name,
           p->def->optimise->algorithm, count, good);
  km_plot plot = {.title = title,
                  .subtitle = subtitle,
                  .x_label = "designs asked",
                  .y_label = label_of(p, 0, &arena),
                  .panels = &panel,
                  .panel_count = 1};
  return km_designs_finish(p, !arena.failed, &plot, &arena, out, error);
}

/* Designs near the front; those much worse in both goals would compress it. */
static void place_dots(const km_designs_shown *p, const double *front_x, const double *front_y, int count, double *x,
                       double *y) {
  int f = figure_of(p, 0), g = figure_of(p, 1);
  double wide = fabs(front_x[count - 1] - front_x[0]), high = fabs(front_y[count - 1] - front_y[0]);
  for (int i = 0; i < km_design_study_designs(p->study); ++i) {
    km_design_result r;
    bool near = !km_design_study_result(p->study, i, &r, NULL) && km_design_study_accepts(p->study, &r) &&
                fabs(r.figures[f] - front_x[0]) <= 1.5 * wide && fabs(r.figures[g] - front_y[count - 1]) <= 1.5 * high;
    x[2 * i] = near ? r.figures[f] : nan("");
    y[2 * i] = near ? r.figures[g] : nan("");
    x[2 * i + 1] = y[2 * i + 1] = nan("");
  }
}

km_status km_designs_front(const km_designs_shown *p, km_text *out, km_error *error) {
  km_arena arena = {0};
  int front[MOST_FRONT], designs = km_design_study_designs(p->study);
  int count = km_design_study_front(p->study, front, MOST_FRONT), f = figure_of(p, 0), g = figure_of(p, 1);
  count = count < MOST_FRONT ? count : MOST_FRONT;
  size_t room = 2 * (size_t)designs + 1;
  double *x = KM_ARENA_NEW(&arena, double, room), *y = KM_ARENA_NEW(&arena, double, room);
  double *front_x = KM_ARENA_NEW(&arena, double, MOST_FRONT), *front_y = KM_ARENA_NEW(&arena, double, MOST_FRONT);
  km_design_result r;
  for (int i = 0; i < count && !arena.failed; ++i) {
    km_design_study_result(p->study, front[i], &r, NULL);
    front_x[i] = r.figures[f];
    front_y[i] = r.figures[g];
  }
  if (!count && !arena.failed)
    return nothing(&arena, error);
  if (!arena.failed)
    place_dots(p, front_x, front_y, count, x, y);
  const km_plot_series series[] = {{.x = x, .y = y, .count = 2 * (size_t)designs, .colour = 1},
                                   {.name = "front", .x = front_x, .y = front_y, .count = (size_t)count, .colour = 0}};
  km_plot_panel panel = {.series = series, .series_count = 2};
  char subtitle[512];
  snprintf(subtitle, sizeof subtitle, "%.300s · the front: %d of %d designs that no other betters in both", p->name,
           count, designs);
  km_plot plot = {.title = "Two goals",
                  .subtitle = subtitle,
                  .x_label = label_of(p, 0, &arena),
                  .y_label = label_of(p, 1, &arena),
                  .panels = &panel,
                  .panel_count = 1};
  return km_designs_finish(p, !arena.failed, &plot, &arena, out, error);
}
