/* Pictures of tracks: a page of plots over the path, and the arm along it. */
#include "report/charts/track_plot.h"

#include "report/charts/chart.h"

#include "kinematics/body_poses.h"
#include "report/drawing/drawing.h"
#include "report/plot/plot.h"

#include <stdio.h>
#include <string.h>

enum { ACROSS = 2, MOST_SERIES = KM_ARM_MAX_JOINTS + 1 };
static const km_colour ink = {0.15, 0.15, 0.15, 1}, grey = {0.40, 0.40, 0.40, 1};
static const double cell_width = 400, cell_height = 230, head = 58, margin = 14;

typedef struct sheet {
  const km_tracks *tracks;
  km_arena *arena;
  int first; /* the track whose joints are shown */
  char x_label[80];
  struct {
    char title[120], y_label[120];
    km_plot_series series[MOST_SERIES];
    size_t count;
    double y_low, y_high;
  } plots[KM_TRACK_PLOTS];
  size_t plot_count;
} sheet;

static double *column(sheet *s, const km_table *table, int index, double factor, double offset) {
  size_t rows = km_table_rows(table);
  double *out = KM_ARENA_NEW(s->arena, double, rows);
  for (size_t r = 0; out && r < rows; ++r)
    out[r] = factor * (km_table_row(table, r)[index] - offset);
  return out;
}

/* Column of a joint of the arm among those of a kind. */
static int column_of(const km_track *t, const char *prefix, int joint) {
  return (int)km_table_span(t->table, prefix).first + joint;
}

static void begin(sheet *s, const char *title, const char *y_label, double low, double high) {
  snprintf(s->plots[s->plot_count].title, sizeof s->plots->title, "%s", title);
  snprintf(s->plots[s->plot_count].y_label, sizeof s->plots->y_label, "%s", y_label);
  s->plots[s->plot_count].y_low = low;
  s->plots[s->plot_count].y_high = high;
}

static void add(sheet *s, const km_table *table, int index, double factor, double offset, const char *name) {
  size_t at = s->plots[s->plot_count].count;
  if (at == MOST_SERIES || index < 0)
    return;
  const double *x = column(s, table, km_table_find(table, "s"), 1.0, 0.0), *y = column(s, table, index, factor, offset);
  if (!x || !y)
    return;
  s->plots[s->plot_count].series[at] = (km_plot_series){.name = km_arena_string(s->arena, name),
                                                        .x = x,
                                                        .y = y,
                                                        .count = km_table_rows(table),
                                                        .colour = (int)at,
                                                        .dash = at == 0 ? 0 : (int)at};
  s->plots[s->plot_count].count++;
}

/* Joint angles, and where they are between their limits. */
static void add_joints(sheet *s, const km_track *t, bool diagnostics) {
  const km_arm *a = t->arm;
  char text[120];
  snprintf(text, sizeof text, "q (%s)", km_model_coordinate_unit(a->mechanism->model, a->coordinate[0]));
  begin(s, "Joint angles", text, 0.0, 0.0);
  for (int k = 0; k < a->n; ++k)
    add(s, t->table, column_of(t, "q.", k), 1.0, 0.0, km_arm_label(a, k));
  s->plot_count++;
  begin(s, "Between the limits", "-1 low limit … 1 high limit", -1.0, 1.0);
  for (int k = 0; k < a->n; ++k) {
    double half = 0.5 * (a->high[k] - a->low[k]), middle = a->low[k] + half;
    if (half < (double)INFINITY)
      add(s, t->table, column_of(t, "q.", k), 1.0 / km_arm_to_units(a, k, half), km_arm_to_units(a, k, middle),
          km_arm_label(a, k));
  }
  s->plot_count += s->plots[s->plot_count].count > 0;
  if (!diagnostics)
    return;
  begin(s, "Path-control column", "entries of c1", 0.0, 0.0);
  for (int k = 0; k <= a->n; ++k)
    add(s, t->table, column_of(t, "z.", k), 1.0, 0.0, k < a->n ? km_arm_label(a, k) : "path");
  s->plot_count++;
}

/* One column of every track. */
static void add_all(sheet *s, const char *title, const char *y_label, const char *name, double low, double high) {
  begin(s, title, y_label, low, high);
  for (int i = 0; i < s->tracks->count; ++i) {
    char label[64];
    const km_track *t = s->tracks->items[i];
    if (!t || km_table_rows(t->table) == 0)
      continue;
    km_tracks_label(s->tracks, i, ' ', label, sizeof label);
    add(s, t->table, km_table_find(t->table, name), 1.0, 0.0, label);
  }
  s->plot_count++;
}

