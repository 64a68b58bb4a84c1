/* The plot of mobility numbers over a sweep: which lines, colours, panels and marks. */
#include "report/charts/mobility_plot.h"

#include "report/canvas/palette.h"
#include "report/charts/sweep_strip.h"
#include "report/plot/plot.h"
#include "report/plot/short_names.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_LINES = 8, MOST_PANELS = 9, NAME_SIZE = 160 };
static const double same = 1e-9; /* numbers that differ less all along share a line */

/* A line before it is drawn: one coordinate, or several with the same numbers. */
typedef struct line {
  char name[NAME_SIZE];
  double *y;
  const double *x;
  size_t count;
  int sweep, substructure, merged;
  double largest;
} line;

typedef struct lines {
  km_arena *arena;
  line *items;
  size_t count;
  double **x; /* [sweep] */
  bool ordered;
} lines;

static double *column_of(lines *l, const km_table *table, size_t column) {
  size_t rows = km_table_rows(table);
  double *values = KM_ARENA_NEW(l->arena, double, rows);
  for (size_t r = 0; values && r < rows; ++r)
    values[r] = km_table_row(table, r)[column];
  return values;
}

static bool agree(const double *a, const double *b, size_t count) {
  for (size_t i = 0; i < count; ++i)
    if (!(fabs(a[i] - b[i]) < same))
      return false;
  return true;
}

/* Adds a coordinate's line, or its name to the line that it agrees with. */
static void add_line(lines *l, const km_plotted_sweep *p, int sweep, int coordinate, size_t table_column) {
  const char *label = p->mechanism->model->coordinates[coordinate].label;
  int substructure = p->mechanism->substructure_of[coordinate];
  size_t rows = km_table_rows(p->sweep->motion.table);
  double *y = column_of(l, p->sweep->motion.table, table_column);
  if (!y)
    return;
  for (size_t i = 0; i < l->count; ++i) {
    line *other = &l->items[i];
    if (other->sweep != sweep || other->substructure != substructure || !agree(other->y, y, rows))
      continue;
    size_t used = strlen(other->name);
    snprintf(other->name + used, NAME_SIZE - used, ", %s", label);
    other->merged++;
    return;
  }
  line *new = &l->items[l->count++];
  *new = (line){.y = y, .x = l->x[sweep], .count = rows, .sweep = sweep, .substructure = substructure, .merged = 1};
  snprintf(new->name, NAME_SIZE, "%s", label);
  for (size_t r = 0; r < rows; ++r)
    new->largest = fmax(new->largest, y[r]);
}

/* True if the coordinate's mobility number is drawn. Default: all coordinates in loops or couplings, otherwise all;
 * for several sweeps the driver's. */
static bool is_shown(const km_plotted_sweep *p, int count, int coordinate) {
  const km_mechanism *m = p->mechanism;
  for (int i = 0; i < p->shown_count; ++i)
    if (p->shown[i] == coordinate)
      return true;
  int driver = p->plan->arclength > 0.0 ? p->plan->direction : p->plan->coordinate;
  if (p->shown || (count > 1 && driver >= 0))
    return !p->shown && coordinate == driver;
  return m->topology.substructure_count == 0 || (m->substructure_of[coordinate] >= 0 && !m->held[coordinate]);
}

/* Lines of the coordinates that are drawn. */
static void gather(lines *l, const km_plotted_sweep *sweeps, int count) {
  for (int i = 0; i < count && !l->arena->failed; ++i) {
    const km_plotted_sweep *p = &sweeps[i];
    const km_mechanism *m = p->mechanism;
    l->x[i] = column_of(l, p->sweep->motion.table, (size_t)km_table_find(p->sweep->motion.table, "s"));
    size_t column = km_table_span(p->sweep->motion.table, "m.").first;
    for (int j = 0; j < m->model->joint_count && !l->arena->failed; ++j) {
      int freedom = km_model_freedom(m->model, j);
      column += freedom == 0;
      for (int k = 0; k < freedom; ++k, ++column) {
        int c = m->model->joints[j].first_coordinate + k;
        if (is_shown(p, count, c))
          add_line(l, p, i, c, column);
      }
    }
  }
}

