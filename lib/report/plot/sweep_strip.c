/* Small drawings of poses beneath a plot. */
#include "report/plot/sweep_strip.h"

#include "base/text.h"
#include "kmech/kinematics.h"
#include "report/drawing/drawing.h"
#include "report/plot/palette.h"
#include "report/plot/short_names.h"

#include <string.h>

static const double strip_height = 132, caption_height = 14, margin = 10; /* points */
enum { MOST_BODIES = 60 };

void km_row_pose(const km_mechanism *m, const km_table *table, size_t row, km_state *state, double *q, km_pose *poses) {
  const double *values = km_table_row(table, row) + km_table_span(table, "q.").first;
  for (int c = 0; c < m->coordinate_count; ++c)
    q[c] = values[c] * km_model_coordinate_factor(m->model, c);
  km_state_set(m, state, q);
  km_poses_update(m, state);
  memcpy(poses, state->pose, (size_t)m->topology.body_count * sizeof *poses);
}

/* The value matters: a long name gives way to it. */
static const char *caption(const km_swept *sweep, double s, km_arena *arena) {
  enum { LONGEST_NAME = 12 }; /* bytes */
  const char *label = km_model_coordinate_label(sweep->mechanism->model, sweep->plan->coordinate);
  const char *unit = km_model_coordinate_unit(sweep->mechanism->model, sweep->plan->coordinate);
  km_text text = {0};
  if (sweep->plan->arclength > 0.0)
    km_text_format(&text, "arc length %.4g", s);
  else if (strlen(label) > LONGEST_NAME)
    km_text_format(&text, "%.4g %s", s, unit);
  else
    km_text_format(&text, "%s = %.4g %s", label, s, unit);
  return km_text_keep(&text, arena);
}

static void draw(void *context, km_canvas *canvas, double top, double width) {
  const km_sweep_strip *strip = context;
  const km_font font = {.size = 8, .width = width / strip->count};
  double each = (width - 2 * margin) / strip->count;
  for (int k = 0; k < strip->count; ++k) {
    const km_strip_picture *picture = &strip->pictures[k];
    const km_drawing drawing = {.mechanism = picture->mechanism,
                                .poses = picture->poses,
                                .pose_count = picture->pose_count,
                                .full = picture->full,
                                .alone = true,
                                .bare = true};
    double left = margin + k * each;
    /* A pose that can't be drawn leaves its place empty. */
    const km_rectangle place = {left + 8, top, each - 16, strip_height - caption_height - margin};
    if (km_drawing_place(&drawing, canvas, place, NULL) == KM_MEMORY)
      km_canvas_fail(canvas);
    km_canvas_text(canvas, &font, km_palette_text(picture->colour), picture->caption,
                   (km_canvas_point){left + each / 2, top + strip_height - margin}, (km_anchor){0.5, 1, 0});
  }
}

static bool fits(const km_swept *sweep) {
  int bodies = sweep->mechanism->topology.body_count;
  return bodies >= 2 && bodies <= MOST_BODIES && km_table_rows(sweep->motion->table) > 0;
}

/* The poses of some rows of a sweep; NULL when out of memory. */
static km_pose *poses_of(const km_swept *sweep, const size_t *rows, int count, km_arena *arena) {
  const km_mechanism *m = sweep->mechanism;
  size_t bodies = (size_t)m->topology.body_count;
  double *q = KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count);
  km_pose *poses = KM_ARENA_NEW(arena, km_pose, (size_t)count * bodies);
  km_state *state = NULL;
  arena->failed = arena->failed || km_state_create(m, &state, NULL);
  for (int k = 0; k < count && !arena->failed; ++k)
    km_row_pose(m, sweep->motion->table, rows[k], state, q, poses + (size_t)k * bodies);
  km_state_free(state);
  return arena->failed ? NULL : poses;
}

km_plot_strip km_sweep_strip_make(const km_swept *sweep, int count, km_arena *arena, km_sweep_strip *out) {
  const km_table *table = sweep->motion->table;
  size_t rows[KM_MOST_STRIP_POSES] = {0};
  *out = (km_sweep_strip){.count = count};
  if (!fits(sweep))
    return (km_plot_strip){0};
  for (int k = 0; k < count; ++k)
    rows[k] = k + 1 == count ? km_table_rows(table) - 1 : (size_t)k * km_table_rows(table) / (size_t)(count - 1);
  const km_pose *poses = poses_of(sweep, rows, count, arena);
  for (int k = 0; k < count && poses; ++k)
    out->pictures[k] =
        (km_strip_picture){sweep->mechanism,
                           poses,
                           (size_t)count,
                           (size_t)k,
                           caption(sweep, km_table_row(table, rows[k])[km_table_find(table, "s")], arena),
                           -1};
  return poses && !arena->failed ? (km_plot_strip){strip_height, draw, out} : (km_plot_strip){0};
}

km_plot_strip km_comparison_strip_make(const km_swept *sweeps, int count, bool ordered, km_arena *arena,
                                       km_sweep_strip *out) {
  int shown = count < KM_MOST_STRIP_POSES ? count : KM_MOST_STRIP_POSES;
  const char **names = km_short_names_of(&sweeps[0].name, sizeof *sweeps, count, arena);
  *out = (km_sweep_strip){.count = shown};
  for (int k = 0; k < shown && names; ++k) {
    int i = k * (count - 1) / (shown > 1 ? shown - 1 : 1);
    if (!fits(&sweeps[i]))
      return (km_plot_strip){0};
    const size_t middle = km_table_rows(sweeps[i].motion->table) / 2;
    out->pictures[k] = (km_strip_picture){sweeps[i].mechanism,
                                          poses_of(&sweeps[i], &middle, 1, arena),
                                          1,
                                          0,
                                          names[i],
                                          km_palette_compared(i, count, ordered)};
  }
  return arena->failed ? (km_plot_strip){0} : (km_plot_strip){strip_height, draw, out};
}
