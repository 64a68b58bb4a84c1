/* kspace path: a path between two configurations without a singularity of the drivers. */
#include "kspace/kspace.h"
#include "kspace/path_answer.h"
#include "kspace/played_model.h"

#include "kmech/clearance.h"
#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/space.h"

#include <math.h>
#include <string.h>

typedef struct options {
  kt_common common;
  kt_texts holds, joints;
  const char *model, *from, *to, *margin, *clearance, *time, *format;
  int ignores_limits;
  kspace_files files;
} options;

static void free_texts(kt_texts *texts) {
  for (int i = 0; i < texts->count; ++i)
    km_free(texts->items[i]);
}

/* Splits JOINT=VALUE,JOINT=VALUE. Free the texts in any case. */
static kt_exit split_settings(const options *o, const char *text, kt_texts *out) {
  const char *rest = text;
  for (bool more = true; more;) {
    kt_piece piece = kt_split(&rest, ",");
    more = piece.separator == ',';
    if (!piece.text)
      return KT_NO_MEMORY;
    if (out->count == KT_MOST_TEXTS) {
      km_free(piece.text);
      return kt_usage(&o->common, "JOINT=VALUE", text, "fewer joints");
    }
    out->items[out->count++] = piece.text;
  }
  return KT_DONE;
}

/* Opens the model at a named pose, or at JOINT=VALUE,JOINT=VALUE; NULL: its own pose. */
static kt_exit open_at(const options *o, const char *place, kt_pose *pose) {
  kt_common common = o->common;
  kt_texts sets = {0};
  kt_exit result = KT_DONE;
  *pose = (kt_pose){0};
  if (place && strchr(place, '='))
    result = split_settings(o, place, &sets);
  else
    common.pose = place;
  if (result == KT_DONE)
    result = kt_open(&common, o->model, &o->holds, &sets, pose);
  free_texts(&sets);
  return result;
}

/* The drivers: --joint, else the model's analysis.actuators. */
static kt_exit read_drivers(const options *o, const km_model *model, int *drivers, int *count) {
  int actuators = km_model_actuator_count(model), given = o->joints.count;
  *count = given > 0 ? given : actuators;
  if (*count < 1 || *count > KM_MAX_PATH_DRIVERS)
    return kt_usage(&o->common, "--joint", given > 0 ? o->joints.items[0] : "is missing",
                    "the drivers: --joint for each, at most 6, or joints in the model's analysis.actuators");
  kt_exit result = KT_DONE;
  for (int d = 0; result == KT_DONE && d < *count; ++d)
    if (given > 0)
      result = kt_coordinate(&o->common, model, "--joint", o->joints.items[d], &drivers[d]);
    else
      drivers[d] = km_model_actuator(model, d);
  return result;
}

/* ---- The clearance of bodies along the path. */

typedef struct kept_clearance {
  km_clearance *clearance;
  km_pair_clearance *pairs; /* [pair] workspace */
  double least;
} kept_clearance;

static bool keeps_clearance(void *context, const km_mechanism *mechanism, const km_state *state) {
  const kept_clearance *kept = context;
  int nearest;
  (void)mechanism;
  return km_clearance_compute(kept->clearance, state, kept->pairs, &nearest, NULL) == KM_OK &&
         kept->pairs[nearest].distance >= kept->least;
}

/* Prepares the condition of --clearance. Free the clearance and the pairs in any case. */
static kt_exit read_clearance(const options *o, const kt_pose *pose, kept_clearance *out) {
  *out = (kept_clearance){0};
  kt_exit result = kspace_read_clearance(&o->common, o->clearance, o->model, pose, &out->clearance, &out->least);
  out->pairs = KM_NEW(km_pair_clearance, (size_t)km_clearance_pair_count(out->clearance) + 1);
  return result || out->pairs ? result : KT_NO_MEMORY;
}

/* ---- Files. */

