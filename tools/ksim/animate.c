/* ksim run --animate: the motion as a page that plays it beside its curves. */
#include "ksim/ksim.h"

#include "kinematics/poses.h"
#include "kmech/memory.h"
#include "kmech/version.h"
#include "report/document/film_page.h"
#include "report/drawing/film_drawing.h"
#include "report/plot/film_plot.h"
#include "report/plot/history_plot.h"
#include "report/plot/sweep_strip.h"

enum { MOST_FRAMES = 600 };
static const double plot_width = 300, panel_height = 118; /* points: letters fit a phone */

typedef struct animation {
  const ksim_work *work;
  km_arena arena;
  km_table *table; /* the rows that are frames */
  km_pose *poses;
  double *times;
  size_t frames;
  km_film film, curves;
} animation;

static km_table *thinned(const km_table *from, size_t stride) {
  km_table *out = km_table_create();
  bool good = out != NULL;
  for (size_t c = 0; good && c < km_table_columns(from); ++c)
    good = km_table_add_column(out, km_table_name(from, c), km_table_unit(from, c)) >= 0;
  for (size_t r = 0; good && r < km_table_rows(from); r += stride) {
    double *row = km_table_add_row(out);
    good = row != NULL;
    for (size_t c = 0; good && c < km_table_columns(from); ++c)
      row[c] = km_table_row(from, r)[c];
  }
  if (good)
    return out;
  km_table_free(out);
  return NULL;
}

static km_status take_frames(animation *a, km_error *error) {
  const km_table *all = a->work->history.table;
  const km_mechanism *m = a->work->pose.mechanism;
  size_t stride = (km_table_rows(all) - 1) / MOST_FRAMES + 1, bodies = (size_t)m->model->body_count;
  a->table = thinned(all, stride);
  a->frames = a->table ? km_table_rows(a->table) : 0;
  a->poses = KM_ARENA_NEW(&a->arena, km_pose, a->frames * bodies + 1);
  a->times = KM_ARENA_NEW(&a->arena, double, a->frames + 1);
  double *q = KM_ARENA_NEW(&a->arena, double, (size_t)m->coordinate_count + 1);
  if (!a->table || a->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for a motion");
  km_state *state = NULL;
  km_status status = km_state_create(m, &state, error);
  for (size_t f = 0; f < a->frames && !status; ++f) {
    km_row_pose(m, a->table, f, state, q, a->poses + f * bodies);
    a->times[f] = km_table_row(a->table, f)[0];
  }
  km_state_free(state);
  return status;
}

static km_status make_films(animation *a, km_error *error) {
  const ksim_work *w = a->work;
  const km_drawing drawing = {.mechanism = w->pose.mechanism, .poses = a->poses, .pose_count = a->frames};
  km_plot plot;
  km_status status = km_drawing_film(&drawing, &a->arena, &a->film, error);
  if (!status && !ksim_plot_make(w, a->table, &a->arena, &plot))
    status = km_fail(error, KM_MEMORY, "out of memory for the plot");
  if (status)
    return status;
  plot.title = plot.subtitle = NULL; /* the page has them, and the motion itself */
  plot.strip = (km_plot_strip){0};
  return km_plot_film(&plot, plot_width, panel_height * (double)plot.panel_count, a->frames, &a->arena, &a->curves,
                      error);
}

static km_status write_page(animation *a, km_text *out, km_error *error) {
  static const char *const alt[] = {"the mechanism in motion", "its coordinates, rates and energies over time"};
  const ksim_work *w = a->work;
  const km_film *films[] = {&a->film, &a->curves};
  const km_model *model = w->pose.model;
  km_status status = make_films(a, error);
  if (!status) {
    km_film_page page = {.title = w->name,
                         .subtitle = "motion over time",
                         .footer = "kmech " KM_VERSION " · ksim run --animate",
                         .films = films,
                         .alt = alt,
                         .film_count = 2,
                         .quantity = "time",
                         .unit = model->units.time->suffix,
                         .values = a->times,
                         .closed = true, /* it doesn't run backwards */
                         .seconds = (a->times[a->frames - 1] - a->times[0]) * model->units.time->si};
    status = km_film_page_write(&page, out, error);
  }
  km_film_close(&a->film);
  km_film_close(&a->curves);
  return status;
}

kt_exit ksim_animate(const ksim_work *w, const char *base) {
  animation a = {.work = w};
  km_text out = {0};
  km_error error;
  km_status status = take_frames(&a, &error);
  if (!status)
    status = write_page(&a, &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&w->options->common, KM_ERROR, "%s: %s", w->options->model, error.text);
  else
    result = kt_write(&w->options->common, base, "motion", "html", &out);
  km_text_free(&out);
  km_table_free(a.table);
  km_arena_free(&a.arena);
  return result;
}
