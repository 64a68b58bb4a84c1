/* Plots of columns of sweeps' tables: lines cut at poles, marks, axes that poles don't stretch. */
#include "report/charts/sweep_plot.h"

#include "report/canvas/palette.h"
#include "report/charts/sweep_strip.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST_COLOURED = 8 };

/* The pole of a line between two of its points, NaN if there is none. */
static double pole_between(const km_sweep_picture *p, const km_swept_line *line, double from, double to) {
  for (size_t i = 0; i < p->break_count; ++i) {
    const km_swept_break *b = &p->breaks[i];
    if (b->sweep == line->sweep && b->column == line->column && (b->s - from) * (to - b->s) >= 0.0)
      return b->s;
  }
  return nan("");
}

typedef struct row {
  double s;
  const double *cells;
} row;

static int by_s(const void *a, const void *b) {
  double x = ((const row *)a)->s, y = ((const row *)b)->s;
  return (x > y) - (x < y);
}

/* All rows of a sweep, those between rows too, from left to right. */
static row *rows_of(const km_sweep *motion, km_arena *arena, size_t *count) {
  const km_table *const tables[2] = {motion->table, motion->between};
  *count = km_table_rows(tables[0]) + km_table_rows(tables[1]);
  row *rows = KM_ARENA_NEW(arena, row, *count);
  size_t used = 0;
  for (int i = 0; i < 2 && rows; ++i) {
    int s = km_table_find(tables[i], "s");
    for (size_t r = 0; r < km_table_rows(tables[i]); ++r, ++used)
      rows[used] = (row){km_table_row(tables[i], r)[s], km_table_row(tables[i], r)};
  }
  if (rows)
    qsort(rows, used, sizeof *rows, by_s);
  return rows;
}

/* Points of a line from left to right, so that its name is at its right end. An undefined point interrupts the line,
 * also at a pole, where x is the location of the pole. */
static void fill_series(const km_sweep_picture *p, const km_swept_line *line, km_arena *arena, km_plot_series *out) {
  size_t count;
  row *rows = rows_of(p->sweeps[line->sweep].motion, arena, &count);
  double *x = KM_ARENA_NEW(arena, double, 2 * count), *y = KM_ARENA_NEW(arena, double, 2 * count);
  *out = (km_plot_series){.name = line->name, .x = x, .y = y};
  for (size_t r = 0; r < count && !arena->failed; ++r) {
    double s = rows[r].s, at = 1e-8 * (1.0 + fabs(s)), pole = pole_between(p, line, s - at, s + at);
    if (isnan(pole) && r > 0)
      pole = pole_between(p, line, rows[r - 1].s, s);
    bool there = fabs(s - pole) <= at;
    if (!isnan(pole) && (out->count == 0 || !(x[out->count - 1] == pole && isnan(y[out->count - 1])))) {
      x[out->count] = pole;
      y[out->count++] = nan("");
    }
    if (there)
      continue;
    x[out->count] = s;
    y[out->count++] = rows[r].cells[line->column];
  }
}

static double largest_of(const double *y, size_t count) {
  double largest = 0.0;
  for (size_t i = 0; i < count; ++i)
    if (isfinite(y[i]))
      largest = fmax(largest, fabs(y[i]));
  return largest;
}

/* Number of larger lines of the panel. */
static int importance(const km_plot_series *series, size_t count, size_t index) {
  double own = largest_of(series[index].y, series[index].count);
  int larger = 0;
  for (size_t i = 0; i < count; ++i) {
    double other = largest_of(series[i].y, series[i].count);
    larger += other > own || (other == own && i < index);
  }
  return larger;
}

/* The place of a line among those of its sweep in the panel. */
static int place_of(const km_sweep_picture *p, size_t index) {
  int place = 0;
  for (size_t i = 0; i < index; ++i)
    place += p->lines[i].panel == p->lines[index].panel && p->lines[i].sweep == p->lines[index].sweep;
  return place;
}

/* Sweeps that are compared have a colour each, and their lines a dash pattern each. */
static void colour_compared(const km_sweep_picture *p, int panel, km_plot_series *series) {
  size_t next = 0;
  for (size_t i = 0; i < p->line_count; ++i) {
    if (p->lines[i].panel != panel)
      continue;
    series[next].colour = km_palette_compared(p->lines[i].sweep, p->sweep_count, p->ordered);
    series[next++].dash = place_of(p, i);
  }
}

static void colour_own(km_plot_series *series, size_t count) {
  int next = 0;
  for (size_t i = 0; i < count; ++i) {
    bool coloured = importance(series, count, i) < MOST_COLOURED;
    series[i].colour = coloured ? next++ : -1;
    series[i].dash = coloured ? series[i].colour : 0;
  }
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
  if (arena->failed)
    return;
  if (p->sweep_count > 1)
    colour_compared(p, panel, series);
  else
    colour_own(series, out->series_count);
  for (size_t i = 0; i < p->mark_count && !arena->failed; ++i)
    if (p->marks[i].panel == panel)
      marks[out->mark_count++] = (km_plot_mark){
          p->marks[i].s, p->marks[i].name,
          p->sweep_count > 1 ? 1 + km_palette_compared(p->marks[i].sweep, p->sweep_count, p->ordered) : 0};
}

