/* The plot of a simulation: which columns it shows, panel by panel. */
#include "report/charts/history_plot.h"

#include "base/text.h"
#include "kinematics/state.h"
#include "report/charts/sweep_strip.h"

#include <string.h>

enum { MOST_PARTITIONS = 12, MOST_JOINTS = 8, MOST_PANELS = 10, MOST_SERIES = 64, STRIP_POSES = 5 };

typedef struct sheet {
  const km_plotted_history *h;
  km_arena *arena;
  const double *t;
  size_t rows;
  int joints[MOST_SERIES], joint_count;
  km_plot_panel *panels;
  size_t panel_count;
} sheet;

static const double *values_of(const sheet *s, size_t column) {
  double *values = KM_ARENA_NEW(s->arena, double, s->rows);
  if (values)
    km_table_column(s->h->table, column, values, NULL);
  return values;
}

static const char *store(const sheet *s, km_text *text) {
  const char *kept = text->failed ? NULL : km_arena_string(s->arena, text->data);
  s->arena->failed = s->arena->failed || !kept;
  km_text_free(text);
  return kept;
}

static int find(const sheet *s, const char *prefix, const char *label) {
  km_text name = {0};
  km_text_format(&name, "%s%s", prefix, label);
  int column = name.failed ? -1 : km_table_find(s->h->table, name.data);
  s->arena->failed = s->arena->failed || name.failed;
  km_text_free(&name);
  return column;
}

/* Range of a coordinate, in radians or characteristic lengths. */
static double span_of(const sheet *s, int coordinate) {
  const km_mechanism *m = s->h->mechanism;
  int column = find(s, "q.", m->model->coordinates[coordinate].label);
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (size_t r = 0; r < s->rows && column >= 0; ++r) {
    double value = km_table_row(s->h->table, r)[column];
    low = fmin(low, value);
    high = fmax(high, value);
  }
  return high > low ? (high - low) * km_model_coordinate_factor(m->model, coordinate) * m->scale[coordinate] : 0.0;
}

/* Up to eight that go farthest, in the file's order. */
static void choose_joints(sheet *s) {
  const km_mechanism *m = s->h->mechanism;
  double *span = KM_ARENA_NEW(s->arena, double, (size_t)m->coordinate_count);
  for (int c = 0; span && c < m->coordinate_count; ++c)
    span[c] = span_of(s, c);
  for (int c = 0; span && c < m->coordinate_count; ++c) {
    int farther = 0;
    for (int o = 0; o < m->coordinate_count; ++o)
      farther += span[o] > span[c] || (span[o] == span[c] && o < c);
    if (farther < MOST_JOINTS && span[c] > 1e-9)
      s->joints[s->joint_count++] = c;
  }
}

static void add_panel(sheet *s, const char *y_label, km_plot_series *series, size_t count) {
  if (count && s->panel_count < MOST_PANELS)
    s->panels[s->panel_count++] = (km_plot_panel){.y_label = y_label, .series = series, .series_count = count};
}

/* A panel for each unit among the joints' columns of this prefix. */
static void add_joint_panels(sheet *s, const char *prefix, const char *what) {
  const km_model *model = s->h->mechanism->model;
  bool shown[MOST_SERIES] = {false};
  for (int first = 0; first < s->joint_count; ++first) {
    int leading = find(s, prefix, model->coordinates[s->joints[first]].label);
    km_plot_series *series = KM_ARENA_NEW(s->arena, km_plot_series, (size_t)s->joint_count);
    size_t count = 0;
    if (shown[first] || leading < 0 || !series)
      continue;
    const char *unit = km_table_unit(s->h->table, (size_t)leading);
    for (int i = first; i < s->joint_count; ++i) {
      int column = find(s, prefix, model->coordinates[s->joints[i]].label);
      if (column < 0 || strcmp(km_table_unit(s->h->table, (size_t)column), unit) != 0)
        continue;
      shown[i] = true;
      series[count++] = (km_plot_series){.name = model->coordinates[s->joints[i]].label,
                                         .x = s->t,
                                         .y = values_of(s, (size_t)column),
                                         .count = s->rows,
                                         .colour = i % MOST_JOINTS,
                                         .dash = i % MOST_JOINTS};
    }
    km_text label = {0};
    km_text_format(&label, *unit ? "%s (%s)" : "%s", what, unit);
    add_panel(s, store(s, &label), series, count);
  }
}

static void add_energies(sheet *s) {
  static const char *const columns[] = {"energy_kinetic", "energy_potential", "energy_dissipated", "motor_work"};
  static const char *const names[] = {"kinetic", "potential", "dissipated", "work of motors"};
  km_plot_series *series = KM_ARENA_NEW(s->arena, km_plot_series, 4);
  size_t count = 0;
  const char *unit = "";
  for (int i = 0; i < 4 && series; ++i) {
    int column = km_table_find(s->h->table, columns[i]);
    const double *values = column < 0 ? NULL : values_of(s, (size_t)column);
    bool any = i < 2;
    for (size_t r = 0; values && r < s->rows; ++r)
      any = any || values[r] != 0.0;
    if (!values || !any)
      continue;
    unit = km_table_unit(s->h->table, (size_t)column);
    series[count++] =
        (km_plot_series){.name = names[i], .x = s->t, .y = values, .count = s->rows, .colour = i, .dash = i};
  }
  km_text label = {0};
  km_text_format(&label, "energy (%s)", unit);
  add_panel(s, store(s, &label), series, count);
}