/* The fastest joint of every track. */
static void add_speeds(sheet *s) {
  begin(s, "Fastest joint", "largest |v| (rad/s, slides over L)", 0.0, 0.0);
  for (int i = 0; i < s->tracks->count; ++i) {
    char label[64];
    const km_track *t = s->tracks->items[i];
    if (!t || km_table_rows(t->table) == 0)
      continue;
    km_tracks_label(s->tracks, i, ' ', label, sizeof label);
    size_t at = s->plots[s->plot_count].count;
    add(s, t->table, column_of(t, "v.", 0), 1.0, 0.0, label);
    if (s->plots[s->plot_count].count == at)
      continue;
    double *y = (double *)(size_t)s->plots[s->plot_count].series[at].y; /* made by add, ours to fill */
    for (size_t r = 0; r < km_table_rows(t->table); ++r) {
      y[r] = 0.0;
      for (int k = 0; k < t->arm->n; ++k)
        y[r] = fmax(y[r], fabs(km_arm_from_units(t->arm, k, km_table_row(t->table, r)[column_of(t, "v.", k)])));
    }
  }
  s->plot_count++;
}

static void gather(sheet *s, bool diagnostics) {
  const km_track *t = s->tracks->items[s->first];
  const char *unit = t->arm->mechanism->model->units.length->suffix, *name = km_objective_name(&t->plan.objective);
  char text[120], column_name[80];
  snprintf(s->x_label, sizeof s->x_label, "s: travel, and turns times L (%s)", unit);
  add_joints(s, t, diagnostics);
  if (strcmp(name, "manipulability") != 0) {
    snprintf(column_name, sizeof column_name, "objective.%s", name);
    snprintf(text, sizeof text, "Objective: %s", name);
    add_all(s, text, name, column_name, 0.0, 0.0);
  }
  add_all(s, "Manipulability", "product of singular values", "objective.manipulability", 0.0, 0.0);
  add_all(s, "Limit margin", "nearest limit / half range", "limit_margin", 0.0, 1.0);
  snprintf(text, sizeof text, "position error (%s)", unit);
  add_speeds(s);
  if (diagnostics)
    add_all(s, "Tracking error", text, "error_position", 0.0, 0.0);
}

static void fill_plots(const sheet *s, km_arena *arena, km_plot *out) {
  for (size_t i = 0; i < s->plot_count; ++i) {
    km_plot_panel *panel = KM_ARENA_NEW(arena, km_plot_panel, 1);
    if (!panel)
      return;
    *panel = (km_plot_panel){.series = s->plots[i].series, .series_count = s->plots[i].count};
    out[i] = (km_plot){.title = s->plots[i].title,
                       .x_label = s->x_label,
                       .y_label = s->plots[i].y_label,
                       .y_low = s->plots[i].y_low,
                       .y_high = s->plots[i].y_high,
                       .panels = panel,
                       .panel_count = 1};
  }
}

size_t km_tracks_plots_make(const km_tracks *tracks, bool diagnostics, km_arena *arena, km_plot *out) {
  sheet *s = KM_ARENA_NEW(arena, sheet, 1);
  if (!s)
    return 0;
  s->tracks = tracks;
  s->arena = arena;
  s->first = km_tracks_best(tracks);
  gather(s, diagnostics);
  fill_plots(s, arena, out);
  return arena->failed ? 0 : s->plot_count;
}

static km_status draw_plots(const km_plot *plots, size_t count, km_canvas *canvas, km_error *error) {
  km_status status = KM_OK;
  for (size_t i = 0; i < count && !status; ++i) {
    double x = cell_width * (double)(i % ACROSS), y = head + cell_height * (double)(i / ACROSS);
    km_canvas_shift(canvas, x, y);
    status = km_plot_place(&plots[i], canvas, cell_width, cell_height, error);
    km_canvas_shift(canvas, -x, -y);
  }
  return status;
}

static void draw_head(const km_tracks *tracks, km_canvas *canvas) {
  int first = km_tracks_best(tracks);
  const km_track *t = tracks->items[first];
  const km_font title = {.size = 15, .bold = true, .width = ACROSS * cell_width - 2 * margin};
  const km_font subtitle = {.size = 9.5, .width = ACROSS * cell_width - 2 * margin};
  char label[64];
  km_text about = {0};
  km_tracks_label(tracks, first, ' ', label, sizeof label);
  const km_units *units = &t->arm->mechanism->model->units;
  km_text_format(&about, "%s · %s, %s · L = %g %s · joints of the %s track · %s", tracks->model, units->angle->word,
                 units->length->word, t->arm->length, units->length->suffix, label,
                 t->end.stop ? "the path isn't followed to its end" : "the whole path is followed");
  km_canvas_text(canvas, &title, ink, "Along the effector's path", (km_canvas_point){margin, margin},
                 (km_anchor){0, 0, 0});
  km_canvas_words(canvas, &subtitle, grey, &about, (km_canvas_point){margin, margin + 21}, (km_anchor){0, 0, 0});
}

