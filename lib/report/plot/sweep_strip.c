/* Small drawings of poses over a sweep, beneath its plot. */
#include "report/plot/sweep_strip.h"

#include "kmech/kinematics.h"
#include "report/drawing/drawing.h"
#include "report/plot/palette.h"

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
static void caption(const km_sweep_strip *strip, int k, km_text *out) {
  enum { LONGEST_NAME = 12 }; /* bytes */
  if (strip->plan->arclength > 0.0) {
    km_text_format(out, "arc length %.4g", strip->s[k]);
    return;
  }
  const char *label = km_model_coordinate_label(strip->mechanism->model, strip->plan->coordinate);
  const char *unit = km_model_coordinate_unit(strip->mechanism->model, strip->plan->coordinate);
  if (strlen(label) > LONGEST_NAME)
    km_text_format(out, "%.4g %s", strip->s[k], unit);
  else
    km_text_format(out, "%s = %.4g %s", label, strip->s[k], unit);
}

static void draw(void *context, km_canvas *canvas, double top, double width) {
  const km_sweep_strip *strip = context;
  const km_font font = {.size = 8, .width = width / strip->count};
  double each = (width - 2 * margin) / strip->count;
  km_drawing drawing = {.mechanism = strip->mechanism,
                        .poses = strip->poses,
                        .pose_count = (size_t)strip->count,
                        .alone = true,
                        .bare = true};
  for (int k = 0; k < strip->count; ++k) {
    km_text text = {0};
    double left = margin + k * each;
    drawing.full = (size_t)k;
    /* A pose that can't be drawn leaves its place empty. */
    const km_rectangle place = {left + 8, top, each - 16, strip_height - caption_height - margin};
    if (km_drawing_place(&drawing, canvas, place, NULL) == KM_MEMORY)
      km_canvas_fail(canvas);
    caption(strip, k, &text);
    km_canvas_words(canvas, &font, km_palette_text(-1), &text,
                    (km_canvas_point){left + each / 2, top + strip_height - margin}, (km_anchor){0.5, 1, 0});
  }
}

km_plot_strip km_sweep_strip_make(const km_mechanism *m, const km_sweep_plan *plan, const km_sweep *sweep, int count,
                                  km_arena *arena, km_sweep_strip *out) {
  size_t bodies = (size_t)m->topology.body_count, rows = km_table_rows(sweep->table);
  *out = (km_sweep_strip){m, plan, count, NULL, {0}};
  if (bodies < 2 || bodies > MOST_BODIES || rows == 0)
    return (km_plot_strip){0};
  km_state *state = NULL;
  double *q = KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count);
  out->poses = KM_ARENA_NEW(arena, km_pose, (size_t)count * bodies);
  arena->failed = arena->failed || km_state_create(m, &state, NULL);
  if (arena->failed)
    return (km_plot_strip){0};
  for (int k = 0; k < count; ++k) {
    size_t shown = k + 1 == count ? rows - 1 : (size_t)k * rows / (size_t)(count - 1);
    out->s[k] = km_table_row(sweep->table, shown)[km_table_find(sweep->table, "s")];
    km_row_pose(m, sweep->table, shown, state, q, out->poses + (size_t)k * bodies);
  }
  km_state_free(state);
  return (km_plot_strip){strip_height, draw, out};
}
