/* Small drawings of poses beneath a plot. */
#include "report/charts/sweep_strip.h"
#include "report/drawing/drawing_poses.h"

#include "base/text.h"
#include "kmech/mechanism.h"
#include "report/canvas/palette.h"
#include "report/drawing/drawing.h"
#include "report/plot/short_names.h"

#include <string.h>

static const double strip_height = 132, names_height = 12, caption_height = 14, margin = 10; /* points */
enum { MOST_BODIES = 60 };

/* Value of the driver under picture k. The first one has the driver's name, unless it is long: all of them would touch
 * each other on a narrow page. */
static const char *caption(const km_swept *sweep, int k, double s, km_arena *arena) {
  enum { LONGEST_NAME = 12 }; /* bytes */
  const char *label = km_model_coordinate_label(sweep->mechanism->model, sweep->plan->coordinate);
  const char *unit = km_model_coordinate_unit(sweep->mechanism->model, sweep->plan->coordinate);
  km_text text = {0};
  if (sweep->plan->arclength > 0.0)
    km_text_format(&text, k ? "%.4g" : "arc length %.4g", s);
  else if (k > 0 || strlen(label) > LONGEST_NAME)
    km_text_format(&text, "%.4g %s", s, unit);
  else
    km_text_format(&text, "%s = %.4g %s", label, s, unit);
  return km_text_move_to_arena(&text, arena);
}

/* One group of names, each after a dash in its colour; a name under a picture would seem to belong to that picture. */
static void draw_names(const km_sweep_strip *strip, km_canvas *canvas, double y, double width) {
  const double dash = 10, gap = 12;
  const km_font font = {.size = 8, .width = (width - 2 * margin) / strip->layers - dash - gap};
  double room[KM_MAX_STRIP_LAYERS], all = -gap;
  for (int k = 0; k < strip->layers; ++k) {
    room[k] = km_canvas_measure(canvas, &font, strip->names[k]).x + 1.5 * dash + gap;
    all += room[k];
  }
  double x = 0.5 * (width - all);
  for (int k = 0; k < strip->layers; x += room[k++]) {
    const km_pen pen = {.colour = km_palette_text(strip->colours[k]), .width = 1.6};
    km_canvas_line(canvas, &pen, (km_canvas_point){x, y - 0.4 * font.size},
                   (km_canvas_point){x + dash, y - 0.4 * font.size});
    km_canvas_text(canvas, &font, pen.colour, strip->names[k], (km_canvas_point){x + 1.5 * dash, y},
                   (km_anchor){0, 1, 0});
  }
}

static void draw(void *context, km_canvas *canvas, double top, double width) {
  const km_sweep_strip *strip = context;
  const km_font font = {.size = 8, .width = width / strip->count};
  double each = (width - 2 * margin) / strip->count;
  for (int k = 0; k < strip->count; ++k) {
    km_drawing_def layers[KM_MAX_STRIP_LAYERS];
    for (int i = 0; i < strip->layers; ++i) {
      layers[i] = strip->drawings[i];
      layers[i].full = (size_t)k;
    }
    double left = margin + k * each;
    /* A pose that can't be drawn leaves its place empty. */
    const km_rectangle place = {left + 8, top, each - 16, strip_height - caption_height - margin};
    km_status status = strip->names[0] ? km_drawing_overlay(layers, strip->colours, strip->layers, canvas, place, NULL)
                                       : km_drawing_place(&layers[0], canvas, place, NULL);
    if (status == KM_MEMORY)
      km_canvas_fail(canvas);
    km_canvas_text(canvas, &font, km_palette_text(-1), strip->captions[k],
                   (km_canvas_point){left + each / 2, top + strip_height - margin}, (km_anchor){0.5, 1, 0});
  }
  if (strip->names[0])
    draw_names(strip, canvas, top + strip_height + names_height - margin, width);
}

static bool fits(const km_mechanism *m, const km_table *table) {
  int bodies = m->topology.body_count;
  return bodies >= 2 && bodies <= MOST_BODIES && km_table_rows(table) > 0;
}

/* The poses of some rows; NULL when out of memory. */
static km_pose *poses_of(const km_mechanism *m, const km_table *table, const size_t *rows, int count, km_arena *arena) {
  size_t bodies = (size_t)m->topology.body_count;
  double *q = KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count);
  km_pose *poses = KM_ARENA_NEW(arena, km_pose, (size_t)count * bodies);
  km_state *state = NULL;
  arena->failed = arena->failed || km_state_create(m, &state, NULL);
  for (int k = 0; k < count && !arena->failed; ++k)
    km_row_pose(m, table, rows[k], state, q, poses + (size_t)k * bodies);
  km_state_free(state);
  return arena->failed ? NULL : poses;
}

static double s_of(const km_swept *sweep, size_t row) {
  const km_table *table = sweep->motion->table;
  return km_table_row(table, row)[km_table_find(table, "s")];
}

static km_drawing_def drawing_of(const km_mechanism *m, const km_table *table, const size_t *rows, int count,
                                 km_arena *arena) {
  return (km_drawing_def){.mechanism = m,
                          .poses = poses_of(m, table, rows, count, arena),
                          .pose_count = (size_t)count,
                          .alone = true,
                          .bare = true};
}

/* Row k of `count` evenly spaced ones, from the first to the last. */
static size_t spaced_row(const km_table *table, int k, int count) {
  return k + 1 == count ? km_table_rows(table) - 1 : (size_t)k * km_table_rows(table) / (size_t)(count - 1);
}

