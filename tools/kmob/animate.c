/* kmob draw --animate: the motion as a page that plays it, or as an animated picture. */
#include "kmob/draw.h"

#include "kmech/memory.h"
#include "kmech/mobility_sweep.h"
#include "kmech/version.h"
#include "report/document/film_page.h"
#include "report/drawing/film_drawing.h"
#include "report/plot/apng.h"
#include "report/plot/film_plot.h"
#include "report/plot/mobility_plot.h"
#include "report/plot/sweep_strip.h"
#include "kmech/records.h"

#include <math.h>

enum { PLANE_STEPS = 240, SPACE_STEPS = 120, PICTURES = 72 };
static const double plot_width = 300, plot_height = 236; /* points: letters fit a phone */
static const double picture_width = 360;                 /* points: a few megabytes in all */
static const double seconds = 4; /* from one end of the motion to the other: 60 pictures a second in a plane */

typedef struct animation {
  kmob_shots *shots;
  const km_drawing *drawing;
  km_sweep_plan plan;
  km_mobility_sweep sweep;
  km_arena arena;
  double *values; /* [frame] of the driver */
  km_film film, curves;
} animation;

static kt_exit fail(const animation *a, km_status status, const km_error *error) {
  if (status)
    kt_say(&a->shots->options->common, KM_ERROR, "%s: %s", a->shots->options->path, error->text);
  return kt_exit_of(status);
}

static bool moves_in_plane(const animation *a) {
  const km_mechanism *m = a->shots->pose.mechanism;
  const km_drawing look = {
      .mechanism = m, .poses = a->shots->pose.state->pose, .pose_count = 1, .view = a->drawing->view};
  km_poses_update(m, a->shots->pose.state);
  return km_drawing_is_planar(&look);
}

static kt_exit run_sweep(animation *a) {
  const kmob_shots *s = a->shots;
  kt_exit result = kmob_shots_plan(s, &a->plan);
  km_error error;
  if (result != KT_DONE)
    return result;
  if (!kt_asked_given(&s->options->asked, "steps") && !(a->plan.arclength > 0.0))
    a->plan.steps = moves_in_plane(a) ? PLANE_STEPS : SPACE_STEPS;
  km_status status = km_mobility_sweep_run(s->pose.mechanism, s->pose.state, &a->plan, &a->sweep, &error);
  if (status != KM_PARTIAL)
    return fail(a, status, &error);
  km_text why = {0};
  km_sweep_stop_text(s->pose.mechanism, &a->plan, &a->sweep.motion, &why);
  kt_say(&s->options->common, KM_ERROR, "%s: %s", s->options->path,
         why.size ? why.data : "a part of the motion is out of reach");
  km_text_free(&why);
  return KT_PARTIAL;
}

static bool has_rows(const animation *a) {
  return a->sweep.motion.table && km_table_rows(a->sweep.motion.table) > 0;
}

/* The bodies' poses and the points' paths at every row. */
static km_status take_frames(animation *a, km_error *error) {
  kmob_shots *s = a->shots;
  const km_table *table = a->sweep.motion.table;
  const km_mechanism *m = s->pose.mechanism;
  size_t rows = km_table_rows(table), bodies = (size_t)m->model->body_count;
  double *q = KM_ARENA_NEW(&a->arena, double, (size_t)m->coordinate_count + 1);
  a->values = KM_ARENA_NEW(&a->arena, double, rows);
  s->poses = KM_NEW(km_pose, rows * bodies);
  km_state *state = NULL;
  if (a->arena.failed || !s->poses)
    return km_fail(error, KM_MEMORY, "out of memory for a motion");
  km_status status = km_state_create(m, &state, error);
  for (size_t r = 0; r < rows && !status; ++r) {
    km_row_pose(m, table, r, state, q, s->poses + r * bodies);
    a->values[r] = km_table_row(table, r)[km_table_find(table, "s")];
    for (size_t t = 0; t < s->trace_count; ++t) {
      const km_model_frame *frame = &m->model->frames[s->traces[t].frame];
      s->paths[t][r] = km_pose_point(&s->poses[r * bodies + (size_t)frame->body], frame->pose.p);
      s->traces[t].count = r + 1;
    }
  }
  km_state_free(state);
  s->count = rows;
  return status;
}

