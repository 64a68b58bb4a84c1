/* Pictures of samples: histograms, scatter, convergence, quantiles along a motion. */
#include "report/charts/designs_plot.h"
#include "question/question.h"

#include "base/memory.h"
#include "base/statistics/running_moments.h"
#include "base/statistics/student_t.h"
#include "report/plot/axis_ticks.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BINS = 60, MOST_DOTS = 400, MOST_POINTS = 400, MOST_PANELS = 9 };

/* There is nothing to draw, or no memory to draw it with. */
static km_status nothing(km_arena *arena, km_error *error) {
  bool failed = arena->failed;
  km_arena_free(arena);
  return failed ? km_fail(error, KM_MEMORY, "out of memory for a plot")
                : km_fail(error, KM_NO_RESULT, "there is nothing to draw");
}

km_status km_designs_finish(const km_designs_shown *p, bool made, const km_plot *plot, km_arena *arena, km_text *out,
                            km_error *error) {
  km_status status = !made         ? km_fail(error, KM_MEMORY, "out of memory for a plot")
                     : p->only_try ? KM_OK
                     : p->canvas   ? km_plot_place(plot, p->canvas, p->width, p->height, error)
                                   : km_plot_render(plot, p->format, out, error);
  km_arena_free(arena);
  return status;
}

static const char *words(km_arena *arena, const char *format, ...) __attribute__((format(printf, 2, 3)));

static const char *words(km_arena *arena, const char *format, ...) {
  char text[512];
  va_list list;
  va_start(list, format);
  vsnprintf(text, sizeof text, format, list);
  va_end(list);
  return km_arena_string(arena, text);
}

/* "stroke (mm)" */
static const char *label_of(const km_designs_shown *p, int figure, km_arena *arena) {
  const char *unit = km_design_study_figure_unit(p->study, figure);
  return words(arena, *unit ? "%s (%s)" : "%s", km_design_study_figure(p->study, figure)->name, unit);
}

/* All values that an axis takes; count 0: none. */
static double *values_of(const km_designs_shown *p, int figure, km_arena *arena, int *count) {
  int room = km_design_study_column(p->study, figure, NULL, 0);
  double *values = KM_ARENA_NEW(arena, double, (size_t)room + 1);
  *count = 0;
  if (values)
    km_design_study_column(p->study, figure, values, room);
  for (int i = 0; values && i < room; ++i)
    if (km_axis_takes(values[i]))
      values[(*count)++] = values[i];
  return values;
}

typedef struct bars {
  double *x, *y, *base;
  size_t count;
} bars;

/* The outline of the bars: four corners each. */
static bars make_bars(const double *values, int count, double low, double high, km_arena *arena) {
  int bins = (int)fmin(MOST_BINS, fmax(5.0, 2.0 * cbrt(count))), counts[MOST_BINS] = {0};
  bars b = {KM_ARENA_NEW(arena, double, 4 * MOST_BINS), KM_ARENA_NEW(arena, double, 4 * MOST_BINS),
            KM_ARENA_NEW(arena, double, 4 * MOST_BINS), 4 * (size_t)bins};
  for (int i = 0; i < count; ++i) {
    int bin = (int)(bins * (values[i] - low) / (high - low));
    counts[bin < bins ? bin : bins - 1]++;
  }
  for (int k = 0; k < bins && b.base; ++k)
    for (int corner = 0; corner < 4; ++corner) {
      b.x[4 * k + corner] = low + (high - low) * (k + (corner >= 2)) / bins;
      b.y[4 * k + corner] = corner == 1 || corner == 2 ? 100.0 * counts[k] / count : 0.0;
    }
  return b;
}

static size_t add_marks(const km_designs_shown *p, int figure, const km_design_statistics *st, double low, double high,
                        km_plot_mark *marks) {
  static const int shown[] = {1, 3, 5};
  static const char *const names[] = {"5 %", "50 %", "95 %"};
  const km_design_figure *f = km_design_study_figure(p->study, figure);
  size_t count = 0;
  for (int k = 0; k < 3; ++k)
    marks[count++] = (km_plot_mark){st->quantiles[shown[k]], names[k], 0};
  if (f->low >= low && f->low <= high)
    marks[count++] = (km_plot_mark){f->low, "low limit", 2};
  if (f->high >= low && f->high <= high)
    marks[count++] = (km_plot_mark){f->high, "high limit", 2};
  return count;
}

