/* kmob draw --animate: the motion as a page that plays it, or as an animated picture. */
#include "kmob/draw.h"

#include "kmech/base.h"
#include "kmech/report.h"
#include "kmech/sweep.h"
#include "kmech/version.h"

enum { PLANE_STEPS = 240, SPACE_STEPS = 120 };
static const double seconds = 4; /* frames from one end of the motion to the other: 60 per second in a plane */

typedef struct animation {
  kmob_shots *shots;
  km_question *question; /* mobility question with its answer */
  km_sweep_plan plan;
  const km_mobility_sweep *sweep;
  km_arena arena;
  double *values; /* [row] of the driver */
  size_t rows;
} animation;

static kt_exit fail(const animation *a, km_status status, const km_error *error) {
  if (status)
    kt_print_message(&a->shots->options->common, KM_ERROR, "%s: %s", a->shots->options->path, error->text);
  return kt_exit_of(status);
}

static bool moves_in_plane(const animation *a) {
  const kt_pose *pose = &a->shots->pose;
  km_drawing *look;
  km_poses_compute(pose->mechanism, pose->state);
  bool planar = !km_drawing_create(pose->mechanism, &look, NULL) &&
                !km_drawing_add_pose(look, pose->mechanism, pose->state, NULL) &&
                km_drawing_is_planar(look, a->shots->options->look.view);
  km_drawing_free(look);
  return planar;
}

/* As many rows as the screen can follow, unless the options say how many. */
static km_status choose_steps(const animation *a, km_error *error) {
  const km_option_value steps = {.whole = moves_in_plane(a) ? PLANE_STEPS : SPACE_STEPS};
  if (kt_question_given(&a->shots->options->asked, "steps") || a->plan.arclength > 0.0)
    return KM_OK;
  return km_question_set(a->question, "steps", &steps, error);
}

static kt_exit run_sweep(animation *a) {
  const kmob_shots *s = a->shots;
  kt_exit result = kmob_shots_question(s, &a->question, &a->plan);
  km_error error;
  if (result != KT_DONE)
    return result;
  km_status status = choose_steps(a, &error);
  if (!status)
    status = km_question_compute(a->question, s->pose.state, &error);
  a->sweep = km_question_mobility(a->question);
  if (status != KM_PARTIAL)
    return fail(a, status, &error);
  km_text why = {0};
  km_sweep_stop_text(s->pose.mechanism, &a->plan, &a->sweep->motion, &why);
  kt_print_message(&s->options->common, KM_ERROR, "%s: %s", s->options->path,
                   why.size ? why.data : "a part of the motion is out of reach");
  km_text_free(&why);
  return KT_PARTIAL;
}

/* The driver's values, the bodies' poses and the points' paths at every row. */
static km_status copy_rows(animation *a, km_error *error) {
  const km_table *table = km_question_table(a->question);
  a->values = KM_ARENA_NEW(&a->arena, double, a->rows);
  if (!a->values)
    return km_fail(error, KM_MEMORY, "out of memory for a motion");
  km_status status = km_table_column(table, (size_t)km_table_find(table, "s"), a->values, error);
  return status ? status : km_drawing_add_rows(a->shots->drawing, table, error);
}

/* Between which rows the driver has a value, and where between. */
static double row_of(const animation *a, double value) {
  for (size_t r = 1; r < a->rows; ++r) {
    double from = a->values[r - 1], to = a->values[r];
    if (from != to && (value - from) * (value - to) <= 0.0)
      return (double)(r - 1) + (value - from) / (to - from);
  }
  return 0.0;
}

static const char *unit_of(const animation *a) {
  return a->plan.arclength > 0.0 ? "" : km_model_coordinate_unit(a->shots->pose.model, a->plan.coordinate);
}

static const char *quantity_of(const animation *a) {
  return a->plan.arclength > 0.0 ? "arc length" : km_model_coordinate_label(a->shots->pose.model, a->plan.coordinate);
}