static bool same_pose(const km_pose *a, const km_pose *b, double length) {
  double apart = km_vec3_norm(km_vec3_sub(a->p, b->p)) / length;
  for (int k = 0; k < 3; ++k)
    apart = fmax(apart, km_vec3_norm(km_vec3_sub(a->R.axis[k], b->R.axis[k])));
  return apart < 1e-6;
}

/* Whether every body comes back to where it began. */
static bool comes_round(const animation *a) {
  const kmob_shots *s = a->shots;
  size_t bodies = (size_t)s->pose.model->body_count;
  for (size_t b = 0; b < bodies; ++b)
    if (!same_pose(&s->poses[b], &s->poses[(s->count - 1) * bodies + b], s->pose.mechanism->length))
      return false;
  return s->count > 2;
}

/* Between which frames the driver has a value, and where between. */
static double frame_of(const animation *a, double value) {
  for (size_t f = 1; f < a->shots->count; ++f) {
    double from = a->values[f - 1], to = a->values[f];
    if (from != to && (value - from) * (value - to) <= 0.0)
      return (double)(f - 1) + (value - from) / (to - from);
  }
  return 0.0;
}

static const char *unit_of(const animation *a) {
  return a->plan.arclength > 0.0 ? "" : km_model_coordinate_unit(a->shots->pose.model, a->plan.coordinate);
}

static const char *quantity_of(const animation *a) {
  return a->plan.arclength > 0.0 ? "arc length" : km_model_coordinate_label(a->shots->pose.model, a->plan.coordinate);
}

static void add_stop(animation *a, km_film_page *page, km_film_stop *stops, const char *what, double value) {
  km_text name = {0};
  km_text_format(&name, "%s at %.5g%s%s", what, value, *unit_of(a) ? " " : "", unit_of(a));
  stops[page->stop_count++] =
      (km_film_stop){frame_of(a, value), name.failed ? "" : km_arena_string(&a->arena, name.data)};
  km_text_free(&name);
}

static void add_stops(animation *a, km_film_page *page) {
  const km_model *model = a->shots->pose.model;
  km_film_stop *stops = KM_ARENA_NEW(&a->arena, km_film_stop, a->sweep.toggle_count + a->sweep.motion.branch_count + 1);
  page->stops = stops;
  for (size_t i = 0; i < a->sweep.toggle_count && stops; ++i) {
    km_text what = {0};
    km_text_format(&what, "%s loses its grip", km_model_coordinate_label(model, a->sweep.toggles[i].coordinate));
    add_stop(a, page, stops, what.failed ? "" : what.data, a->sweep.toggles[i].s);
    km_text_free(&what);
  }
  for (size_t i = 0; i < a->sweep.motion.branch_count && stops; ++i)
    add_stop(a, page, stops, "branch point", a->sweep.motion.branches[i].s);
}

static const char *subtitle_of(animation *a) {
  km_text text = {0};
  const char *unit = unit_of(a);
  km_text_format(&text, "%s from %.5g to %.5g%s%s · mobility %d", quantity_of(a), a->values[0],
                 a->values[a->shots->count - 1], *unit ? " " : "", unit, a->sweep.motion.first.mobility);
  for (size_t t = 0; t < a->shots->trace_count; ++t)
    km_text_format(&text, "%s%s", t ? ", " : " · path of ", a->shots->traces[t].name);
  const char *kept = text.failed ? NULL : km_arena_string(&a->arena, text.data);
  km_text_free(&text);
  return kept ? kept : "";
}