km_status km_designs_histogram(const km_designs_shown *p, int figure, km_text *out, km_error *error) {
  km_arena arena = {0};
  km_design_statistics st;
  int count;
  km_status status = km_design_study_statistics(p->study, figure, &st, error);
  double *values = status ? NULL : values_of(p, figure, &arena, &count);
  if (status)
    return status;
  double low = km_axis_limited(st.least), high = km_axis_limited(st.greatest);
  if (!values || count < 2 || !(high > low))
    return nothing(&arena, error);
  bars b = make_bars(values, count, low, high, &arena);
  km_plot_mark marks[5];
  km_plot_series series = {.x = b.x, .y = b.y, .base = b.base, .count = b.count};
  km_plot_panel panel = {.series = &series, .series_count = 1, .marks = marks};
  panel.mark_count = add_marks(p, figure, &st, low, high, marks);
  km_plot plot = {.title = words(&arena, "%s of %d designs", km_design_study_figure(p->study, figure)->name, st.count),
                  .subtitle = words(&arena, "%s · mean %.6g ± %.2g, standard deviation %.3g", p->name, st.mean,
                                    st.mean_half_width, st.deviation),
                  .x_label = label_of(p, figure, &arena),
                  .y_label = "share of the designs (%)",
                  .panels = &panel,
                  .panel_count = 1};
  return km_designs_finish(p, !arena.failed, &plot, &arena, out, error);
}

typedef struct placed {
  double value;
  int index;
} placed;

static int by_value(const void *a, const void *b) {
  const placed *p = a, *q = b;
  return p->value != q->value ? (p->value > q->value) - (p->value < q->value) : p->index - q->index;
}

/* A dot is a run of one point followed by a gap. Many designs are represented by a sample. */
static bool make_dots(const km_designs_shown *p, int figure, int parameter, km_arena *arena, km_plot_series *out) {
  int designs = km_design_study_designs(p->study), count = designs < MOST_DOTS ? designs : MOST_DOTS, used = 0;
  double parameters[KM_MAX_DESIGN_PARAMETERS];
  double *x = KM_ARENA_NEW(arena, double, 2 * (size_t)count + 1),
         *y = KM_ARENA_NEW(arena, double, 2 * (size_t)count + 1);
  double *figures = KM_ARENA_NEW(arena, double, (size_t)count + 1);
  placed *order = KM_ARENA_NEW(arena, placed, (size_t)count + 1);
  if (!order)
    return false;
  for (int k = 0; k < count; ++k) {
    int design = km_design_study_representative(p->study, k, count);
    km_design_result r;
    if (!km_design_study_result(p->study, design, &r, NULL) && isfinite(r.figures[figure]) &&
        !km_design_study_values(p->study, design, parameters, NULL)) {
      figures[used] = r.figures[figure];
      order[used] = (placed){parameters[parameter], used};
      used++;
    }
  }
  qsort(order, (size_t)used, sizeof *order, by_value);
  for (int i = 0; i < used; ++i) {
    x[2 * i] = 100.0 * (i + 0.5) / used;
    y[2 * i] = figures[order[i].index];
    x[2 * i + 1] = y[2 * i + 1] = nan("");
  }
  *out = (km_plot_series){.x = x, .y = y, .count = 2 * (size_t)used};
  return used > 1;
}

km_status km_designs_scatter(const km_designs_shown *p, int figure, km_text *out, km_error *error) {
  double ranks[KM_MAX_DESIGN_PARAMETERS];
  km_plot_series series[MOST_PANELS];
  km_plot_panel panels[MOST_PANELS];
  placed order[KM_MAX_DESIGN_PARAMETERS];
  km_arena arena = {0};
  int count = 0, parameters = 0;
  km_status status = km_design_study_ranks(p->study, figure, ranks, error);
  if (status)
    return status;
  for (int k = 0; k < p->def->parameter_count; ++k)
    if (!isnan(ranks[k]))
      order[parameters++] = (placed){-fabs(ranks[k]), k};
  qsort(order, (size_t)parameters, sizeof *order, by_value);
  for (int k = 0; k < parameters && count < MOST_PANELS; ++k)
    if (make_dots(p, figure, order[k].index, &arena, &series[count])) {
      panels[count] = (km_plot_panel){.title = words(&arena, "%s, rank correlation %.2f",
                                                     p->def->parameters[order[k].index].name, ranks[order[k].index]),
                                      .series = &series[count],
                                      .series_count = 1};
      ++count;
    }
  if (!count)
    return nothing(&arena, error);
  km_plot plot = {.title = words(&arena, "What %s depends on", km_design_study_figure(p->study, figure)->name),
                  .subtitle = words(&arena, "%s · one dot a design, the parameters' designs in order", p->name),
                  .x_label = "share of the designs with a smaller value of the parameter (%)",
                  .y_label = label_of(p, figure, &arena),
                  .panels = panels,
                  .panel_count = (size_t)count};
  return km_designs_finish(p, !arena.failed, &plot, &arena, out, error);
}

