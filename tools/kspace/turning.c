/* kspace turning: dead points of a driver over one number of the design. */
#include "kspace/kspace.h"

#include "common/command_line/vary.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/space.h"

#include <math.h>
#include <string.h>

typedef struct options {
  kt_common common;
  kt_texts holds, sets, vary;
  const char *model, *joint, *base, *format; /* base: -o, or NULL */
  kt_formats formats;
} options;

/* The definition: driver and number. `variants` keeps the path. */
static kt_exit read_definition(const options *o, const km_model *model, kt_variants *variants, km_turning_def *def) {
  *def = (km_turning_def){.file = o->model, .seed = o->common.seed, .driver = km_model_sweep_coordinate(model)};
  kt_exit result = kt_variants_read(&o->common, &o->vary, KM_MAX_TURNING_STEPS + 1, variants);
  if (result == KT_DONE &&
      (variants->number_count != 1 || variants->count < 2 || !strchr(strrchr(o->vary.items[0], '='), ':') ||
       !(variants->numbers[0].values[0] < variants->numbers[0].values[variants->count - 1])))
    result = kt_usage(&o->common, "--vary", o->vary.count > 0 ? o->vary.items[0] : "is missing",
                      "one PATH=FROM:TO:N with FROM below TO and N at least 2");
  if (result == KT_DONE && o->joint)
    result = kt_coordinate(&o->common, model, "--joint", o->joint, &def->driver);
  if (result == KT_DONE && def->driver < 0)
    result = kt_usage(&o->common, "--joint", "is missing", "the driver: a hinge or slide of a loop");
  if (result == KT_DONE && kt_is_piped(o->model))
    result = kt_usage(&o->common, "MODEL", "-", "a file: the standard input can be read only once");
  if (result == KT_DONE) {
    def->path = variants->numbers[0].path;
    def->from = variants->numbers[0].values[0];
    def->to = variants->numbers[0].values[variants->count - 1];
    def->steps = variants->count - 1;
  }
  return result;
}

/* "A goes fully round for r up to 41.87"; nothing if it never does. */
static void print_turns(const km_turning *t, const km_turning_def *def, const char *driver, km_text *out) {
  bool is_first = true;
  for (int i = 0; i < t->interval_count; ++i) {
    if (!t->intervals[i].turns)
      continue;
    int first = i;
    while (i + 1 < t->interval_count && t->intervals[i + 1].turns)
      ++i;
    double from = t->intervals[first].from, to = t->intervals[i].to;
    if (is_first)
      km_text_format(out, "%s goes fully round for %s ", driver, def->path);
    km_text_add(out, is_first ? "" : " and ");
    if (first == 0 && i == t->interval_count - 1)
      km_text_format(out, "from %.6g to %.6g, the whole range", from, to);
    else if (first == 0)
      km_text_format(out, "below %.6g", to);
    else if (i == t->interval_count - 1)
      km_text_format(out, "above %.6g", from);
    else
      km_text_format(out, "from %.6g to %.6g", from, to);
    is_first = false;
  }
  if (is_first)
    km_text_format(out, "%s goes nowhere fully round for %s from %.6g to %.6g", driver, def->path, def->from, def->to);
  km_text_add(out, "\n");
}

static void print_interval(const km_turning_interval *at, const char *driver, const char *unit, km_text *out) {
  km_text_format(out, "  %.6g to %.6g: ", at->from, at->to);
  if (!at->is_defined)
    km_text_add(out, "the model can't be read with these numbers");
  else if (!at->is_assembled)
    km_text_add(out, "the circuit of the drawing is not there");
  else if (at->turns)
    km_text_format(out, "%s goes round", driver);
  else if (isfinite(at->low) && isfinite(at->high))
    km_text_format(out, "%s swings, at %.6g from %.6g to %.6g %s", driver, 0.5 * (at->from + at->to), at->low, at->high,
                   unit);
  else
    km_text_format(out, isnan(at->low) ? "the swing of %s was not found" : "%s moves without end", driver);
  if (at->is_defined)
    km_text_format(out, "; %d dead point%s in all circuits", at->dead_points, at->dead_points == 1 ? "" : "s");
  km_text_add(out, "\n");
}

