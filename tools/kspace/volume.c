/* kspace volume: how large the workspace of a point is, by samples. */
#include "kspace/kspace.h"

#include "kmech/clearance.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/volume.h"

#include <math.h>

typedef struct options {
  kt_common common;
  kt_texts holds, sets;
  const char *model, *point, *format, *clearance, *samples;
  int limits, own;
  kspace_files files;
} options;

typedef struct volume_answer {
  const options *o;
  const kt_pose *pose;
  km_space_volume_def def;
  km_space_volume volume;
} volume_answer;

/* ---- Record and text. */

/* Prints the extent of the box along an axis: x, y or z, if it is one of them, turned or not. */
static void print_side(const km_space_volume *v, int k, const char *unit, km_text *out) {
  const double *a = v->axis[k];
  double low = v->box_low[k], high = v->box_high[k];
  int axis = 0;
  while (axis < 3 && fabs(a[axis]) != 1.0)
    ++axis;
  km_text_add(out, k == 0 ? "box: " : ", ");
  if (axis == 3)
    km_text_format(out, "along (%.6g, %.6g, %.6g) %.6g to %.6g %s", a[0], a[1], a[2], low, high, unit);
  else if (a[axis] > 0.0)
    km_text_format(out, "%c %.6g to %.6g %s", "xyz"[axis], low, high, unit);
  else
    km_text_format(out, "%c %.6g to %.6g %s", "xyz"[axis], -high, -low, unit);
}

static void print_volume(const void *context, km_text *out) {
  const volume_answer *a = context;
  const km_space_volume *v = &a->volume;
  const char *unit = km_model_units(a->pose->model).length->suffix, *power = v->dimension == 3 ? "³" : "²";
  km_text_format(out, "%s: workspace of %s: %s %.6g %s%s, 95 %% interval %.6g to %.6g %s%s\n", a->o->model, a->o->point,
                 v->dimension == 3 ? "volume" : "area", v->volume, unit, power, v->low, v->high, unit, power);
  km_text_format(out, "%d samples: %d reached, %d not reached, %d undecided\n", v->samples, v->reached, v->not_reached,
                 v->undecided);
  for (int k = 0; k < v->dimension; ++k)
    print_side(v, k, unit, out);
  km_text_add(out, "\n");
  if (!a->def.within_limits)
    kspace_print_limits(a->pose->model, NULL, 0, out);
}

static const km_value *record_volume(const void *context, km_arena *arena) {
  const volume_answer *a = context;
  const km_space_volume *v = &a->volume;
  km_value *record = km_record_head(a->pose->mechanism, "kspace volume", a->o->model, arena);
  km_value_string(arena, record, "point", a->o->point);
  km_value_number(arena, record, "dimension", v->dimension);
  km_value_number(arena, record, v->dimension == 3 ? "volume" : "area", v->volume);
  km_value_number(arena, record, "standard_error", v->standard_error);
  km_value_number(arena, record, "low", v->low);
  km_value_number(arena, record, "high", v->high);
  km_value_boolean(arena, record, "complete", v->is_complete);
  km_value_number(arena, record, "samples", v->samples);
  km_value_number(arena, record, "reached", v->reached);
  km_value_number(arena, record, "not_reached", v->not_reached);
  km_value_number(arena, record, "undecided", v->undecided);
  km_value_number(arena, record, "split_cells", v->split_cells);
  km_value *box = km_value_add(arena, record, "box", KM_LIST);
  for (int k = 0; k < v->dimension && !arena->failed; ++k) {
    km_value *side = km_value_add(arena, box, NULL, KM_OBJECT);
    km_value *axis = km_value_add(arena, side, "axis", KM_LIST);
    for (int i = 0; i < 3; ++i)
      km_value_number(arena, axis, NULL, v->axis[k][i]);
    km_value_number(arena, side, "from", v->box_low[k]);
    km_value_number(arena, side, "to", v->box_high[k]);
    km_value_number(arena, side, "cells", v->cells[k]);
  }
  km_table_record(v->points, record, arena);
  return arena->failed ? NULL : record;
}

static kt_exit write_format(const void *context, kt_format format, const km_text *record) {
  const volume_answer *a = context;
  return format == KT_CSV ? kspace_write_csv(&a->o->common, a->o->files.base, a->volume.points, "volume")
                          : kt_write(&a->o->common, a->o->files.base, "volume", "json", record);
}

/* ---- The command. */

/* After Ctrl-C the answer has the samples decided so far. */
static kt_exit compute(volume_answer *a) {
  km_error error;
  const kt_common *common = &a->o->common;
  kt_progress progress = kt_progress_start(common);
  kt_interrupts_catch();
  km_status status = km_space_volume_find(a->pose->mechanism, a->pose->state, &a->def, kt_progress_show, &progress,
                                          &a->volume, &error);
  kt_interrupts_release();
  kt_progress_end(&progress);
  if (status == KM_CANCELLED && kt_is_interrupted() && a->volume.points) {
    kt_print_message(common, KM_NOTE, "%s: %s; the others count as undecided", a->o->model, error.text);
    return KT_DONE;
  }
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", a->o->model, error.text);
  return kt_exit_of(status);
}