/* The drivers over the length of the path. */
static kt_exit write_picture(const options *o, const km_space_path *path, int drivers, kt_format format) {
  km_text out = {0};
  km_error error;
  km_chart *chart = NULL;
  size_t y[KM_MAX_PATH_DRIVERS];
  for (size_t i = 0; i < KM_MAX_PATH_DRIVERS; ++i)
    y[i] = i + 1;
  const km_plotted_table plotted = {path->table, o->model, 0, y};
  const km_chart_words words = {.title = "Path of the drivers", .x_label = "length of the path"};
  km_status status = km_table_chart_worded(&plotted, 1, drivers, &words, &chart, &error);
  if (!status)
    status = km_chart_picture(chart, kt_picture_format(format), &out, &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  kt_exit result =
      status ? kt_exit_of(status) : kt_write(&o->common, o->files.base, "path", kt_format_word(format), &out);
  km_chart_free(chart);
  km_text_free(&out);
  return result;
}

typedef struct path_forms {
  const options *o;
  const kspace_path_answer *answer;
  double time;
} path_forms;

static bool has_explored(const kspace_path_answer *a) {
  return km_table_rows(a->path.explored) > 0;
}

static kt_exit write_format(const void *context, kt_format format, const km_text *record) {
  const path_forms *f = context;
  const options *o = f->o;
  const kspace_path_answer *a = f->answer;
  (void)record; /* the file is the model that plays the path */
  if (a->path.outcome != KM_SPACE_PATH_FOUND)
    return format == KT_CSV && has_explored(a)
               ? kspace_write_csv(&o->common, o->files.base, a->path.explored, "explored")
               : KT_DONE;
  if (format == KT_CSV)
    return kspace_write_csv(&o->common, o->files.base, a->path.table, "path");
  if (format != KT_JSON)
    return write_picture(o, &a->path, a->driver_count, format);
  if (o->from || o->holds.count > 0)
    kt_print_message(
        &o->common, KM_NOTE,
        "%s: --from and --hold are not in %s.path.json: give ksim inverse the same pose by --pose or --set, "
        "and --hold",
        o->model, o->files.base);
  return kspace_write_played_model(&o->common, o->model, a->pose->model, a->path.motion, a->drivers, a->driver_count,
                                   f->time, o->files.base);
}

/* A note where files are stated and there is none, since there is no path. */
static void note_no_file(const options *o, const kspace_path_answer *a) {
  if (o->files.base && !(has_explored(a) && o->files.formats.wanted[KT_CSV]))
    kt_print_message(&o->common, KM_NOTE, "%s: no file: there is no path%s", o->model,
                     has_explored(a) ? "; --format csv writes the configurations that were explored" : "");
}

static const km_value *record_path(const void *context, km_arena *arena) {
  return kspace_path_record(((const path_forms *)context)->answer, arena);
}

static void print_path(const void *context, km_text *out) {
  kspace_print_path(((const path_forms *)context)->answer, out);
}

/* The values of all drivers at the end, from JOINT=VALUE,… */
static kt_exit read_end(const options *o, const km_model *model, const int *drivers, int count, double *values) {
  static const char expected[] = "a pose that the model names, or JOINT=VALUE,JOINT=VALUE for each driver";
  kt_settings settings = {0};
  kt_texts texts = {0};
  kt_exit result = split_settings(o, o->to, &texts);
  if (result == KT_DONE)
    result = kt_settings_add(&o->common, model, "--to", texts.items, texts.count, &settings);
  int found = 0;
  for (int i = 0; i < settings.count; ++i)
    for (int d = 0; d < count; ++d)
      if (settings.items[i].coordinate == drivers[d]) {
        values[d] = settings.items[i].value;
        ++found;
      }
  if (result == KT_DONE && (found != count || settings.count != count))
    result = kt_usage(&o->common, "--to", o->to, expected);
  kt_settings_free(&settings);
  free_texts(&texts);
  return result;
}

/* Reads the numbers of options. */
static kt_exit read_numbers(const options *o, double *margin, double *time) {
  *margin = KM_DEFAULT_PATH_MARGIN;
  *time = 1.0;
  if (o->margin && (!kt_number(o->margin, margin) || !(*margin > 0.0)))
    return kt_usage(&o->common, "--margin", o->margin, "a positive number");
  if (o->time && (!kt_number(o->time, time) || !(*time > 0.0)))
    return kt_usage(&o->common, "--time", o->time, "a positive number");
  return KT_DONE;
}

/* Searches for the path to a pose, or, without one, to values of the drivers. */
static kt_exit find_path(const options *o, const kt_pose *to, const double *values, kept_clearance *kept,
                         kspace_path_answer *a) {
  const kt_pose *from = a->pose;
  km_error error;
  double *end = KM_NEW(double, (size_t)km_model_coordinate_count(from->model) + 1);
  if (!end)
    return KT_NO_MEMORY;
  km_status status = to->model ? km_state_coordinates(to->mechanism, to->state, end, &error) : KM_OK;
  const km_space_path_def def = {.drivers = a->drivers,
                                 .driver_count = a->driver_count,
                                 .to = to->model ? end : NULL,
                                 .to_drivers = values,
                                 .margin = a->margin,
                                 .ignore_limits = o->ignores_limits,
                                 .seed = o->common.seed,
                                 .condition = kept->clearance ? keeps_clearance : NULL,
                                 .context = kept};
  kt_progress progress = kt_progress_start(&o->common);
  kt_interrupts_catch();
  if (!status)
    status = km_space_path_find(from->mechanism, from->state, &def, kt_progress_show, &progress, &a->path, &error);
  kt_interrupts_release();
  kt_progress_end(&progress);
  km_free(end);
  if (status == KM_CANCELLED && kt_is_interrupted())
    return KT_DONE; /* the answer says so */
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  return kt_exit_of(status);
}

static kt_exit run(const options *o, const kt_pose *from, const kt_pose *to) {
  kspace_path_answer a = {.pose = from, .model = o->model, .has_free_end = !to->model};
  double values[KM_MAX_PATH_DRIVERS];
  path_forms context = {.o = o, .answer = &a, .time = 1.0};
  const kspace_answer forms = {&context, record_path, print_path, write_format};
  kept_clearance kept = {0};
  kt_exit result = read_drivers(o, from->model, a.drivers, &a.driver_count);
  if (result == KT_DONE)
    result = read_numbers(o, &a.margin, &context.time);
  if (result == KT_DONE && !to->model)
    result = read_end(o, from->model, a.drivers, a.driver_count, values);
  if (result == KT_DONE)
    result = read_clearance(o, from, &kept);
  if (result == KT_DONE)
    result = find_path(o, to, values, &kept, &a);
  if (result == KT_DONE)
    result = kspace_deliver(&o->common, &o->files, &forms);
  if (result == KT_DONE && a.path.outcome != KM_SPACE_PATH_FOUND) {
    note_no_file(o, &a);
    result = KT_PARTIAL;
  }
  km_space_path_free(&a.path);
  km_clearance_free(kept.clearance);
  km_free(kept.pairs);
  return result;
}

kt_exit kspace_path(int argc, char **argv) {
  options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      {"from", 0, "POSE",
       "Start: a pose that the model names, or JOINT=VALUE,JOINT=VALUE (default: the model's own pose)", KT_TEXT,
       &o.from, KT_ABOUT_MODEL},
      {"to", 0, "POSE", "End: a pose that the model names, or JOINT=VALUE for each driver, in any assembly mode",
       KT_TEXT, &o.to, KT_ABOUT_MODEL},
      {"joint", 0, "JOINT", "A driver; given for each freedom (default: the model's analysis.actuators)", KT_TEXTS,
       &o.joints, KT_ABOUT_MODEL},
      {"margin", 0, "X", "Least smallest singular value of the input along the path (default: 0.02)", KT_TEXT,
       &o.margin, KT_ABOUT_MODEL},
      {"clearance", 0, "X",
       "Least clearance of bodies along the path, in the model's length unit; the pairs are those of kspace clearance",
       KT_TEXT, &o.clearance, KT_ABOUT_MODEL},
      {"ignore-limits", 0, NULL, "Joint limits don't count", KT_FLAG, &o.ignores_limits, KT_ABOUT_MODEL},
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      {"time", 0, "T", "Duration of the motion in BASE.path.json, in the model's time unit (default: 1)", KT_TEXT,
       &o.time, KT_ABOUT_FILES},
      {"format", 0, "FORMATS",
       "Files to write: some of csv,json,svg,pdf,png (with -o, unless stated: csv,svg); json is the model, its drivers prescribed; without -o a record in "
       "place of the text",
       KT_TEXT_OF("csv or json or svg or pdf or png"), &o.format, KT_ABOUT_FILES},
      KT_BASE(
          &o.files.base,
          "Write BASE.path.csv, .svg … where a path was found, else BASE.explored.csv (default where --format states a file: the model's name)"),
  };
  KT_OPTIONS_ADD(&all, own);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_common_options(&all, &o.common, KT_USES_FLOAT | KT_USES_SEED);
  kt_options_read(
      &all,
      "A path from one configuration to another that passes no singularity of the drivers: they stay in control of all "
      "bodies, with a margin, and within the joint limits."
      "\vThe input is the Jacobian of the closure without the drivers' columns, lengths over the size of the loops; its smallest "
      "singular value keeps the margin at every step of 0.04 at most. Where the determinant of the input has opposite signs at both "
      "ends there is no path, and that is certain. Otherwise the straight path is tried first, then two trees of configurations grow "
      "from both ends until they meet, the path is shortened, and its corners are rounded under the same conditions. Another --seed may find another path. With --format json the "
      "model is written with its drivers prescribed over time along the path, at rest at both ends, for ksim inverse; without -o the "
      "record is printed. A search that found none writes the configurations that it has explored: columns tree (1: from the start, 2: from the end), parent (row "
      "from which a step led there, from 0; -1: an end), then those of a path. Ctrl-C ends the search with them. "
      "Keys of the record beside those of every record: drivers, outcome (found, separated, end, not found, stopped), end (start or "
      "end: the one that isn't allowed), margin, ends (smallest singular value of the input at both), configurations, straight, "
      "smooth (false: the drivers turn corners), length, least_margin (null: the drivers move no loop), the table's columns and rows, and explored (columns and rows). Exit status 1: "
      "no path was found.",
      argc, argv);
  if (!kspace_read_formats(&o.common, o.format, "csv,json,svg,pdf,png", o.model, &o.files))
    return KT_USAGE;
  if (!o.to)
    return kt_usage(&o.common, "--to", "is missing", "a pose that the model names, or JOINT=VALUE,JOINT=VALUE");
  if (kt_is_piped(o.model))
    return kt_usage(&o.common, "MODEL", "-", "a file: the standard input can be read only once");
  kt_pose from, to = {0};
  kt_exit result = open_at(&o, o.from, &from);
  if (result == KT_DONE && !strchr(o.to, '='))
    result = open_at(&o, o.to, &to);
  if (result == KT_DONE)
    result = run(&o, &from, &to);
  kt_close(&to);
  kt_close(&from);
  return result;
}