/* Mean, and where its interval ends, at some of the counts. */
static size_t running_mean(const double *values, int count, double *x, double *mean, double *low, double *high) {
  km_moments moments = {0};
  size_t used = 0;
  for (int i = 0; i < count; ++i) {
    km_moments_add(&moments, values[i]);
    bool shown =
        i >= 9 && (i + 1 == count || (long long)(i + 1) * MOST_POINTS / count != (long long)i * MOST_POINTS / count);
    if (!shown)
      continue;
    double m = km_moments_mean(&moments), half = km_student(i) * (km_moments_deviation(&moments) / sqrt(i + 1));
    x[used] = i + 1;
    mean[used] = m;
    low[used] = m - half;
    high[used++] = m + half;
  }
  return used;
}

km_status km_designs_convergence(const km_designs_shown *p, int figure, km_text *out, km_error *error) {
  km_arena arena = {0};
  int count;
  double *values = values_of(p, figure, &arena, &count);
  double *room = KM_ARENA_NEW(&arena, double, 4 * (MOST_POINTS + 2));
  if (!values || !room || count < 20)
    return nothing(&arena, error);
  double *mean = room + MOST_POINTS + 2, *low = mean + MOST_POINTS + 2, *high = low + MOST_POINTS + 2;
  size_t points = running_mean(values, count, room, mean, low, high);
  const km_plot_series series[] = {
      {.name = "95 % confidence", .x = room, .y = high, .base = low, .count = points, .colour = -1},
      {.x = room, .y = low, .count = points, .colour = -1},
      {.name = "mean", .x = room, .y = mean, .count = points}};
  km_plot_panel panel = {.series = series, .series_count = 3};
  km_plot plot = {.title =
                      words(&arena, "How well the mean of %s is known", km_design_study_figure(p->study, figure)->name),
                  .subtitle = p->name,
                  .x_label = "designs",
                  .y_label = label_of(p, figure, &arena),
                  .panels = &panel,
                  .panel_count = 1};
  return km_designs_finish(p, !arena.failed, &plot, &arena, out, error);
}

/* Lines of the quantiles, each over `from` [rows] (NULL: over 0): the median strong, other pairs as lighter areas
 * around it. If not all names fit, only the widest pair and the median have names. */
static void make_fan(const double *quantiles, const double *x, int rows, const double *from, bool named,
                     double *columns, km_plot_series *series) {
  static const int lower[] = {0, 1, 2}, upper[] = {6, 5, 4};
  static const char *const names[] = {"1 %", "5 %", "25 %", "50 %", "75 %", "95 %", "99 %"};
  for (int k = 0; k < KM_DESIGN_QUANTILES; ++k)
    for (int r = 0; r < rows; ++r)
      columns[k * rows + r] = quantiles[(size_t)r * KM_DESIGN_QUANTILES + (size_t)k] - (from ? from[r] : 0.0);
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    const double *low = columns + lower[k] * rows, *high = columns + upper[k] * rows;
    series[count++] = (km_plot_series){
        .name = named ? names[upper[k]] : NULL, .x = x, .y = high, .base = low, .count = (size_t)rows, .dash = k + 1};
    series[count++] = (km_plot_series){
        .name = named ? names[lower[k]] : NULL, .x = x, .y = low, .count = (size_t)rows, .dash = k + 1};
  }
  series[count] = (km_plot_series){
      .name = named ? names[3] : NULL, .x = x, .y = columns + 3 * rows, .count = (size_t)rows, .colour = 1};
}