km_status km_check_tracks(const km_tracks *tracks, bool some, km_picture_format format, const km_text *out,
                          km_error *error) {
  km_status status = km_check_picture(out, format, error);
  if (!status && !km_tracks_are_whole(tracks))
    status = km_fail(error, KM_USAGE, "found no tracks of a study with a path");
  if (status || !some)
    return status;
  int best = km_tracks_best(tracks);
  bool any = best >= 0 && km_table_rows(tracks->items[best]->table) > 0;
  return any ? KM_OK : km_fail(error, KM_USAGE, "there is no track to draw");
}

km_status km_tracks_picture(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error) {
  km_status given = km_check_tracks(tracks, true, format, out, error);
  if (given)
    return given;
  km_arena arena = {0};
  km_canvas *canvas = NULL;
  km_plot plots[KM_TRACK_PLOTS];
  size_t count = km_tracks_plots_make(tracks, true, &arena, plots), down = (count + ACROSS - 1) / ACROSS;
  km_status status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a plot")
                                  : km_canvas_create(format, ACROSS * cell_width, head + cell_height * (double)down,
                                                     out, &canvas, error);
  if (!status) {
    draw_head(tracks, canvas);
    status = draw_plots(plots, count, canvas, error);
  }
  if (!status)
    status = km_canvas_finish(canvas, error);
  km_canvas_free(canvas);
  km_arena_free(&arena);
  return status;
}

/* The mechanism's bodies with the arm at a row of the track. */
static void pose_at(const km_track *t, km_state *state, size_t row, double *q, km_pose *poses) {
  const km_arm *a = t->arm;
  const km_mechanism *m = a->mechanism;
  const double *values = km_table_row(t->table, row) + column_of(t, "q.", 0);
  memcpy(q, m->start, (size_t)m->coordinate_count * sizeof *q);
  for (int k = 0; k < a->n; ++k)
    q[a->coordinate[k]] = km_arm_from_units(a, k, values[k]) * a->unit[k];
  km_state_set(m, state, q);
  km_poses_compute(m, state);
  memcpy(poses, state->pose, (size_t)m->topology.body_count * sizeof *poses);
}

size_t km_track_row(const km_track *t, size_t pose, size_t poses) {
  return poses > 1 ? pose * (km_table_rows(t->table) - 1) / (poses - 1) : 0;
}

/* Fills in the drawing with the state as workspace. False when out of memory. */
static bool make_drawing(const km_tracks *tracks, const km_track *t, size_t most, km_arena *arena, km_state *state,
                         km_drawing_def *out) {
  enum { TRACED = 300 };
  const km_mechanism *m = t->arm->mechanism;
  size_t rows = km_table_rows(t->table), bodies = (size_t)m->topology.body_count;
  size_t shown = rows < most ? rows : most, traced = rows < TRACED ? rows : TRACED;
  km_pose *poses = KM_ARENA_NEW(arena, km_pose, shown * bodies), *one = KM_ARENA_NEW(arena, km_pose, bodies);
  double *q = KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count);
  km_vec3 *points = KM_ARENA_NEW(arena, km_vec3, traced);
  km_drawing_trace *trace = KM_ARENA_NEW(arena, km_drawing_trace, 1);
  if (arena->failed)
    return false;
  for (size_t i = 0; i < shown; ++i)
    pose_at(t, state, km_track_row(t, i, shown), q, poses + i * bodies);
  for (size_t i = 0; i < traced; ++i) {
    double p[3];
    pose_at(t, state, km_track_row(t, i, traced), q, one);
    km_frame_position(m, state, t->arm->frame, p);
    points[i] = km_vec3_from_array(p);
  }
  *trace = (km_drawing_trace){t->arm->frame, m->model->frames[t->arm->frame].name, points, traced};
  *out = (km_drawing_def){
      .mechanism = m, .poses = poses, .pose_count = shown, .traces = trace, .trace_count = 1, .name = tracks->model};
  return true;
}

km_status km_tracks_drawing_make(const km_tracks *tracks, size_t poses, km_arena *arena, km_drawing_def *out,
                                 km_error *error) {
  const km_track *t = tracks->items[km_tracks_best(tracks)];
  km_state *state = NULL;
  km_status status = km_state_create(t->arm->mechanism, &state, error);
  if (!status && !make_drawing(tracks, t, poses, arena, state, out))
    status = km_fail(error, KM_MEMORY, "out of memory for a drawing");
  km_state_free(state);
  return status;
}

km_status km_tracks_drawing(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error) {
  km_status status = km_check_tracks(tracks, true, format, out, error);
  if (status)
    return status;
  km_arena arena = {0};
  km_drawing_def drawing = {0};
  status = km_tracks_drawing_make(tracks, KM_TRACK_POSES, &arena, &drawing, error);
  drawing.title = "The arm along the path";
  if (!status)
    status = km_drawing_render(&drawing, format, out, error);
  km_arena_free(&arena);
  return status;
}
