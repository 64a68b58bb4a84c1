/* kmob convert, new, schema: model files out. */
#include "kmob/kmob.h"

#include "base/file.h"
#include "base/memory.h"
#include "exchange/json/convert.h"
#include "exchange/json/format.h"
#include "exchange/json/json.h"

#include <string.h>
#include <unistd.h>

typedef struct options {
  kt_common common;
  kt_texts holds, sets;
  const char *model, *file, *units;
  bool frames;
} options;

static kt_exit write_file(const options *o, const km_text *text) {
  km_error error;
  km_status status = km_file_write(o->file ? o->file : "-", text, &error);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s", error.text);
  return kt_exit_of(status);
}

static kt_exit write_value(const options *o, const km_value *value) {
  km_text text = {0};
  km_json_write(value, &text);
  kt_exit result = write_file(o, &text);
  km_text_free(&text);
  return result;
}

/* A unit's word or symbol decides which quantity it is for: -1 if none. */
static int choose_unit(const char *word, km_units *units) {
  for (int q = 0; q < KM_QUANTITIES; ++q) {
    const km_unit *unit = km_unit_find((km_quantity)q, word);
    if (!unit)
      continue;
    *km_units_slot(units, (km_quantity)q) = unit;
    return q;
  }
  return -1;
}

static kt_exit choose_units(const options *o, km_units *units) {
  const char *rest = o->units;
  bool chosen[KM_QUANTITIES] = {false};
  for (char last = o->units ? ',' : 0; last == ',';) {
    kt_piece piece = kt_split(&rest, ",");
    int quantity = piece.text ? choose_unit(piece.text, units) : -1;
    last = piece.separator;
    if (quantity < 0)
      kt_say(
          &o->common, KM_ERROR,
          "--units %s: \"%s\" is not a unit; expected some of radians degrees, meters millimeters centimeters inches, "
          "kilograms grams pounds, seconds milliseconds, newtons pounds-force",
          o->units, piece.text ? piece.text : "");
    else if (chosen[quantity])
      kt_say(&o->common, KM_ERROR, "--units %s: \"%s\" is a second unit of %s; expected one", o->units, piece.text,
             km_quantity_name((km_quantity)quantity));
    km_free(piece.text);
    if (quantity < 0 || chosen[quantity])
      return KT_USAGE;
    chosen[quantity] = true;
  }
  return KT_DONE;
}

/* Meshes are files of their own, in the model's length unit. */
static void tell_of_meshes(const options *o, const km_model *model, const km_units *units) {
  bool any = false;
  for (int b = 1; b < model->body_count; ++b)
    any = any || model->bodies[b].mesh;
  if (any && units->length != model->units.length)
    kt_say(&o->common, KM_WARNING, "%s: its meshes stay in %s; they need a scale of %g", o->model,
           model->units.length->word, model->units.length->si / units->length->si);
}

/* A parameter has no dimension, so it can't follow the units, nor can the frames that a drawing becomes follow it. */
static void tell_of_parameters(const options *o, const km_model *model, const km_value *written) {
  if (km_model_has_parameters(model) && !km_value_get(written, "parameters"))
    kt_say(&o->common, KM_NOTE, "%s: its parameters and expressions are written as their values", o->model);
}

