/* kspace map: sheets over two drivers, singularity curves, and further figures of each cell. */
#include "kspace/kspace.h"
#include "kspace/map_answer.h"

#include "kmech/clearance.h"
#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

enum { DEFAULT_STEPS = 100 };

typedef struct options {
  kt_common common;
  kt_texts holds, sets, joints, ranges, steps;
  const char *model, *point, *format, *show, *clearance, *store;
  int ask, limits, over_point, own;
  kspace_files files;
} options;

/* The drivers: those of --joint, else the two actuators of the model. */
static kt_exit read_drivers(const options *o, const km_model *model, km_space_map_def *def) {
  static const char expected[] =
      "two different drivers: --joint twice, or two joints in the model's analysis.actuators";
  kt_exit result = KT_DONE;
  if (o->joints.count == 0 && km_model_actuator_count(model) == 2) {
    for (int d = 0; d < 2; ++d)
      def->axis[d].coordinate = km_model_actuator(model, d);
    return KT_DONE;
  }
  if (o->joints.count != 2)
    return kt_usage(&o->common, "--joint", o->joints.count > 0 ? o->joints.items[0] : "is missing", expected);
  for (int d = 0; result == KT_DONE && d < 2; ++d)
    result = kt_coordinate(&o->common, model, "--joint", o->joints.items[d], &def->axis[d].coordinate);
  if (result == KT_DONE && def->axis[0].coordinate == def->axis[1].coordinate)
    result = kt_usage(&o->common, "--joint", o->joints.items[1], expected);
  return result;
}

static kt_exit bad_range(const options *o, const char *text) {
  return kt_usage(&o->common, "--range", text, "FROM:TO, two different numbers, once for each --joint");
}

/* --range, else the limits of the joint, else a full turn. */
static kt_exit read_range(const options *o, const km_model *model, int d, km_space_axis *axis) {
  const char *label = km_model_coordinate_label(model, axis->coordinate);
  double low = -HUGE_VAL, high = HUGE_VAL;
  km_model_coordinate_limits(model, axis->coordinate, &low, &high);
  if (d < o->ranges.count) {
    const char *text = o->ranges.items[d], *rest = text;
    kt_piece from = kt_split(&rest, ":");
    bool is_ok = from.separator == ':' && kt_number(from.text, &axis->from) && kt_number(rest, &axis->to) &&
                 axis->from != axis->to;
    km_free(from.text);
    return is_ok ? KT_DONE : bad_range(o, text);
  }
  if (!isfinite(low) || !isfinite(high)) {
    if (km_model_coordinate_is_length(model, axis->coordinate)) {
      kt_print_message(&o->common, KM_ERROR, "joint \"%s\" has no limits; expected --range FROM:TO for it", label);
      return KT_USAGE;
    }
    high = M_PI / km_model_units(model).angle->si;
    low = -high;
  }
  axis->from = low;
  axis->to = high;
  return KT_DONE;
}

static kt_exit read_axes(const options *o, const km_model *model, km_space_map_def *def) {
  kt_exit result = read_drivers(o, model, def);
  if (result == KT_DONE && o->ranges.count != 0 && o->ranges.count != 2)
    result = bad_range(o, o->ranges.items[0]);
  if (result == KT_DONE && o->steps.count > 2)
    result = kt_usage(&o->common, "--steps", o->steps.items[2], "at most two: for both drivers, or for each in turn");
  for (int d = 0; result == KT_DONE && d < 2; ++d) {
    def->axis[d].steps = DEFAULT_STEPS;
    if (o->steps.count > 0 &&
        !kt_integer(o->steps.items[d < o->steps.count ? d : 0], 1, KM_MAX_MAP_STEPS, &def->axis[d].steps))
      result = kt_usage(&o->common, "--steps", o->steps.items[d < o->steps.count ? d : 0],
                        "1 to 2000 intervals, once or for each --joint");
    if (result == KT_DONE)
      result = read_range(o, model, d, &def->axis[d]);
  }
  def->has_point = o->point != NULL;
  def->point_name = o->point;
  def->within_limits = o->limits;
  def->own_sheet = o->own;
  if (result == KT_DONE && o->point)
    result = kt_frame(&o->common, model, "--point", o->point, &def->frame);
  return result;
}