static void print_critical(const km_turning_point *point, const km_turning_def *def, const char *driver,
                           const char *unit, km_text *out) {
  static const char *const words[] = {"", "two motions cross: circuits join or part",
                                      "an isolated configuration: a circuit appears or vanishes",
                                      "two dead points meet: the circuits stay"};
  double angle = fabs(point->driver) < 1e-6 ? 0.0 : point->driver; /* digits beyond are rounding */
  km_text_format(out, "  %s = %.10g with %s at %.6g %s: %s\n", def->path, point->number, driver, angle, unit,
                 words[point->kind]);
}

static void print_turning(const options *o, const km_model *model, const km_turning_def *def, const km_turning *t,
                          km_text *out) {
  const char *driver = km_model_coordinate_label(model, def->driver);
  const char *unit = km_model_coordinate_unit(model, def->driver);
  km_text_format(out, "%s: ", o->model);
  if (km_model_coordinate_is_length(model, def->driver))
    km_text_format(out, "dead points of %s for %s from %.6g to %.6g\n", driver, def->path, def->from, def->to);
  else
    print_turns(t, def, driver, out);
  for (int i = 0; i < t->interval_count; ++i)
    print_interval(&t->intervals[i], driver, unit, out);
  km_text_format(out, "%d critical value%s of %s\n", t->point_count, t->point_count == 1 ? "" : "s", def->path);
  for (int i = 0; i < t->point_count; ++i)
    print_critical(&t->points[i], def, driver, unit, out);
  km_text_format(out, "%d curve%s of dead points, %zu points, from the circuits of %d assembly mode%s%s\n",
                 t->curve_count, t->curve_count == 1 ? "" : "s", km_table_rows(t->curves), t->modes,
                 t->modes == 1 ? "" : "s", t->is_complete ? "" : " (at least these)");
}

/* The curves with a row without values between two of them, which interrupts the line. NULL when out of memory. */
static km_table *separate_curves(const km_table *curves) {
  km_table *out = km_table_create();
  size_t width = km_table_columns(curves);
  bool is_ok = out != NULL;
  for (size_t c = 0; is_ok && c < width; ++c)
    is_ok = km_table_add_column(out, km_table_name(curves, c), km_table_unit(curves, c)) >= 0;
  for (size_t r = 0; is_ok && r < km_table_rows(curves); ++r) {
    const double *row = km_table_row(curves, r);
    if (r > 0 && km_table_row(curves, r - 1)[0] != row[0])
      is_ok = km_table_add_row(out) != NULL;
    double *cells = is_ok ? km_table_add_row(out) : NULL;
    is_ok = cells != NULL;
    if (is_ok)
      memcpy(cells, row, width * sizeof *cells);
  }
  if (is_ok)
    return out;
  km_table_free(out);
  return NULL;
}

