/* kmob convert: a checked model out. */
#include "kmob/kmob.h"

#include "kmech/base.h"
#include "kmech/exchange.h"
#include "kmech/inspect.h"

#include <math.h>

typedef struct options {
  kt_common common;
  kt_texts holds, sets;
  const char *model, *file, *units;
  bool frames, drawn, idealise, regular;
} options;

/* Notes on the numbers that a movable mechanism needs. */
static void report_of_changes(const options *o, const km_idealisation *found) {
  for (int i = 0; i < found->change_count; ++i) {
    const km_number_change *c = &found->change[i];
    if (isnan(c->written))
      kt_print_message(&o->common, KM_NOTE, "%s: %s is turned by %.2g of a last digit", o->model, c->place, c->digits);
    else
      kt_print_message(&o->common, KM_NOTE, "%s: %s is %.10g instead of %.10g (%.2g of a last digit)", o->model,
                       c->place, c->nearest, c->written, c->digits);
  }
  if (o->regular && found->parallel_axes + found->right_angles + found->equal_lengths == 0)
    kt_print_message(&o->common, KM_NOTE,
                     "%s: no axes that are nearly parallel or at right angles, and no nearly equal "
                     "lengths, can be made exact within rounding",
                     o->model);
  else if (o->regular)
    kt_print_message(&o->common, KM_NOTE, "%s: exact now: %d pairs of parallel axes, %d right angles, %d equal lengths",
                     o->model, found->parallel_axes, found->right_angles, found->equal_lengths);
  for (int i = 0; i < found->count; ++i)
    if (found->verdict[i].verdict == KM_ROUNDING_BEYOND)
      kt_print_message(
          &o->common, KM_WARNING,
          "%s: rounding doesn't explain why substructure %d is open or nearly singular; its numbers stand as "
          "written",
          o->model, found->verdict[i].substructure + 1);
}

/* Meshes are files of their own, in the model's length unit. */
static void report_of_meshes(const options *o, const km_model *model, const km_units *units) {
  bool any = false;
  const km_unit *own = km_model_units(model).length;
  for (int b = 1; b <= km_model_body_count(model); ++b)
    any = any || km_model_body_mesh(model, b);
  if (any && units->length != own)
    kt_print_message(&o->common, KM_WARNING, "%s: its meshes stay in %s; they need a scale of %g", o->model, own->word,
                     own->si / units->length->si);
}

/* A parameter has no dimension, so it can't follow the units, nor can the frames that a drawing becomes follow it. */
static void report_of_parameters(const options *o, const km_model *model, const km_value *written) {
  if (km_model_has_parameters(model) && !km_value_get(written, "parameters"))
    kt_print_message(&o->common, KM_NOTE, "%s: its parameters and expressions are written as their values", o->model);
}

/* As drawings, with a note on what stays as it is. */
static km_status draw(const options *o, const kt_pose *pose, const km_units *units, const double *q, km_arena *arena,
                      const km_value **value, km_error *error) {
  km_messages *notes = km_messages_create();
  km_status status = km_model_draw(pose->model, units, q, notes, arena, value, error);
  for (size_t i = 0; i < km_messages_count(notes); ++i)
    kt_print_message(&o->common, km_messages_severity(notes, i), "%s: %s", o->model, km_messages_text(notes, i));
  km_messages_free(notes);
  return status;
}

/* As a robot description, in its own units. */
static kt_exit write_robot(const options *o, const kt_pose *pose, km_model_format format, const double *q) {
  km_bytes bytes = {0};
  km_error error;
  km_messages *notes = km_messages_create();
  km_status status = km_model_write_as(pose->model, format, q, o->file, notes, &bytes, &error);
  for (size_t i = 0; i < km_messages_count(notes); ++i)
    kt_print_message(&o->common, km_messages_severity(notes, i), "%s: %s", o->model, km_messages_text(notes, i));
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  const km_text text = {.data = bytes.data, .size = bytes.size};
  kt_exit result = status ? kt_exit_of(status) : kmob_write_text(&o->common, o->file, &text);
  km_messages_free(notes);
  km_bytes_free(&bytes);
  return result;
}