/* The column of the colours: --show, else the last one that --ask or --point adds. */
static const char *shown_column(const options *o, const km_space_map_def *def) {
  const km_map_figures *figures = def->figures;
  return o->show ? o->show : figures ? figures->names[figures->count - 1] : def->has_point ? "manipulability" : NULL;
}

/* ---- The answer. */

typedef struct map_answer {
  const options *o;
  const kt_pose *pose;
  km_space_map_def def;
  km_all_modes modes;
  km_space_map map;
} map_answer;

static kt_exit write_picture(const map_answer *a, kt_format format) {
  char title[256];
  kt_base_name(a->o->model, title, sizeof title);
  const km_map_look look = {.column = shown_column(a->o, &a->def), .over_point = a->o->over_point, .title = title};
  km_text out = {0};
  km_error error;
  km_status status = format == KT_HTML ? km_space_map_page(a->pose->mechanism, &a->def, &a->map, &look, &out, &error)
                                       : km_space_map_picture(a->pose->mechanism, &a->def, &a->map, &look,
                                                              kt_picture_format(format), &out, &error);
  if (status)
    kt_print_message(&a->o->common, KM_ERROR, "%s: %s", a->o->model, error.text);
  kt_exit result =
      status ? kt_exit_of(status) : kt_write(&a->o->common, a->o->files.base, "map", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_tables(const map_answer *a) {
  const kt_common *common = &a->o->common;
  kt_exit result = kspace_write_csv(common, a->o->files.base, a->map.cells, "map");
  if (result == KT_DONE)
    result = kspace_write_csv(common, a->o->files.base, a->map.curves, "singular");
  if (result == KT_DONE && a->map.boundary)
    result = kspace_write_csv(common, a->o->files.base, a->map.boundary, "boundary");
  return result;
}

static kt_exit write_format(const void *context, kt_format format, const km_text *record) {
  const map_answer *a = context;
  return format == KT_CSV    ? write_tables(a)
         : format == KT_JSON ? kt_write(&a->o->common, a->o->files.base, "map", "json", record)
                             : write_picture(a, format);
}

static const km_value *record_map(const void *context, km_arena *arena) {
  const map_answer *a = context;
  return kspace_map_record(a->pose, a->o->model, &a->def, &a->modes, &a->map, arena);
}

static void print_map(const void *context, km_text *out) {
  const map_answer *a = context;
  kspace_print_map(a->pose, a->o->model, &a->def, &a->modes, &a->map, out);
}

/* True if the work was stopped, the list of modes may lack some, or the outline lacks curves. */
static bool is_partial(const map_answer *a) {
  return a->map.is_stopped || !a->modes.is_complete ||
         (a->def.has_point && (!isfinite(a->map.workspace_area) || a->map.unbounded > 0));
}

/* Opens the store, and finds modes and map. */
static km_status find_map(map_answer *a, kt_progress *progress, km_error *error) {
  const options *o = a->o;
  km_status status = o->store ? km_map_store_open(o->store, a->pose->mechanism, a->pose->state, &a->def, o->common.seed,
                                                  o->common.force, &a->def.store, error)
                              : KM_OK;
  if (!status)
    status = km_space_map_find(a->pose->mechanism, a->pose->state, &a->def, o->common.seed, kt_progress_show, progress,
                               &a->modes, &a->map, error);
  km_map_store_free(a->def.store);
  a->def.store = NULL;
  return status;
}

/* After Ctrl-C the answer has the finished sheets and the curves found so far. */
static kt_exit compute(map_answer *a) {
  km_error error;
  kt_progress progress = kt_progress_start(&a->o->common);
  kt_interrupts_catch();
  km_status status = find_map(a, &progress, &error);
  kt_interrupts_release();
  kt_progress_end(&progress);
  if (status == KM_CANCELLED && kt_is_interrupted() && a->map.cells) {
    kt_print_message(&a->o->common, KM_NOTE,
                     "%s: %s; the answer has the finished sheets and the curves found so far%s%s", a->o->model,
                     error.text, a->o->store ? "; the same command goes on with " : "", a->o->store ? a->o->store : "");
    return KT_DONE;
  }
  bool is_other = status && strstr(error.text, "of another map");
  if (status)
    kt_print_message(&a->o->common, KM_ERROR, "%s: %s%s", a->o->model, error.text,
                     is_other ? " (--force replaces them)" : "");
  return kt_exit_of(status);
}

/* Draws the map of no mode, which has the columns only: what --show and --over-point need is there, or missing, before
 * the work starts. */
static kt_exit check_picture(const options *o, const kt_pose *pose, const km_space_map_def *def) {
  const km_all_modes none = {0};
  const km_map_look look = {.column = shown_column(o, def), .over_point = o->over_point};
  km_space_map map = {0};
  km_text out = {0};
  km_error error;
  km_status status = km_space_map_compute(pose->mechanism, pose->state, def, &none, NULL, NULL, &map, &error);
  if (!status)
    status = km_space_map_picture(pose->mechanism, def, &map, &look, KM_PICTURE_SVG, &out, &error);
  status = status == KM_NO_RESULT ? KM_OK : status;
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  km_space_map_free(&map);
  km_text_free(&out);
  return kt_exit_of(status);
}

static kt_exit run(const options *o, const kt_pose *pose) {
  map_answer a = {.o = o, .pose = pose};
  const kspace_answer forms = {&a, record_map, print_map, write_format};
  km_map_figures *figures = NULL;
  kt_exit result = read_axes(o, pose->model, &a.def);
  if (result == KT_DONE) {
    const int drivers[2] = {a.def.axis[0].coordinate, a.def.axis[1].coordinate};
    km_error error;
    km_status status =
        km_map_figures_create(pose->mechanism, pose->state, (km_map_quantity)o->ask, drivers, &figures, &error);
    if (status)
      kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
    result = kt_exit_of(status);
    a.def.figures = figures;
  }
  km_clearance *clearance = NULL;
  if (result == KT_DONE)
    result = kspace_read_clearance(&o->common, o->clearance, o->model, pose, &clearance, &a.def.least_clearance);
  a.def.clearance = clearance;
  if (result == KT_DONE && (o->show || o->over_point))
    result = check_picture(o, pose, &a.def);
  if (result == KT_DONE)
    result = compute(&a);
  if (result == KT_DONE)
    result = kspace_deliver(&o->common, &o->files, &forms);
  if (result == KT_DONE && is_partial(&a))
    result = KT_PARTIAL;
  km_map_figures_free(figures);
  km_clearance_free(clearance);
  km_space_map_free(&a.map);
  km_all_modes_free(&a.modes);
  return result;
}

kt_exit kspace_map(int argc, char **argv) {
  options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      {"joint", 0, "JOINT", "A driver; given twice (default: the two joints of the model's analysis.actuators)",
       KT_TEXTS, &o.joints, KT_ABOUT_MODEL},
      {"range", 0, "FROM:TO", "Range of each driver in turn (default: its limits, or a full turn)", KT_TEXTS, &o.ranges,
       KT_ABOUT_MODEL},
      {"steps", 0, "N", "Intervals of both grids, or of each in turn (default: 100)", KT_TEXTS, &o.steps,
       KT_ABOUT_MODEL},
      {"point", 0, "BODY/FRAME",
       "Add the place of a point that moves on a plane or a sphere, and where it can't move in some direction", KT_TEXT,
       &o.point, KT_ABOUT_MODEL},
      {"ask", 0, "QUESTION",
       "Add the leverage (advantage), the forces of the actuators (forces) or the least clearance of bodies (clearance) to each cell",
       KT_WORD(KM_MAP_QUANTITY_WORDS), &o.ask, KT_ABOUT_MODEL},
      {"show", 0, "COLUMN", "The column that the picture's colours show (default: the last that --ask or --point adds)",
       KT_TEXT, &o.show, KT_ABOUT_FILES},
      {"over-point", 0, NULL, "Draw the picture over the place of --point: the workspace", KT_FLAG, &o.over_point,
       KT_ABOUT_FILES},
      {"format", 0, "FORMATS",
       "Files to write: some of csv,json,svg,pdf,png,html (with -o, unless stated: csv,svg); html: surfaces that turn; json without -o: a record in place of the text",
       KT_TEXT_OF("csv or json or svg or pdf or png or html"), &o.format, KT_ABOUT_FILES},
      {"own", 0, NULL, "Follow the sheet of the pose only", KT_FLAG, &o.own, KT_ABOUT_MODEL},
      {"limits", 0, NULL, "Leave out cells beyond the joint limits", KT_FLAG, &o.limits, KT_ABOUT_MODEL},
      {"clearance", 0, "X",
       "Leave out cells in which bodies are nearer than X, in the model's length unit; the pairs are those of kspace clearance",
       KT_TEXT, &o.clearance, KT_ABOUT_MODEL},
      {"store", 0, "FILE", "Keep what is found in this file as it comes: the same command goes on where it was stopped",
       KT_INPUT, &o.store, KT_ABOUT_FILES},
      KT_SET(&o.sets, "Start from another pose: move a joint to a value"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      KT_BASE(
          &o.files.base,
          "Write BASE.map.csv (the grid), BASE.singular.csv (the curves), with --point BASE.boundary.csv (the outline of the workspace), and BASE.map.svg, with --format html BASE.map.html (default where --format states a file: the model's name)"),
  };
  KT_OPTIONS_ADD(&all, own);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_common_options(&all, &o.common, KT_USES_FLOAT | KT_USES_SEED | KT_USES_FORCE);
  kt_options_read(
      &all,
      "Maps over two drivers of a mechanism with two freedoms: one sheet for each assembly mode at the pose, followed from "
      "grid point to grid point, and the singularity curves of the drivers that bound the sheets."
      "\vA row of the grid has the configuration, all mobility numbers, and the smallest singular values of the input "
      "(the Jacobian of the closure without the drivers' columns) and of the closure. --point adds the smallest singular "
      "value and the manipulability of the point's Jacobian by the drivers, the curves on which it is singular, and the "
      "ends of ranges, limits and the least clearance; its workspace has area, holes and an outline by kind, and for each aspect (a part "
      "without a singularity of drivers or point) area, largest circle and largest rectangle. A sphere has columns chart, "
      "its map with true areas, and the largest cone from its centre instead. --ask advantage takes input "
      "and output of the model's analysis.mechanical_advantage; --ask forces the model's loads, and its "
      "analysis.actuators, else the drivers; --ask clearance the pairs of kspace clearance. The curves are followed by "
      "continuation of the closure with a null vector; each point is on the curve to rounding. Exit status 1: the list of "
      "modes may lack some, and so the sheets; the outline of the workspace isn't closed, or leaves grid points outside; or "
      "Ctrl-C ended the work: the finished sheets and the curves found so far are written. --store keeps modes, grid points and curves, also of a run that "
      "was killed, but for its last tenth of a second; the map is the same as that of one run without a stop. A store of another model, pose, option or version is refused. Other numbers of freedoms than two are refused. JSON keys "
      "beside those of every record: drivers (joint, from, to, steps), complete, reason (as that of modes), modes, sheets, aspects, curves, workspace "
      "(point, of a sphere: sphere with centre, radius, pole; area, holes: on a sphere one less than the parts out of reach, gap, outside, checked, aspects: aspect, area, circle, radius, rectangle, width, height, of a sphere cone (its axis) and half_angle), columns and "
      "rows of the grid.",
      argc, argv);
  kt_pose pose;
  if (!kspace_read_formats(&o.common, o.format, "csv,json,svg,pdf,png,html", o.model, &o.files))
    return KT_USAGE;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