static void add_stop(animation *a, km_motion_page *page, km_motion_stop *stops, const char *what, double value) {
  km_text name = {0};
  km_text_format(&name, "%s at %.5g%s%s", what, value, *unit_of(a) ? " " : "", unit_of(a));
  stops[page->stop_count++] = (km_motion_stop){row_of(a, value), km_text_move_to_arena(&name, &a->arena)};
}

static void add_stops(animation *a, km_motion_page *page) {
  const km_model *model = a->shots->pose.model;
  km_motion_stop *stops =
      KM_ARENA_NEW(&a->arena, km_motion_stop, a->sweep->toggle_count + a->sweep->motion.branch_count + 1);
  page->stops = stops;
  for (size_t i = 0; i < a->sweep->toggle_count && stops; ++i) {
    km_text what = {0};
    km_text_format(&what, "dead point of %s", km_model_coordinate_label(model, a->sweep->toggles[i].coordinate));
    a->arena.failed = a->arena.failed || what.failed;
    add_stop(a, page, stops, what.failed ? "" : what.data, a->sweep->toggles[i].s);
    km_text_free(&what);
  }
  for (size_t i = 0; i < a->sweep->motion.branch_count && stops; ++i)
    add_stop(a, page, stops, "branch point", a->sweep->motion.branches[i].s);
}

static const char *subtitle_of(animation *a) {
  const kt_texts *traces = &a->shots->options->traces;
  km_text text = {0};
  const char *unit = unit_of(a);
  km_text_format(&text, "%s from %.5g to %.5g%s%s · mobility %d", quantity_of(a), a->values[0], a->values[a->rows - 1],
                 *unit ? " " : "", unit, a->sweep->motion.first.mobility);
  for (int t = 0; t < traces->count; ++t)
    km_text_format(&text, "%s%s", t ? ", " : " · path of ", traces->items[t]);
  return km_text_move_to_arena(&text, &a->arena);
}

static km_status write_page(animation *a, km_text *out, km_error *error) {
  const km_drawing_look look = kmob_shots_style(a->shots);
  const km_answered answer = {a->question, a->shots->name, NULL, 0, NULL};
  km_chart *chart = NULL;
  km_motion_page page = {.title = a->shots->name,
                         .subtitle = subtitle_of(a),
                         .footer = "kmech " KM_VERSION " · kmob draw --animate",
                         .quantity = quantity_of(a),
                         .unit = unit_of(a),
                         .values = a->values,
                         .closed = km_drawing_comes_round(a->shots->drawing),
                         .seconds = seconds,
                         .chart_alt = "mobility numbers of its joints over the motion"};
  add_stops(a, &page);
  km_status status = a->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a page")
                                     : km_question_chart(&(km_comparison){&answer, 1, false}, &chart, error);
  page.chart = chart;
  if (!status)
    status = km_drawing_page(a->shots->drawing, &look, &page, out, error);
  km_chart_free(chart);
  return status;
}

static km_status write_pictures(animation *a, km_text *out, km_error *error) {
  km_drawing_look look = kmob_shots_style(a->shots);
  look.title = subtitle_of(a);
  return km_drawing_apng(a->shots->drawing, &look, seconds, out, error);
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

kt_exit kmob_animate(kmob_shots *shots) {
  animation a = {.shots = shots};
  km_error error;
  kt_exit result = run_sweep(&a);
  a.rows = a.sweep ? km_table_rows(km_question_table(a.question)) : 0;
  if (result <= KT_PARTIAL && a.rows > 0) {
    result = kt_worse(result, kmob_shots_paths(shots));
    if (result <= KT_PARTIAL)
      result = kt_worse(result, fail(&a, copy_rows(&a, &error), &error));
    for (int f = KT_HTML; f <= KT_APNG && result <= KT_PARTIAL; ++f)
      if (shots->options->formats.wanted[f])
        result = kt_worse(result, write_format(&a, (kt_format)f));
  }
  km_question_free(a.question);
  km_arena_free(&a.arena);
  return result;
}