/* Abscissa of the rows: the driver's values, the arc length or the time. Returns the axis label. */
static const char *list_driver(const km_evaluated_design *asked, int rows, double *x, km_arena *arena) {
  const km_question *q = asked->question;
  const km_sweep_plan *plan = km_question_plan(q);
  const km_table *table = km_question_table(q);
  const bool driven = plan && plan->arclength <= 0.0;
  const int s = km_table_variable(table);
  for (int r = 0; r < rows; ++r)
    x[r] = driven ? plan->from + (plan->to - plan->from) * r / (rows > 1 ? rows - 1 : 1)
           : plan ? r * plan->arclength
                  : q->kind->planned_place(q, r);
  if (driven)
    return words(arena, "driver %s (%s)", km_model_coordinate_label(asked->model, plan->coordinate),
                 km_model_coordinate_unit(asked->model, plan->coordinate));
  return plan ? "arc length"
              : words(arena, "%s (%s)", km_question_history(q) ? "time" : "way along the path",
                      km_table_unit(table, (size_t)s));
}

/* The driver's values over the rows, and the axes' names, by the question's own plan. KM_NO_RESULT: no design has an
 * answer in full. */
static km_status driver_of(const km_designs_shown *p, int question, int band, int rows, double *x, km_arena *arena,
                           const char *labels[2], km_error *error) {
  km_evaluated_design asked = {0};
  const char *column = p->def->questions[question].bands[band];
  km_status status = KM_NO_RESULT;
  for (int i = 0; i < km_design_study_designs(p->study) && status != KM_OK && status != KM_MEMORY; ++i) {
    km_evaluated_design_free(&asked);
    status = km_design_study_evaluate(p->study, i, question, &asked, error);
  }
  if (status == KM_OK) {
    const km_table *table = km_question_table(asked.question);
    const char *unit = km_table_unit(table, (size_t)km_table_find(table, column));
    labels[0] = list_driver(&asked, rows, x, arena);
    labels[1] = words(arena, *unit ? "%s (%s)" : "%s", column, unit);
  }
  km_evaluated_design_free(&asked);
  return status == KM_OK || status == KM_MEMORY ? status : km_fail(error, KM_NO_RESULT, "there is nothing to draw");
}

km_status km_designs_bands(const km_designs_shown *p, int question, int band, km_text *out, km_error *error) {
  km_arena arena = {0};
  int rows;
  const char *labels[2] = {"", ""};
  const char *column = p->def->questions[question].bands[band];
  km_status status = km_design_study_bands(p->study, question, band, &rows, NULL, NULL, error);
  if (status)
    return status;
  size_t size = (size_t)rows * KM_DESIGN_QUANTILES + 1;
  double *x = KM_ARENA_NEW(&arena, double, (size_t)rows + 1), *quantiles = KM_ARENA_NEW(&arena, double, size);
  double *whole = KM_ARENA_NEW(&arena, double, size), *apart = KM_ARENA_NEW(&arena, double, size);
  int *counts = KM_ARENA_NEW(&arena, int, (size_t)rows + 1);
  if (!arena.failed)
    status = km_design_study_bands(p->study, question, band, &rows, quantiles, counts, error);
  if (!status && !arena.failed)
    status = driver_of(p, question, band, rows, x, &arena, labels, error);
  if (status) {
    km_arena_free(&arena);
    return status;
  }
  km_plot_series fan[KM_DESIGN_QUANTILES], apart_fan[KM_DESIGN_QUANTILES];
  if (!arena.failed) {
    make_fan(quantiles, x, rows, NULL, false, whole, fan);
    make_fan(quantiles, x, rows, whole + 3 * rows, true, apart, apart_fan);
  }
  const km_plot_panel panels[] = {
      {.y_label = labels[1], .series = fan, .series_count = KM_DESIGN_QUANTILES},
      {.y_label = "from its median", .series = apart_fan, .series_count = KM_DESIGN_QUANTILES}};
  km_plot plot = {.title = words(&arena, "%s along the motion, quantiles of the designs", column),
                  .subtitle = p->name,
                  .x_label = labels[0],
                  .panels = panels,
                  .panel_count = 2,
                  .own_y = true};
  return km_designs_finish(p, !arena.failed, &plot, &arena, out, error);
}