km_plot_strip km_sweep_strip_make(const km_swept *sweep, int count, km_arena *arena, km_sweep_strip *out) {
  const km_table *table = sweep->motion->table;
  size_t rows[KM_MAX_STRIP_POSES] = {0};
  *out = (km_sweep_strip){.count = count, .layers = 1};
  if (!fits(sweep->mechanism, table))
    return (km_plot_strip){0};
  for (int k = 0; k < count; ++k) {
    rows[k] = spaced_row(table, k, count);
    out->captions[k] = caption(sweep, k, s_of(sweep, rows[k]), arena);
  }
  out->drawings[0] = drawing_of(sweep->mechanism, table, rows, count, arena);
  return arena->failed ? (km_plot_strip){0} : (km_plot_strip){strip_height, draw, out};
}

/* True if a mechanism moves so far that pictures at one scale would be too small, by the positions of its bodies. */
static bool moves_far(const km_pose *poses, size_t bodies, int count) {
  static const double many = 6.0; /* times its size at first */
  double size = 0.0, way = 0.0;
  for (size_t b = 1; b < bodies; ++b) {
    size = fmax(size, km_vec3_norm(km_vec3_sub(poses[b].p, poses[1].p)));
    for (int k = 1; k < count; ++k)
      way = fmax(way, km_vec3_norm(km_vec3_sub(poses[(size_t)k * bodies + b].p, poses[b].p)));
  }
  return size > 0.0 && way > many * size;
}

km_plot_strip km_motion_strip_make(const km_mechanism *m, const km_table *table, int count, km_arena *arena,
                                   km_sweep_strip *out) {
  size_t rows[KM_MAX_STRIP_POSES] = {0};
  *out = (km_sweep_strip){.count = count, .layers = 1};
  if (!fits(m, table))
    return (km_plot_strip){0};
  for (int k = 0; k < count; ++k) {
    km_text text = {0};
    rows[k] = spaced_row(table, k, count);
    km_text_format(&text, "%.4g %s", km_table_row(table, rows[k])[0], m->model->units.time->suffix);
    out->captions[k] = km_text_move_to_arena(&text, arena);
  }
  out->drawings[0] = drawing_of(m, table, rows, count, arena);
  bool far = !arena->failed && moves_far(out->drawings[0].poses, (size_t)m->topology.body_count, count);
  return arena->failed || far ? (km_plot_strip){0} : (km_plot_strip){strip_height, draw, out};
}

/* End of the stroke shared by all, which begins where the first one does. NaN if the drivers differ. */
static double common_end(const km_swept *sweeps, int count) {
  const km_swept *first = &sweeps[0];
  const char *driver = km_model_coordinate_label(first->mechanism->model, first->plan->coordinate);
  double begin = s_of(first, 0), end = s_of(first, km_table_rows(first->motion->table) - 1);
  double sign = end < begin ? -1.0 : 1.0;
  for (int i = 0; i < count; ++i) {
    const km_model *model = sweeps[i].mechanism->model;
    double own = s_of(&sweeps[i], km_table_rows(sweeps[i].motion->table) - 1);
    end = sign * fmin(sign * end, sign * own);
    if (sweeps[i].plan->arclength > 0.0 ||
        strcmp(km_model_coordinate_label(model, sweeps[i].plan->coordinate), driver) != 0)
      return nan("");
  }
  return sign * (end - begin) > 0.0 ? end : nan("");
}

/* The row nearest to a value of the driver. */
static size_t row_at(const km_swept *sweep, double s) {
  size_t best = 0;
  for (size_t r = 1; r < km_table_rows(sweep->motion->table); ++r)
    if (fabs(s_of(sweep, r) - s) < fabs(s_of(sweep, best) - s))
      best = r;
  return best;
}

km_plot_strip km_comparison_strip_make(const km_swept *sweeps, int count, bool ordered, km_arena *arena,
                                       km_sweep_strip *out) {
  enum { POSES = 3 };
  static const char *const parts[POSES] = {"begin", "middle", "end"};
  int shown = count < KM_MAX_STRIP_LAYERS ? count : KM_MAX_STRIP_LAYERS;
  const char **names = km_short_names_of(&sweeps[0].name, sizeof *sweeps, count, arena);
  *out = (km_sweep_strip){.count = POSES, .layers = shown};
  for (int i = 0; i < count; ++i)
    if (!fits(sweeps[i].mechanism, sweeps[i].motion->table))
      return (km_plot_strip){0};
  double begin = s_of(&sweeps[0], 0), end = common_end(sweeps, count);
  for (int k = 0; k < POSES; ++k)
    out->captions[k] =
        isfinite(end) ? caption(&sweeps[0], k,
                                s_of(&sweeps[0], row_at(&sweeps[0], begin + k * (end - begin) / (POSES - 1))), arena)
                      : parts[k];
  for (int layer = 0; layer < shown && names; ++layer) {
    int i = layer * (count - 1) / (shown > 1 ? shown - 1 : 1);
    size_t rows[POSES], last = km_table_rows(sweeps[i].motion->table) - 1;
    for (int k = 0; k < POSES; ++k)
      rows[k] =
          isfinite(end) ? row_at(&sweeps[i], begin + k * (end - begin) / (POSES - 1)) : (size_t)k * last / (POSES - 1);
    out->drawings[layer] = drawing_of(sweeps[i].mechanism, sweeps[i].motion->table, rows, POSES, arena);
    out->names[layer] = names[i];
    out->colours[layer] = km_palette_compared(i, count, ordered);
  }
  return arena->failed ? (km_plot_strip){0} : (km_plot_strip){strip_height + names_height, draw, out};
}