static kt_exit run(const options *o, const kt_pose *pose) {
  volume_answer a = {.o = o,
                     .pose = pose,
                     .def = {.point_name = o->point,
                             .own_circuit = o->own,
                             .within_limits = o->limits,
                             .seed = o->common.seed,
                             .jobs = o->common.jobs}};
  const kspace_answer forms = {&a, record_volume, print_volume, write_format};
  km_clearance *clearance = NULL;
  kt_exit result = kt_frame(&o->common, pose->model, "--point", o->point, &a.def.frame);
  if (result == KT_DONE && o->samples &&
      !kt_integer(o->samples, KM_MIN_VOLUME_SAMPLES, KM_MAX_VOLUME_SAMPLES, &a.def.samples))
    result = kt_usage(&o->common, "--samples", o->samples, "100 to 1000000 points");
  if (result == KT_DONE)
    result = kspace_read_clearance(&o->common, o->clearance, o->model, pose, &clearance, &a.def.least_clearance);
  a.def.clearance = clearance;
  if (result == KT_DONE)
    result = compute(&a);
  if (result == KT_DONE)
    result = kspace_deliver(&o->common, &o->files, &forms);
  if (result == KT_DONE && !a.volume.is_complete)
    result = KT_PARTIAL;
  km_clearance_free(clearance);
  km_space_volume_free(&a.volume);
  return result;
}

kt_exit kspace_volume(int argc, char **argv) {
  options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  const kt_option own[] = {
      {"point", 0, "BODY/FRAME", "The point", KT_TEXT, &o.point, KT_ABOUT_MODEL},
      {"samples", 0, "N", "At most N random points of the box (default: 10000)", KT_TEXT, &o.samples, KT_ABOUT_MODEL},
      {"own", 0, NULL, "Count only configurations that a motion from the pose leads to", KT_FLAG, &o.own,
       KT_ABOUT_MODEL},
      {"limits", 0, NULL, "Count only configurations within the joint limits", KT_FLAG, &o.limits, KT_ABOUT_MODEL},
      {"clearance", 0, "X",
       "Count only configurations in which bodies are at least X apart, in the model's length unit; the pairs are "
       "those of kspace clearance",
       KT_TEXT, &o.clearance, KT_ABOUT_MODEL},
      {"format", 0, "FORMATS",
       "Files to write: some of csv,json (with -o, unless stated: csv); json without -o: a record in place of the text",
       KT_TEXT_OF("csv or json"), &o.format, KT_ABOUT_FILES},
      KT_SET(&o.sets, "Start from another pose: move a joint to a value"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      KT_BASE(&o.files.base,
              "Write the samples to BASE.volume.csv (default where --format states a file: the model's name)"),
  };
  KT_OPTIONS_ADD(&all, own);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_common_options(&all, &o.common, KT_USES_FLOAT | KT_USES_SEED | KT_USES_JOBS);
  kt_options_read(
      &all,
      "How large the workspace of a point is: a volume, or an area where the point stays in a plane, with its standard "
      "error and 95 % interval."
      "\vThe box of the workspace is divided into cells with two random samples each. The point is moved to each sample "
      "from the nearest known configurations, around singularities. All ways in which the loops close count, unless "
      "--own is given, and so do configurations beyond the joint limits, unless --limits is. A sample is not reached if "
      "eight attempts end where no motion brings the point nearer. It is undecided if attempts end otherwise, and then "
      "counts for the upper end of the interval only. The standard error is that of stratified samples: it comes from "
      "the cells of which one sample is reached. Four times as many samples shorten the interval to two fifths of its "
      "length in space, and to a third in a plane. A point with fewer freedoms, or one that moves on a curved surface "
      "or without end, is refused. "
      "Columns of the table: point. x, y, z, reached (1, 0, or -1: undecided), q. of each joint where it is reached. JSON "
      "keys beside those of every record: point, dimension, volume or area, standard_error, low, high, complete, samples, "
      "reached, not_reached, undecided, split_cells, box (axis, from, to, cells), columns and rows. Exit status 1: Ctrl-C "
      "ended the work, and other samples count as undecided; or samples enlarged the box to the last.",
      argc, argv);
  if (!kspace_read_formats(&o.common, o.format, "csv,json", o.model, &o.files))
    return KT_USAGE;
  if (!o.point)
    return kt_usage(&o.common, "--point", "is missing", "BODY/FRAME, the point");
  kt_pose pose;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE)
    result = run(&o, &pose);
  kt_close(&pose);
  return result;
}