static km_status make_films(animation *a, km_error *error) {
  const kmob_shots *s = a->shots;
  km_drawing drawing = *a->drawing;
  const km_plotted_sweep plotted = {s->pose.mechanism, &a->plan, &a->sweep, s->name, NULL, 0};
  km_plot plot;
  kmob_shots_show(s, &drawing);
  km_status status = km_drawing_film(&drawing, &a->arena, &a->film, error);
  if (status)
    return status;
  if (!km_mobility_plot_make(&plotted, 1, false, &a->arena, &plot))
    return km_fail(error, KM_MEMORY, "out of memory for the plot");
  plot.title = plot.subtitle = NULL; /* the page has them */
  return km_plot_film(&plot, plot_width, plot_height, s->count, &a->arena, &a->curves, error);
}

static km_status write_page(animation *a, km_text *out, km_error *error) {
  static const char *const alt[] = {"the mechanism in motion", "mobility numbers of its joints over the motion"};
  const km_film *films[] = {&a->film, &a->curves};
  km_status status = make_films(a, error);
  if (!status) {
    km_film_page page = {.title = a->shots->name,
                         .subtitle = subtitle_of(a),
                         .footer = "kmech " KM_VERSION " · kmob draw --animate",
                         .films = films,
                         .alt = alt,
                         .film_count = 2,
                         .quantity = quantity_of(a),
                         .unit = unit_of(a),
                         .values = a->values,
                         .closed = comes_round(a),
                         .seconds = seconds};
    add_stops(a, &page);
    status =
        a->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a page") : km_film_page_write(&page, out, error);
  }
  km_film_close(&a->film);
  km_film_close(&a->curves);
  return status;
}

/* One picture of the drawing. */
static km_status add_picture(km_drawing *drawing, size_t frame, km_apng *apng, km_error *error) {
  km_text png = {0};
  drawing->full = frame;
  km_status status = km_drawing_render(drawing, KM_CANVAS_PNG, &png, error);
  if (!status)
    status = km_apng_add(apng, &png, error);
  km_text_free(&png);
  return status;
}

/* Every picture that the screen can follow; forth and back, unless the motion goes round. */
static km_status write_pictures(animation *a, km_text *out, km_error *error) {
  size_t count = a->shots->count, stride = (count - 1) / PICTURES + 1, kept = (count - 1) / stride + 1;
  bool closed = comes_round(a);
  size_t frames = closed ? kept - 1 : kept > 1 ? 2 * kept - 2 : 1;
  km_apng apng = {.out = out, .frames = (unsigned)frames};
  km_drawing drawing = *a->drawing;
  km_status status = KM_OK;
  apng.milliseconds = (unsigned)lround(1000 * seconds / (double)kept);
  kmob_shots_show(a->shots, &drawing);
  drawing.alone = drawing.steady = drawing.bare = true; /* names would jump from picture to picture */
  drawing.title = subtitle_of(a);
  if (drawing.width <= 0.0)
    drawing.width = picture_width;
  for (size_t f = 0; f < frames && !status; ++f)
    status = add_picture(&drawing, (f < kept ? f : 2 * kept - 2 - f) * stride, &apng, error);
  return status;
}

static kt_exit write_format(animation *a, kt_format format) {
  const kmob_draw_options *o = a->shots->options;
  km_text out = {0};
  km_error error;
  km_status status = format == KT_HTML ? write_page(a, &out, &error) : write_pictures(a, &out, &error);
  kt_exit result = fail(a, status, &error);
  if (!status)
    result = kt_write(&o->common, o->base ? o->base : a->shots->name, "motion", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

kt_exit kmob_animate(kmob_shots *shots, const km_drawing *drawing) {
  animation a = {.shots = shots, .drawing = drawing};
  km_error error;
  kt_exit result = run_sweep(&a);
  if (result <= KT_PARTIAL && has_rows(&a)) {
    result = kt_worse(result, kmob_shots_traces(shots, km_table_rows(a.sweep.motion.table)));
    if (result <= KT_PARTIAL)
      result = kt_worse(result, fail(&a, take_frames(&a, &error), &error));
    for (int f = KT_HTML; f <= KT_APNG && result <= KT_PARTIAL; ++f)
      if (shots->options->formats.wanted[f])
        result = kt_worse(result, write_format(&a, (kt_format)f));
  }
  km_mobility_sweep_free(&a.sweep);
  km_arena_free(&a.arena);
  return result;
}