static kt_exit convert_pose(const options *o, const kt_pose *pose) {
  km_units units = pose->model->units;
  kt_exit result = choose_units(o, &units);
  if (result != KT_DONE)
    return result;
  km_arena arena = {0};
  km_error error;
  const km_value *value = NULL;
  double *q = KM_ARENA_NEW(&arena, double, (size_t)pose->model->coordinate_count);
  for (int c = 0; q && c < pose->model->coordinate_count; ++c)
    q[c] = km_state_coordinate(pose->state, c);
  km_status status = q ? km_model_convert(pose->model, &units, q, o->frames, &arena, &value, &error)
                       : km_fail(&error, KM_MEMORY, "out of memory");
  if (status)
    kt_say(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  else {
    tell_of_meshes(o, pose->model, &units);
    tell_of_parameters(o, pose->model, value);
  }
  result = status ? kt_exit_of(status) : write_value(o, value);
  km_arena_free(&arena);
  return result;
}

#define KMOB_FILE(TARGET)                                                                                              \
  { "base", 'o', "FILE", "Write FILE instead of the standard output", KT_TEXT, TARGET, KT_ABOUT_FILES }

kt_exit kmob_convert(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {.operand = {"model", "MODEL", true, &o.model, NULL}};
  const kt_option table[] = {
      {"units", 0, "LIST", "Units to write: words or symbols, as millimeters,deg (default: the model's own)", KT_TEXT,
       &o.units, KT_ABOUT_MODEL},
      KT_SET(&o.sets, "Write another pose: move a joint to a value"),
      KT_HOLD(&o.holds, "Keep a joint rigid at a value on the way"),
      {"frames", 0, NULL, "Write drawn assemblies as frames of their bodies", KT_FLAG, &o.frames, KT_ABOUT_MODEL},
      KT_MODE(o.common),
      KMOB_FILE(&o.file),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  kt_options_read(&all, "Write the checked model: other units, the assembled pose.", argc, argv);
  kt_pose pose;
  kt_exit result = kt_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE)
    result = convert_pose(&o, &pose);
  kt_close(&pose);
  return result;
}

/* A crank-rocker: small enough to read, complete enough to change. */
static const char starter[] = "{\n"
                              "  \"model_parameters\": {\n"
                              "    \"version\": \"1.0\",\n"
                              "    \"units\": {\"angle\": \"degrees\", \"length\": \"millimeters\"}\n"
                              "  },\n"
                              "  \"fixed\": {\"frames\": [{\"name\": \"rocker_pivot\", \"T\": [80, 0, 0]}]},\n"
                              "  \"assemblies\": [{\n"
                              "    \"name\": \"linkage\",\n"
                              "    \"bodies\": [\n"
                              "      {\"name\": \"crank\", \"frames\": [{\"name\": \"tip\", \"T\": [20, 0, 0]}]},\n"
                              "      {\"name\": \"coupler\", \"frames\": [{\"name\": \"tip\", \"T\": [70, 0, 0]}, "
                              "{\"name\": \"tracer\", \"T\": [35, 30, 0]}]},\n"
                              "      {\"name\": \"rocker\", \"frames\": [{\"name\": \"tip\", \"T\": [50, 0, 0]}]}\n"
                              "    ],\n"
                              "    \"joints\": [\n"
                              "      {\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", "
                              "\"origin\"], [\"crank\", \"origin\"]], \"initial_displacement\": 60},\n"
                              "      {\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"crank\", \"tip\"], "
                              "[\"coupler\", \"origin\"]], \"initial_displacement\": -30},\n"
                              "      {\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"coupler\", "
                              "\"tip\"], [\"rocker\", \"tip\"]], \"initial_displacement\": 70},\n"
                              "      {\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", "
                              "\"rocker_pivot\"], [\"rocker\", \"origin\"]], \"initial_displacement\": 100}\n"
                              "    ]\n"
                              "  }],\n"
                              "  \"analysis\": {\n"
                              "    \"sweep\": {\"joint\": \"A\", \"range\": [0, 360], \"steps\": 180},\n"
                              "    \"mechanical_advantage\": {\"input\": \"A\", \"output\": \"D\"}\n"
                              "  }\n"
                              "}\n";

kt_exit kmob_new(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {.operand = {"name", "NAME", true, &o.model, NULL}};
  kt_common_options(&all, &o.common, KT_USES_FORCE);
  kt_options_read(&all, "Write NAME.json, a four-bar linkage to start from; - is the standard output.", argc, argv);
  if (!o.model[0]) {
    kt_say(&o.common, KM_ERROR, "no name is given (kmob new --help)");
    return KT_USAGE;
  }
  km_text text = {0}, path = {0};
  km_text_add(&text, starter);
  size_t length = strlen(o.model);
  bool named = length > 5 && strcmp(o.model + length - 5, ".json") == 0;
  km_text_format(&path, "%s%s", o.model, named || strcmp(o.model, "-") == 0 ? "" : ".json");
  kt_exit result = KT_INTERNAL;
  o.file = path.data;
  if (path.data && !o.common.force && strcmp(path.data, "-") != 0 && access(path.data, F_OK) == 0) {
    kt_say(&o.common, KM_ERROR, "%s: exists already; expected a new name, or --force", path.data);
    result = KT_USAGE;
  } else if (path.data) {
    result = write_file(&o, &text);
    if (result == KT_DONE && strcmp(path.data, "-") != 0)
      kt_say(&o.common, KM_NOTE, "wrote %s; try: kmob sweep %s", path.data, path.data);
  }
  km_text_free(&text);
  km_text_free(&path);
  return result;
}

kt_exit kmob_schema(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  const kt_option table[] = {KMOB_FILE(&o.file)};
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, 0);
  kt_options_read(&all, "The JSON schema of the model format.", argc, argv);
  km_arena arena = {0};
  const km_value *schema = km_format_schema(&arena);
  kt_exit result = schema ? write_value(&o, schema) : KT_INTERNAL;
  km_arena_free(&arena);
  return result;
}