/* Appends a mark for each event that was located. */
static size_t mark_events(const sheet *s, km_plot_mark *marks) {
  const km_plotted_history *h = s->h;
  for (int i = 0; i < h->met_count; ++i) {
    const km_crossing *crossing = &h->crossings[h->met[i].crossing];
    km_text name = {0};
    km_text_format(&name, "%s = %.6g", km_model_coordinate_label(h->mechanism->model, crossing->coordinate),
                   crossing->value);
    marks[i] = (km_plot_mark){.x = h->met[i].time, .name = store(s, &name)};
  }
  return (size_t)h->met_count;
}

/* Appends a mark for each row before which the independent coordinates changed; none where they are too many to
 * distinguish. */
static size_t mark_partitions(const sheet *s, km_plot_mark *marks) {
  int column = km_table_find(s->h->table, "repartitions");
  const double *counts = column < 0 ? NULL : values_of(s, (size_t)column);
  size_t count = 0;
  for (size_t r = 1; r < s->rows && counts; ++r)
    count += counts[r] > counts[r - 1];
  if (!counts || count > MOST_PARTITIONS)
    return 0;
  for (size_t r = 1, i = 0; r < s->rows; ++r)
    if (counts[r] > counts[r - 1])
      marks[i++] = (km_plot_mark){.x = s->t[r], .name = "partition"};
  return count;
}

static void add_marks(sheet *s) {
  km_plot_mark *marks = KM_ARENA_NEW(s->arena, km_plot_mark, (size_t)s->h->met_count + MOST_PARTITIONS + 1);
  if (!s->panel_count || !marks)
    return;
  size_t count = mark_events(s, marks);
  count += mark_partitions(s, marks + count);
  s->panels[0].marks = marks;
  s->panels[0].mark_count = count;
}

/* Every driven joint has a curve, whichever joints are shown. */
static void add_drives(sheet *s) {
  const km_model *model = s->h->mechanism->model;
  sheet drives = *s;
  drives.joint_count = 0;
  for (int c = 0; c < model->coordinate_count && drives.joint_count < MOST_SERIES; ++c)
    if (find(s, "f.", model->coordinates[c].label) >= 0)
      drives.joints[drives.joint_count++] = c;
  add_joint_panels(&drives, "f.", "driving force");
  s->panel_count = drives.panel_count;
}

static const double rounding = 1e-9; /* part of the largest component below which another one is not drawn */

static double largest_of(const sheet *s, size_t column) {
  double largest = 0.0;
  for (size_t r = 0; r < s->rows; ++r)
    largest = fmax(largest, fabs(km_table_row(s->h->table, r)[column]));
  return largest;
}

static void add_shaking(sheet *s) {
  static const char *const names[] = {"x", "y", "z"};
  km_span span = km_table_span(s->h->table, "shaking.");
  for (size_t part = 0; part < span.count; part += 3) {
    km_plot_series *series = KM_ARENA_NEW(s->arena, km_plot_series, 3);
    km_text label = {0};
    km_text_format(&label, "%s (%s)", part ? "shaking moment" : "shaking force",
                   km_table_unit(s->h->table, span.first + part));
    size_t count = 0;
    double largest = 0.0;
    for (size_t k = 0; k < 3; ++k)
      largest = fmax(largest, largest_of(s, span.first + part + k));
    for (size_t k = 0; k < 3 && series; ++k)
      if (largest_of(s, span.first + part + k) > rounding * largest)
        series[count++] = (km_plot_series){.name = names[k],
                                           .x = s->t,
                                           .y = values_of(s, span.first + part + k),
                                           .count = s->rows,
                                           .colour = (int)k,
                                           .dash = (int)k};
    add_panel(s, store(s, &label), series, count);
  }
}

static bool start(sheet *s) {
  const km_plotted_history *h = s->h;
  s->rows = km_table_rows(h->table);
  s->panels = KM_ARENA_NEW(s->arena, km_plot_panel, MOST_PANELS);
  s->t = values_of(s, 0);
  if (s->arena->failed)
    return false;
  for (int i = 0; h->joints && i < h->joint_count && i < MOST_SERIES; ++i)
    s->joints[s->joint_count++] = h->joints[i];
  if (!h->joints)
    choose_joints(s);
  return true;
}

static bool finish(sheet *s, const char *title, km_plot *out) {
  const km_plotted_history *h = s->h;
  km_text x = {0}, subtitle = {0};
  km_text_format(&x, "time (%s)", h->mechanism->model->units.time->suffix);
  km_text_format(&subtitle, "%s, %zu rows", h->name, s->rows);
  *out = (km_plot){.title = title,
                   .subtitle = store(s, &subtitle),
                   .x_label = store(s, &x),
                   .y_label = "",
                   .panels = s->panels,
                   .panel_count = s->panel_count,
                   .own_y = true};
  km_sweep_strip *strip = KM_ARENA_NEW(s->arena, km_sweep_strip, 1);
  if (strip)
    out->strip = km_motion_strip_make(h->mechanism, h->table, STRIP_POSES, s->arena, strip);
  return !s->arena->failed;
}

bool km_history_plot_make(const km_plotted_history *h, km_arena *arena, km_plot *out) {
  sheet s = {.h = h, .arena = arena};
  if (!start(&s))
    return false;
  add_joint_panels(&s, "q.", "coordinate");
  add_joint_panels(&s, "v.", "rate");
  add_drives(&s);
  size_t before = s.panel_count;
  add_joint_panels(&s, "m.", "mobility number");
  for (size_t p = before; p < s.panel_count; ++p)
    s.panels[p].y_high = 1.0;
  add_energies(&s);
  add_marks(&s);
  return finish(&s, "Motion over time", out);
}

bool km_inverse_plot_make(const km_plotted_history *h, km_arena *arena, km_plot *out) {
  sheet s = {.h = h, .arena = arena};
  if (!start(&s))
    return false;
  add_drives(&s);
  add_shaking(&s);
  add_joint_panels(&s, "q.", "coordinate");
  return finish(&s, "Forces of a prescribed motion", out);
}