/* Extent of a cluster of poles: poles nearer to each other than a twentieth of the line act as one pole. 0 for a
 * single pole, or none (NaN). */
static double spread_of_poles(const km_sweep_picture *p, const km_swept_line *line, double pole, double whole) {
  double low = pole, high = pole;
  for (bool grows = !isnan(pole); grows;) {
    grows = false;
    for (size_t i = 0; i < p->break_count; ++i) {
      const km_swept_break *b = &p->breaks[i];
      bool outside = b->s < low || b->s > high, beside = b->s > low - 0.05 * whole && b->s < high + 0.05 * whole;
      if (b->sweep != line->sweep || b->column != line->column || !outside || !beside)
        continue;
      low = fmin(low, b->s);
      high = fmax(high, b->s);
      grows = true;
    }
  }
  return isnan(pole) ? 0.0 : high - low;
}

/* A stretch of a line between poles or ends. */
typedef struct stretch {
  size_t begin, end;
  double left, right; /* poles; NaN: an end */
  double near[2];     /* distance that counts as near to a pole */
  bool hidden;        /* width of a cluster of poles */
} stretch;

static stretch stretch_of(const km_sweep_picture *p, const km_swept_line *line, const km_plot_series *series,
                          size_t begin, size_t end) {
  const double *x = series->x;
  double whole = x[series->count - 1] - x[0];
  stretch out = {.begin = begin, .end = end};
  out.left = begin > 0 ? pole_between(p, line, x[begin - 1], x[begin - 1]) : nan("");
  out.right = end < series->count ? pole_between(p, line, x[end], x[end]) : nan("");
  double from = isnan(out.left) ? x[begin] : out.left, to = isnan(out.right) ? x[end - 1] : out.right;
  out.near[0] = 0.05 * (to - from) + spread_of_poles(p, line, out.left, whole);
  out.near[1] = 0.05 * (to - from) + spread_of_poles(p, line, out.right, whole);
  out.hidden = out.right - out.left < 0.05 * whole;
  return out;
}

/* Range of a line that must be visible: all rows except the last twentieth of an interval before a pole, of which
 * only extrema count. Widens low … high; true if rows are left out. */
static bool widen_seen(const km_sweep_picture *p, const km_swept_line *line, const km_plot_series *series, double *low,
                       double *high) {
  bool cut = false;
  const double *x = series->x, *y = series->y;
  for (size_t begin = 0, end; begin < series->count; begin = end + 1) {
    for (end = begin; end < series->count && !isnan(y[end]);)
      ++end;
    if (end == begin)
      continue;
    stretch of = stretch_of(p, line, series, begin, end);
    cut = cut || of.hidden;
    for (size_t k = begin; k < end && !of.hidden; ++k) {
      bool near = x[k] - of.left < of.near[0] || of.right - x[k] < of.near[1];
      bool turns = k > begin && k + 1 < end && isfinite(y[k - 1]) && isfinite(y[k + 1]) &&
                   (y[k] - y[k - 1]) * (y[k + 1] - y[k]) < 0.0;
      cut = cut || (near && !turns);
      if ((near && !turns) || !isfinite(y[k]))
        continue;
      *low = fmin(*low, y[k]);
      *high = fmax(*high, y[k]);
    }
  }
  return cut;
}

/* The axis ends where every line is seen, but for its way to a pole. */
static void limit_axis(const km_sweep_picture *p, km_plot *plot) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  bool cut = false;
  for (size_t k = 0; k < plot->panel_count; ++k)
    for (size_t i = 0, series = 0; i < p->line_count; ++i)
      if (p->lines[i].panel == (int)k)
        cut = widen_seen(p, &p->lines[i], &plot->panels[k].series[series++], &low, &high) || cut;
  if (!cut || low > high)
    return;
  low = fmin(low, 0.0);
  high = fmax(high, 0.0);
  double room = low == high ? 1.0 : 0.03 * (high - low);
  plot->y_low = low < 0.0 ? low - room : 0.0;
  plot->y_high = high > 0.0 ? high + room : 0.0;
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
  if (p->break_count)
    km_text_add(&text, " · arrows: no bound");
  return km_text_move_to_arena(&text, arena);
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
    limit_axis(p, out);
  km_sweep_strip *strip = KM_ARENA_NEW(arena, km_sweep_strip, 1);
  if (p->strip && !arena->failed)
    out->strip = p->sweep_count > 1 ? km_comparison_strip_make(p->sweeps, p->sweep_count, p->ordered, arena, strip)
                                    : km_sweep_strip_make(&p->sweeps[0], 3, arena, strip);
  return !arena->failed;
}