static kt_exit write_picture(const options *o, const km_model *model, const km_turning_def *def, const km_turning *t,
                             kt_format format) {
  km_text out = {0};
  km_error error = {0};
  km_chart *chart = NULL;
  km_table *lines = separate_curves(t->curves);
  if (!lines)
    return KT_NO_MEMORY;
  const size_t y = 3 + (size_t)def->driver;
  const km_plotted_table plotted = {lines, "dead points", 1, &y};
  const char *name = km_model_coordinate_label(model, def->driver);
  const km_chart_words words = {.title = "Dead points", .x_label = def->path, .names = &name};
  km_status status = km_table_chart_worded(&plotted, 1, 1, &words, &chart, &error);
  if (!status)
    status = km_chart_picture(chart, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  else
    result = kt_write(&o->common, o->base, "turning", kt_format_word(format), &out);
  km_chart_free(chart);
  km_table_free(lines);
  km_text_free(&out);
  return result;
}

static kt_exit write_files(const options *o, const km_model *model, const km_turning_def *def, const km_turning *t) {
  kt_exit result = KT_DONE;
  for (int format = 0; result == KT_DONE && format < KT_FORMATS; ++format) {
    if (!o->formats.wanted[format])
      continue;
    if (format == KT_CSV)
      result = kspace_write_csv(&o->common, o->base, t->curves, "turning");
    else if (t->curve_count > 0)
      result = write_picture(o, model, def, t, (kt_format)format);
    else
      kt_print_message(&o->common, KM_NOTE, "%s: no picture: there is no dead point", o->model);
  }
  return result;
}

static kt_exit run(const options *o, const kt_pose *pose, const km_turning_def *def) {
  km_turning turning = {0};
  km_error error;
  km_text out = {0};
  kt_progress progress = kt_progress_start(&o->common);
  km_status status = km_turning_find(pose->mechanism, pose->state, def, kt_progress_show, &progress, &turning, &error);
  kt_progress_end(&progress);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  kt_exit result = kt_exit_of(status);
  if (result == KT_DONE && o->base)
    result = write_files(o, pose->model, def, &turning);
  if (result == KT_DONE) {
    print_turning(o, pose->model, def, &turning, &out);
    result = kt_print(&o->common, &out);
  }
  if (result == KT_DONE && !turning.is_complete)
    result = KT_PARTIAL;
  km_text_free(&out);
  km_turning_free(&turning);
  return result;
}

kt_exit kspace_turning(int argc, char **argv) {
  options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      {"joint", 0, "JOINT", "The driver, unless it is that of analysis.sweep", KT_TEXT, &o.joint, KT_ABOUT_MODEL},
      {"vary", 0, "PATH=FROM:TO:N",
       "The number of the design: a parameter, or a number by its path such as crank.tip.x; circuits are followed at N "
       "values from FROM to TO",
       KT_TEXTS, &o.vary, KT_ABOUT_MODEL},
      KT_SET(&o.sets, "Start from another pose: move a joint to a value"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      {"format", 0, "FORMATS", "Some of csv,svg,pdf,png (default csv,svg)", KT_TEXT_OF("csv or svg or pdf or png"),
       &o.format, KT_ABOUT_FILES},
      KT_BASE(&o.base, "Write the curves to BASE.turning.csv and a plot to BASE.turning.svg"),
  };
  KT_OPTIONS_ADD(&all, own);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_common_options(&all, &o.common, KT_USES_FLOAT | KT_USES_SEED);
  kt_options_read(
      &all,
      "Where a driver goes fully round, and where it swings between dead points, over one number of the design: a "
      "length, an angle, a parameter. The critical values between are located."
      "\vThe dead points of the driver are curves over the configurations and the number. They are followed from the dead "
      "points of each circuit at N values of the number; critical values are the extrema of the number on them. There two "
      "motions cross, a circuit appears or vanishes, or two dead points meet. What is said of an interval was found in "
      "its middle, on the circuit of the pose. A circuit that is at none of the N values is not found. Limits are ignored. "
      "Columns of the table: curve, number, critical (0: none, 1: crossing, 2: isolated, 3: cusp), q. of each joint. Exit "
      "status 1: the list of assembly modes may lack some, and so the curves. Ball joints, redundant conditions and more "
      "freedoms are refused.",
      argc, argv);
  kt_pose pose = {0};
  kt_variants variants = {0};
  km_turning_def def;
  kt_exit result = kt_formats_parse_among(&o.common, o.format ? o.format : "csv,svg", "csv,svg,pdf,png", &o.formats)
                       ? kt_open(&o.common, o.model, &o.holds, &o.sets, &pose)
                       : KT_USAGE;
  if (result == KT_DONE)
    result = read_definition(&o, pose.model, &variants, &def);
  if (result == KT_DONE)
    result = run(&o, &pose, &def);
  kt_variants_free(&variants);
  kt_close(&pose);
  return result;
}
