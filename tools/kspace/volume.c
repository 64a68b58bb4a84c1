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

/* "box: x -1 to 1 m, y …" */
static void print_box(const km_space_volume *v, const char *unit, km_text *out) {
  for (int k = 0; k < v->dimension; ++k) {
    km_text_add(out, k == 0 ? "box: " : ", ");
    km_space_volume_axis_text(v, k, out);
    km_text_format(out, " %.6g to %.6g %s", v->box_low[k], v->box_high[k], unit);
  }
  km_text_add(out, "\n");
}

static void print_volume(const void *context, km_text *out) {
  const volume_answer *a = context;
  const km_space_volume *v = &a->volume;
  km_text_format(out, "%s: workspace of %s: ", a->o->model, a->o->point);
  km_space_volume_text(v, out);
  km_text_format(out, "\n%d samples: %d reached, %d not reached, %d undecided\n", v->samples, v->reached,
                 v->not_reached, v->undecided);
  print_box(v, km_model_units(a->pose->model).length->suffix, out);
  if (!a->def.within_limits)
    kspace_print_limits(a->pose, NULL, 0, out);
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
  if (!v->is_complete)
    km_value_string(arena, record, "reason", v->is_stopped ? "stopped" : "box");
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

static kt_exit write_picture(const volume_answer *a, kt_format format) {
  char name[256];
  kt_base_name(a->o->model, name, sizeof name);
  km_text title = {0}, out = {0};
  km_error error;
  km_text_format(&title, "%s: workspace of %s", name, a->o->point);
  km_status status = title.failed
                         ? km_fail(&error, KM_MEMORY, "out of memory for the picture")
                         : km_space_volume_picture(&a->volume, title.data, kt_picture_format(format), &out, &error);
  if (status)
    kt_print_message(&a->o->common, KM_ERROR, "%s: %s", a->o->model, error.text);
  kt_exit result =
      status ? kt_exit_of(status) : kt_write(&a->o->common, a->o->files.base, "volume", kt_format_word(format), &out);
  km_text_free(&title);
  km_text_free(&out);
  return result;
}

static kt_exit write_format(const void *context, kt_format format, const km_text *record) {
  const volume_answer *a = context;
  const kt_common *common = &a->o->common;
  return format == KT_CSV    ? kspace_write_csv(common, a->o->files.base, a->volume.points, "volume")
         : format == KT_JSON ? kt_write(common, a->o->files.base, "volume", "json", record)
                             : write_picture(a, format);
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
       "Files to write: some of csv,json,svg,pdf,png (with -o, unless stated: csv,svg); json without -o: a record in place of the text",
       KT_TEXT_OF("csv or json or svg or pdf or png"), &o.format, KT_ABOUT_FILES},
      KT_SET(&o.sets, "Start from another pose: move a joint to a value"),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_POSE(o.common),
      KT_BASE(
          &o.files.base,
          "Write the samples to BASE.volume.csv and a picture to BASE.volume.svg (default where --format states a file: the model's name)"),
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
      "or without end, is refused. The picture shows the workspace along each axis: the colours are its depth there, in a "
      "plane the share of samples that are reached. "
      "Columns of the table: point. x, y, z, reached (1, 0, or -1: undecided), q. of each joint where it is reached. JSON "
      "keys beside those of every record: point, dimension, volume or area, standard_error, low, high, complete, reason "
      "(stopped or box), samples, "
      "reached, not_reached, undecided, split_cells, box (axis, from, to, cells), columns and rows. Exit status 1: Ctrl-C "
      "ended the work, and other samples count as undecided; or samples enlarged the box to the last.",
      argc, argv);
  if (!kspace_read_formats(&o.common, o.format, "csv,json,svg,pdf,png", o.model, &o.files))
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