static kt_exit convert_pose(const options *o, const kt_pose *pose) {
  km_units units = km_model_units(pose->model);
  kt_exit result = kmob_choose_units(&o->common, o->units, &units);
  if (result != KT_DONE)
    return result;
  km_model_format format = km_model_format_of(o->file);
  km_arena arena = {0};
  km_error error;
  const km_value *value = NULL;
  int count = km_model_coordinate_count(pose->model);
  double *q = KM_ARENA_NEW(&arena, double, (size_t)count);
  for (int c = 0; q && c < count; ++c)
    q[c] = km_state_coordinate(pose->state, c);
  if (q && format != KM_FORMAT_JSON) {
    result = write_robot(o, pose, format, q);
    km_arena_free(&arena);
    return result;
  }
  km_status status = !q         ? km_fail(&error, KM_MEMORY, "out of memory")
                     : o->drawn ? draw(o, pose, &units, q, &arena, &value, &error)
                                : km_model_convert(pose->model, &units, q, o->frames, &arena, &value, &error);
  if (!status)
    status = km_model_rename_meshes(pose->model, value, o->file, &arena, &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  else {
    report_of_meshes(o, pose->model, &units);
    report_of_parameters(o, pose->model, value);
  }
  result = status ? kt_exit_of(status) : kmob_write_value(&o->common, o->file, value);
  km_arena_free(&arena);
  return result;
}

kt_exit kmob_convert(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {.operand = {"model", "MODEL", true, &o.model, NULL}};
  const kt_option table[] = {
      {"units", 0, "LIST", "Units to write: words or symbols, as millimeters,deg (default: the model's own)", KT_TEXT,
       &o.units, KT_ABOUT_MODEL},
      KT_SET(&o.sets, "Write another pose: move a joint to a value"),
      KT_HOLD(&o.holds, "Keep a joint rigid at a value on the way"),
      {"frames", 0, NULL, "Write drawn assemblies as frames of their bodies", KT_FLAG, &o.frames, KT_ABOUT_MODEL},
      {"idealise", 0, NULL,
       "Replace rounded numbers by the nearest ones for which the loops close and move, and list them", KT_FLAG,
       &o.idealise, KT_ABOUT_MODEL},
      {"regular", 0, NULL,
       "The same; and where rounding allows it, make axes of a body in a loop parallel or orthogonal, and lengths equal",
       KT_FLAG, &o.regular, KT_ABOUT_MODEL},
      {"drawn", 0, NULL, "Write assemblies by points and axes in the pose, all bodies in one frame", KT_FLAG, &o.drawn,
       KT_ABOUT_MODEL},
      KT_MODE(o.common),
      KT_POSE(o.common),
      KMOB_FILE(&o.file),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FORCE | KT_USES_FLOAT);
  kt_options_read(
      &all,
      "Write the checked model: other units, the assembled pose. A FILE that ends with .urdf, .xml (MJCF) or .sdf is "
      "written as a robot description, in SI units; what it can't hold is a note.",
      argc, argv);
  char room[KT_FILE_ROOM];
  if (kt_file_name(&o.common, "json or urdf or xml or sdf", &o.file, room) != KT_DONE)
    return KT_USAGE;
  if (o.frames && o.drawn)
    return kt_usage(&o.common, "--drawn", "beside --frames", "one of them");
  if (km_model_format_of(o.file) != KM_FORMAT_JSON && (o.units || o.frames || o.drawn))
    return kt_usage(&o.common,
                    o.units    ? "--units"
                    : o.frames ? "--frames"
                               : "--drawn",
                    "with a robot description", "it only for a file of the model format");
  if (o.file && !kt_may_write(&o.common, o.file))
    return KT_USAGE;
  kt_pose pose;
  km_idealisation found = {0};
  o.common.exact = !o.idealise && !o.regular;
  o.common.regular = o.regular;
  o.common.idealised = &found;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE) {
    report_of_changes(&o, &found);
    result = convert_pose(&o, &pose);
  }
  kt_close(&pose);
  km_idealisation_free(&found);
  return result;
}
