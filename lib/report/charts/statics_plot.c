/* The plot of actuator forces over a sweep: which lines, panels and marks. */
#include "report/charts/statics_plot.h"

#include "report/plot/short_names.h"
#include "statics/statics.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double same = 1e-9; /* forces that differ less, relatively, all along share a line */

size_t km_force_column(const km_statics_sweep *sweep, int actuator) {
  return km_table_span(sweep->motion.table, "f.").first + (size_t)actuator;
}

static bool agree(const km_table *table, size_t a, size_t b) {
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    double x = km_table_row(table, r)[a], y = km_table_row(table, r)[b];
    if (!(fabs(x - y) <= same * (fabs(x) + fabs(y))) && !(isnan(x) && isnan(y)))
      return false;
  }
  return true;
}

/* Pushed points are always drawn. */
static bool is_shown(const km_plotted_statics *p, const km_port *actuator) {
  bool shown = !p->shown || actuator->kind == KM_PORT_POINT;
  for (int i = 0; i < p->shown_count && !shown; ++i)
    shown = p->shown[i] == actuator->coordinate;
  return shown;
}

/* The picture in the making. */
typedef struct maker {
  const km_plotted_statics *sweeps;
  int count;
  km_arena *arena;
  const char **models; /* [count] short names */
  km_swept *swept;
  km_swept_line *lines;
  size_t line_count;
  km_swept_mark *marks;
  size_t mark_count;
  km_swept_break *breaks;
  size_t break_count;
  bool forces, torques;
} maker;

/* Adds the actuator's line, or its name to the line that it agrees with. */
static void add_line(maker *k, int sweep, int actuator) {
  const km_plotted_statics *p = &k->sweeps[sweep];
  const km_model *model = p->swept.mechanism->model;
  const km_port *handle = &p->sweep->actuators[actuator];
  int panel = k->forces && !km_actuator_has_force(model, handle) ? 1 : 0;
  size_t column = km_force_column(p->sweep, actuator);
  char name[400];
  for (size_t i = 0; i < k->line_count; ++i) {
    km_swept_line *other = &k->lines[i];
    if (other->sweep != sweep || other->panel != panel || !agree(p->sweep->motion.table, other->column, column))
      continue;
    snprintf(name, sizeof name, "%.180s, %.180s", other->name, handle->name);
    other->name = km_arena_string(k->arena, name);
    return;
  }
  snprintf(name, sizeof name, k->count > 1 ? "%.180s (%.180s)" : "%.180s", handle->name, k->models[sweep]);
  k->lines[k->line_count++] = (km_swept_line){sweep, column, km_arena_string(k->arena, name), panel};
}

static void add_marks(maker *k, int sweep) {
  const km_plotted_statics *p = &k->sweeps[sweep];
  const km_model *model = p->swept.mechanism->model;
  for (size_t i = 0; i < p->sweep->event_count; ++i) {
    const km_force_event *e = &p->sweep->events[i];
    const km_port *handle = &p->sweep->actuators[e->actuator];
    int panel = k->forces && !km_actuator_has_force(model, handle) ? 1 : 0;
    char name[300];
    if (e->kind == KM_FORCE_PEAK || !is_shown(p, handle))
      continue;
    snprintf(name, sizeof name, e->kind == KM_FORCE_BALANCED ? "%.200s 0" : "%.200s ∞", handle->name);
    k->marks[k->mark_count++] = (km_swept_mark){sweep, panel, e->s, km_arena_string(k->arena, name)};
    if (e->kind == KM_FORCE_UNBOUNDED)
      k->breaks[k->break_count++] = (km_swept_break){sweep, km_force_column(p->sweep, e->actuator), e->s};
  }
}

static bool gather(maker *k) {
  size_t lines = 0, marks = 0;
  for (int i = 0; i < k->count; ++i) {
    const km_statics_sweep *s = k->sweeps[i].sweep;
    lines += (size_t)s->actuator_count;
    marks += s->event_count;
    for (int a = 0; a < s->actuator_count; ++a) {
      bool length = km_actuator_has_force(k->sweeps[i].swept.mechanism->model, &s->actuators[a]);
      k->forces = k->forces || length;
      k->torques = k->torques || !length;
    }
  }
  k->swept = KM_ARENA_NEW(k->arena, km_swept, (size_t)k->count);
  k->lines = KM_ARENA_NEW(k->arena, km_swept_line, lines);
  k->marks = KM_ARENA_NEW(k->arena, km_swept_mark, marks);
  k->breaks = KM_ARENA_NEW(k->arena, km_swept_break, marks);
  k->models = km_short_names_of(&k->sweeps[0].swept.name, sizeof *k->sweeps, k->count, k->arena);
  for (int i = 0; i < k->count && !k->arena->failed; ++i) {
    k->swept[i] = k->sweeps[i].swept;
    for (int a = 0; a < k->sweeps[i].sweep->actuator_count && !k->arena->failed; ++a)
      if (is_shown(&k->sweeps[i], &k->sweeps[i].sweep->actuators[a]))
        add_line(k, i, a);
    add_marks(k, i);
  }
  return !k->arena->failed;
}

bool km_statics_plot_make(const km_plotted_statics *sweeps, int count, bool ordered, bool strip, km_arena *arena,
                          km_plot *out) {
  static const char *const both[2] = {"forces", "torques"};
  maker k = {.sweeps = sweeps, .count = count, .arena = arena};
  km_text label = {0};
  const km_model *model = sweeps[0].swept.mechanism->model;
  if (!gather(&k))
    return false;
  km_text_add(&label, k.torques && !k.forces ? "actuator torque (" : "actuator force (");
  if (k.forces)
    km_text_add(&label, model->units.force->suffix);
  km_text_add(&label, k.forces && k.torques ? ", " : "");
  if (k.torques)
    km_torque_unit(model, &label);
  km_text_add(&label, ")");
  km_sweep_picture picture = {.title = "What the actuators hold",
                              .note = k.mark_count ? "▲ a force vanishes or has no bound" : NULL,
                              .y_label = km_text_move_to_arena(&label, arena),
                              .sweeps = k.swept,
                              .sweep_count = count,
                              .ordered = ordered,
                              .lines = k.lines,
                              .line_count = k.line_count,
                              .marks = k.marks,
                              .mark_count = k.mark_count,
                              .breaks = k.breaks,
                              .break_count = k.break_count,
                              .panels = k.forces && k.torques ? both : NULL,
                              .panel_count = k.forces && k.torques ? 2 : 1,
                              .strip = strip};
  return !arena->failed && km_sweep_plot_make(&picture, arena, out);
}