static size_t most_lines(const km_plotted_sweep *sweeps, int count) {
  size_t total = 0;
  for (int i = 0; i < count; ++i)
    total += (size_t)sweeps[i].mechanism->coordinate_count;
  return total;
}

/* Number of lines of the panel with a larger maximum: the eight largest are coloured. */
static int importance(const lines *l, size_t index, int substructure) {
  int larger = 0;
  for (size_t i = 0; i < l->count; ++i)
    if ((substructure < 0 || l->items[i].substructure == substructure) && l->items[i].sweep == l->items[index].sweep)
      larger += l->items[i].largest > l->items[index].largest ||
                (l->items[i].largest == l->items[index].largest && i < index);
  return larger;
}

/* Index of a line in its sweep: overlaid sweeps distinguish joints by dashes. */
static int place_of(const lines *l, size_t index) {
  int place = 0;
  for (size_t i = 0; i < index; ++i)
    place += l->items[i].sweep == l->items[index].sweep;
  return place;
}

static void fill_panel(lines *l, const km_plotted_sweep *sweeps, int count, int substructure, km_plot_panel *panel) {
  km_plot_series *series = KM_ARENA_NEW(l->arena, km_plot_series, l->count);
  size_t used = 0;
  const char **models = km_short_names_of(&sweeps[0].name, sizeof *sweeps, count, l->arena);
  int next = 0;
  if (l->arena->failed)
    return;
  for (size_t i = 0; i < l->count; ++i) {
    const line *item = &l->items[i];
    if (substructure >= 0 && item->substructure != substructure)
      continue;
    char name[2 * NAME_SIZE];
    snprintf(name, sizeof name, count > 1 ? "%s (%.60s)" : "%s", item->name, models[item->sweep]);
    bool compared = count > 1, coloured = importance(l, i, substructure) < MOST_LINES;
    int colour = compared ? km_palette_compared(item->sweep, count, l->ordered) : coloured ? next++ : -1;
    series[used++] = (km_plot_series){.name = km_arena_string(l->arena, name),
                                      .x = item->x,
                                      .y = item->y,
                                      .count = item->count,
                                      .colour = colour,
                                      .dash = compared   ? place_of(l, i)
                                              : coloured ? colour
                                                         : 0};
  }
  panel->series = series;
  panel->series_count = used;
}

static int mark_colour(const lines *l, int count, int sweep) {
  return count > 1 ? 1 + km_palette_compared(sweep, count, l->ordered) : 0;
}

static void fill_marks(lines *l, const km_plotted_sweep *sweeps, int count, int substructure, km_plot_panel *panel) {
  size_t total = 0;
  for (int i = 0; i < count; ++i)
    total += sweeps[i].sweep->toggle_count + sweeps[i].sweep->motion.branch_count;
  km_plot_mark *marks = KM_ARENA_NEW(l->arena, km_plot_mark, total);
  if (!marks)
    return;
  for (int i = 0; i < count; ++i) {
    const km_mechanism *m = sweeps[i].mechanism;
    for (size_t k = 0; k < sweeps[i].sweep->toggle_count; ++k) {
      const km_toggle *toggle = &sweeps[i].sweep->toggles[k];
      if (substructure >= 0 && m->substructure_of[toggle->coordinate] != substructure)
        continue;
      if (count > 1 && !is_shown(&sweeps[i], count, toggle->coordinate))
        continue;
      marks[panel->mark_count++] =
          (km_plot_mark){toggle->s, m->model->coordinates[toggle->coordinate].label, mark_colour(l, count, i)};
    }
  }
  for (int i = 0; i < count; ++i)
    for (size_t k = 0; k < sweeps[i].sweep->motion.branch_count &&
                       (substructure < 0 || sweeps[i].sweep->motion.substructure == substructure);
         ++k)
      marks[panel->mark_count++] =
          (km_plot_mark){sweeps[i].sweep->motion.branches[k].s, "branch point", mark_colour(l, count, i)};
  panel->marks = marks;
}

