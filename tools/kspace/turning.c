/* kspace turning: dead points of a driver over one number of the design. */
#include "kspace/kspace.h"
#include "kspace/turning_answer.h"

#include "common/command_line/vary.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/space.h"

#include <math.h>
#include <string.h>

static const double same_turn = 1e-9; /* part of a turn that is rounding */

typedef struct options {
  kt_common common;
  kt_texts holds, sets, vary;
  const char *model, *joint, *format;
  kspace_files files;
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

/* Full turns of a hinge's values, so that they are within half a turn of 0 in the middle of their range. */
static double middle_turns(double low, double high, double turn) {
  return turn > 0.0 ? turn * ceil((0.5 * (low + high) - 0.5 * turn) / turn - same_turn) : 0.0;
}

/* Copies rows first to last - 1, and a row without values, which interrupts the line. */
static bool add_curve(const km_table *curves, size_t first, size_t last, size_t driver, double turn, km_table *out) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  size_t width = km_table_columns(curves);
  for (size_t r = first; r < last; ++r) {
    low = fmin(low, km_table_row(curves, r)[driver]);
    high = fmax(high, km_table_row(curves, r)[driver]);
  }
  double turns = middle_turns(low, high, turn);
  for (size_t r = first; r < last; ++r) {
    double *cells = km_table_add_row(out);
    if (!cells)
      return false;
    memcpy(cells, km_table_row(curves, r), width * sizeof *cells);
    cells[driver] -= turns;
  }
  return km_table_add_row(out) != NULL;
}

/* The curves one by one, each within about half a turn of 0. NULL when out of memory. */
static km_table *separate_curves(const km_table *curves, size_t driver, double turn) {
  km_table *out = km_table_create();
  bool is_ok = out != NULL;
  for (size_t c = 0; is_ok && c < km_table_columns(curves); ++c)
    is_ok = km_table_add_column(out, km_table_name(curves, c), km_table_unit(curves, c)) >= 0;
  for (size_t first = 0, last; is_ok && first < km_table_rows(curves); first = last) {
    last = first + 1;
    while (last < km_table_rows(curves) && km_table_row(curves, last)[0] == km_table_row(curves, first)[0])
      ++last;
    is_ok = add_curve(curves, first, last, driver, turn, out);
  }
  if (is_ok)
    return out;
  km_table_free(out);
  return NULL;
}

typedef struct turning_answer {
  const options *o;
  const kt_pose *pose;
  const km_turning_def *def;
  km_turning turning;
} turning_answer;

static kt_exit write_picture(const turning_answer *a, kt_format format) {
  const options *o = a->o;
  const km_model *model = a->pose->model;
  const km_turning_def *def = a->def;
  km_text out = {0};
  km_error error = {0};
  km_chart *chart = NULL;
  const size_t y = 3 + (size_t)def->driver;
  bool is_angle = !km_model_coordinate_is_length(model, def->driver);
  km_table *lines =
      separate_curves(a->turning.curves, y, is_angle ? 2.0 * M_PI / km_model_units(model).angle->si : 0.0);
  km_text label = {0};
  km_text_format(&label, "%s (as in the file)", def->path);
  if (!lines || label.failed) {
    km_table_free(lines);
    km_text_free(&label);
    return KT_NO_MEMORY;
  }
  const km_plotted_table plotted = {lines, "dead points", 1, &y};
  const char *name = km_model_coordinate_label(model, def->driver);
  const km_chart_words words = {.title = "Dead points", .x_label = label.data, .names = &name};
  km_status status = km_table_chart_worded(&plotted, 1, 1, &words, &chart, &error);
  if (!status)
    status = km_chart_picture(chart, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  else
    result = kt_write(&o->common, o->files.base, "turning", kt_format_word(format), &out);
  km_chart_free(chart);
  km_table_free(lines);
  km_text_free(&label);
  km_text_free(&out);
  return result;
}

static kt_exit write_format(const void *context, kt_format format, const km_text *record) {
  const turning_answer *a = context;
  const kt_common *common = &a->o->common;
  if (format == KT_CSV)
    return kspace_write_csv(common, a->o->files.base, a->turning.curves, "turning");
  if (format == KT_JSON)
    return kt_write(common, a->o->files.base, "turning", "json", record);
  if (a->turning.curve_count > 0)
    return write_picture(a, format);
  kt_print_message(common, KM_NOTE, "%s: no picture: there is no dead point%s", a->o->model,
                   a->turning.is_stopped ? " so far" : "");
  return KT_DONE;
}

static const km_value *record_turning(const void *context, km_arena *arena) {
  const turning_answer *a = context;
  return kspace_turning_record(a->pose, a->def, &a->turning, arena);
}

static void print_turning(const void *context, km_text *out) {
  const turning_answer *a = context;
  kspace_print_turning(a->pose->model, a->def, &a->turning, out);
}

static kt_exit run(const options *o, const kt_pose *pose, const km_turning_def *def) {
  turning_answer a = {.o = o, .pose = pose, .def = def};
  const kspace_answer forms = {&a, record_turning, print_turning, write_format};
  km_error error;
  kt_progress progress = kt_progress_start(&o->common);
  kt_interrupts_catch();
  km_status status =
      km_turning_find(pose->mechanism, pose->state, def, kt_progress_show, &progress, &a.turning, &error);
  kt_interrupts_release();
  kt_progress_end(&progress);
  bool is_stopped = status == KM_CANCELLED && kt_is_interrupted();
  if (status)
    kt_print_message(&o->common, is_stopped ? KM_NOTE : KM_ERROR, "%s: %s%s", o->model, error.text,
                     is_stopped ? "; the answer has the curves found so far" : "");
  kt_exit result = status && !is_stopped ? kt_exit_of(status) : kspace_deliver(&o->common, &o->files, &forms);
  if (result == KT_DONE && (!a.turning.is_complete || a.turning.is_stopped))
    result = KT_PARTIAL;
  km_turning_free(&a.turning);
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
      {"format", 0, "FORMATS",
       "Files to write: some of csv,json,svg,pdf,png (with -o, unless stated: csv,svg); json without -o: a record in place of the text",
       KT_TEXT_OF("csv or json or svg or pdf or png"), &o.format, KT_ABOUT_FILES},
      KT_BASE(
          &o.files.base,
          "Write the curves to BASE.turning.csv and a plot to BASE.turning.svg (default where --format states a file: the model's name)"),
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
      "Columns of the table: curve, number, critical (0: none, 1: crossing, 2: isolated, 3: cusp), q. of each joint. JSON "
      "keys beside those of every record: driver, number, from, to, complete, reason (as that of modes, or refused: the modes can't be listed), modes, intervals (from, to, motion: turns, "
      "swings, endless, not found, not assembled, not defined; low, high, dead_points), critical_values (number, driver, "
      "kind, curve), curves, and the table's columns and rows. Exit status 1: the list of assembly modes may lack some, and so the curves; or Ctrl-C ended the work: "
      "the curves and critical values found so far are written. Other numbers of "
      "freedoms than one are refused.",
      argc, argv);
  kt_pose pose = {0};
  kt_variants variants = {0};
  km_turning_def def;
  kt_exit result = kspace_read_formats(&o.common, o.format, "csv,json,svg,pdf,png", o.model, &o.files)
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
