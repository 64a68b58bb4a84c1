/* kmob info, kmob at: one pose. */
#include "kmob/kmob.h"

#include "base/json.h"
#include "report/diagnosis_record.h"
#include "report/mobility_record.h"

#include <string.h>

typedef struct options {
  kt_common common;
  kmob_texts holds, sets;
  const char *model, *base, *format;
} options;

enum { OPTION_SET = 0x2001, OPTION_HOLD, OPTION_FORMAT };

static const struct argp_option info_options[] = {
    {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value (x,y,… for several coordinates)", 1},
    {"format", OPTION_FORMAT, "FORMAT", 0, "table (default) or json", 1},
    {"output", 'o', "BASE", 0, "Write BASE.mobility.txt or .json instead of the standard output", 1},
    {0}};

static const struct argp_option at_options[] = {
    {"set", OPTION_SET, "JOINT=VALUE", 0, "Move a joint to a value; the loops follow", 1},
    {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value (x,y,… for several coordinates)", 1},
    {"format", OPTION_FORMAT, "FORMAT", 0, "table (default) or json", 1},
    {"output", 'o', "BASE", 0, "Write BASE.mobility.txt or .json instead of the standard output", 1},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  options *o = state->input;
  switch (key) {
  case ARGP_KEY_INIT: state->child_inputs[0] = &o->common; return 0;
  case OPTION_SET: kmob_texts_add(&o->sets, arg, state); return 0;
  case OPTION_HOLD: kmob_texts_add(&o->holds, arg, state); return 0;
  case OPTION_FORMAT:
    if (strcmp(arg, "table") != 0 && strcmp(arg, "json") != 0)
      argp_error(state, "--format %s: expected table or json", arg);
    o->format = arg;
    return 0;
  case 'o': o->base = arg; return 0;
  case ARGP_KEY_ARG:
    if (o->model)
      argp_error(state, "found a second model \"%s\"; expected one", arg);
    o->model = arg;
    return 0;
  case ARGP_KEY_NO_ARGS: argp_error(state, "no model is given"); return 0;
  default: return ARGP_ERR_UNKNOWN;
  }
}

static kt_exit describe(const options *o, const kmob_pose *pose, km_text *out) {
  km_mobility mobility;
  km_diagnosis diagnosis;
  km_error error;
  km_arena arena = {0};
  km_status status = km_diagnosis_find(pose->mechanism, pose->state, &diagnosis, &error);
  km_mobility_update(pose->mechanism, pose->state, &mobility);
  if (status) {
    kt_say(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  } else if (strcmp(o->format, "json") == 0) {
    km_value *record = km_mobility_record(pose->mechanism, pose->state, &mobility, o->model, &arena);
    if (record)
      km_diagnosis_record(pose->mechanism, &diagnosis, record, &arena);
    if (!arena.failed)
      km_json_write(record, out);
    status = arena.failed ? KM_MEMORY : KM_OK;
  } else {
    km_mobility_print(pose->mechanism, pose->state, &mobility, o->model, out);
    km_diagnosis_print(pose->mechanism, &diagnosis, out);
  }
  km_arena_free(&arena);
  km_diagnosis_free(&diagnosis);
  return kt_exit_of(status);
}

static kt_exit run(options *o) {
  kmob_pose pose;
  km_text out = {0};
  kt_exit result = kmob_open(&o->common, o->model, &o->holds, &o->sets, &pose);
  if (result == KT_DONE)
    result = describe(o, &pose, &out);
  if (result == KT_DONE)
    result = o->base ? kt_write(&o->common, o->base, "mobility", strcmp(o->format, "json") ? "txt" : "json", &out)
                     : kt_print(&o->common, &out);
  km_text_free(&out);
  kmob_close(&pose);
  return result;
}

static kt_exit start(int argc, char **argv, const struct argp_option *table, const char *about) {
  const struct argp_child children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
  const struct argp argp = {table, parse, "MODEL", about, children, NULL, NULL};
  options o = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}, .format = "table"};
  kt_parse(&argp, argc, argv, &o);
  return run(&o);
}

kt_exit kmob_info(int argc, char **argv) {
  return start(argc, argv, info_options, "Topology, substructures, mobility and mobility numbers at the file's pose.");
}

kt_exit kmob_at(int argc, char **argv) {
  return start(argc, argv, at_options,
               "Mobility and mobility numbers at a pose, reached from the file's pose along its branch.");
}