/* One panel for all, or one for each substructure that has lines. */
static size_t make_panels(lines *l, const km_plotted_sweep *sweeps, int count, km_plot_panel *panels) {
  int substructures = 0;
  for (int i = 0; i < count; ++i)
    if (sweeps[i].mechanism->topology.substructure_count > substructures)
      substructures = sweeps[i].mechanism->topology.substructure_count;
  bool split = count == 1 && l->count > MOST_LINES && substructures > 1 && substructures <= MOST_PANELS;
  if (!split) {
    fill_panel(l, sweeps, count, -1, &panels[0]);
    fill_marks(l, sweeps, count, -1, &panels[0]);
    return 1;
  }
  for (int s = 0; s < substructures; ++s) {
    char title[40];
    snprintf(title, sizeof title, "substructure %d", s + 1);
    panels[s].title = km_arena_string(l->arena, title);
    fill_panel(l, sweeps, count, s, &panels[s]);
    fill_marks(l, sweeps, count, s, &panels[s]);
  }
  return (size_t)substructures;
}

static bool some_toggle(const km_plotted_sweep *sweeps, int count) {
  for (int i = 0; i < count; ++i)
    if (sweeps[i].sweep->toggle_count)
      return true;
  return false;
}

static const char *subtitle(lines *l, const km_plotted_sweep *sweeps, int count) {
  const km_model *model = sweeps[0].mechanism->model;
  km_text text = {0};
  for (int i = 0; i < count; ++i)
    km_text_format(&text, "%s%s", i ? ", " : "", sweeps[i].name);
  km_text_format(&text, " · mobility %d · %s, %s · characteristic length %g %s", sweeps[0].sweep->motion.first.mobility,
                 model->units.angle->word, model->units.length->word, sweeps[0].mechanism->length,
                 model->units.length->suffix);
  if (some_toggle(sweeps, count))
    km_text_add(&text, " · ▲ a dead point of a joint");
  return km_text_move_to_arena(&text, l->arena);
}

static const char *x_label(const lines *l, const km_plotted_sweep *first) {
  char text[2 * NAME_SIZE] = "arc length (radians, lengths over the characteristic length)";
  if (first->plan->arclength <= 0.0)
    snprintf(text, sizeof text, "driver %s (%s)",
             km_model_coordinate_label(first->mechanism->model, first->plan->coordinate),
             km_model_coordinate_unit(first->mechanism->model, first->plan->coordinate));
  return km_arena_string(l->arena, text);
}

static void fill_plot(lines *l, const km_plotted_sweep *sweeps, int count, km_plot *out) {
  km_plot_panel *panels = KM_ARENA_NEW(l->arena, km_plot_panel, MOST_PANELS);
  km_sweep_strip *strip = KM_ARENA_NEW(l->arena, km_sweep_strip, 1);
  if (l->arena->failed)
    return;
  *out = (km_plot){.title = sweeps[0].plan->arclength > 0.0 ? "Mobility numbers along the motion"
                                                            : "Mobility numbers over the stroke",
                   .subtitle = subtitle(l, sweeps, count),
                   .x_label = x_label(l, &sweeps[0]),
                   .y_label = "mobility number",
                   .y_low = 0.0,
                   .y_high = 1.0,
                   .panels = panels,
                   .panel_count = make_panels(l, sweeps, count, panels)};
  km_swept *swept = KM_ARENA_NEW(l->arena, km_swept, (size_t)count);
  for (int i = 0; i < count && swept; ++i)
    swept[i] = (km_swept){sweeps[i].mechanism, sweeps[i].plan, &sweeps[i].sweep->motion, sweeps[i].name};
  if (swept)
    out->strip = count > 1 ? km_comparison_strip_make(swept, count, l->ordered, l->arena, strip)
                           : km_sweep_strip_make(swept, 3, l->arena, strip);
}

bool km_mobility_plot_make(const km_plotted_sweep *sweeps, int count, bool ordered, km_arena *arena, km_plot *out) {
  lines l = {.arena = arena, .ordered = ordered};
  l.items = KM_ARENA_NEW(arena, line, most_lines(sweeps, count));
  l.x = KM_ARENA_NEW(arena, double *, (size_t)count);
  if (!arena->failed)
    gather(&l, sweeps, count);
  if (!arena->failed)
    fill_plot(&l, sweeps, count, out);
  return !arena->failed;
}
