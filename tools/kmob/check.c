/* kmob check: everything suspicious about a model. */
#include "kmob/kmob.h"

#include "base/json.h"
#include "report/check.h"
#include "report/mobility_record.h"

#include <string.h>

enum { OPTION_HOLD = 0x5001, OPTION_FORMAT };

typedef struct options {
  kt_common common;
  kmob_texts holds, sets;
  const char *model, *base, *format;
} options;

static const struct argp_option table[] = {
    {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value (x,y,… for several coordinates)", 1},
    {"format", OPTION_FORMAT, "FORMAT", 0, "table (default) or json", 1},
    {"output", 'o', "BASE", 0, "Write BASE.check.txt or .json instead of the standard output", 1},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  options *o = state->input;
  switch (key) {
  case ARGP_KEY_INIT: state->child_inputs[0] = &o->common; return 0;
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

static kt_exit write_findings(const options *o, const kmob_pose *pose, const km_findings *findings) {
  km_text out = {0};
  km_arena arena = {0};
  bool json = strcmp(o->format, "json") == 0;
  if (json) {
    km_value *record = km_record_head(pose->model, "kmob", o->model, &arena);
    if (!arena.failed)
      km_findings_record(findings, record, &arena);
    if (!arena.failed)
      km_json_write(record, &out);
    out.failed = out.failed || arena.failed;
  } else {
    km_findings_print(findings, o->model, &out);
  }
  kt_exit result = o->base ? kt_write(&o->common, o->base, "check", json ? "json" : "txt", &out) : kt_print(&o->common, &out);
  km_arena_free(&arena);
  km_text_free(&out);
  return result;
}

static kt_exit check(const options *o, const kmob_pose *pose, const km_messages *messages) {
  km_findings findings;
  km_error error;
  km_status status = km_check(pose->mechanism, pose->state, messages, &findings, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  else
    result = write_findings(o, pose, &findings);
  if (result == KT_DONE && findings.count > 0)
    result = KT_PARTIAL;
  km_findings_free(&findings);
  return result;
}

kt_exit kmob_check(int argc, char **argv) {
  const struct argp_child children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
  const struct argp argp = {table, parse, "MODEL",
                            "Everything suspicious about a model, each with what to do. Exit status 1 if there is anything.",
                            children, NULL, NULL};
  options o = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}, .format = "table"};
  kmob_pose pose;
  km_messages *messages = km_messages_create();
  kt_parse(&argp, argc, argv, &o);
  o.common.found = messages;
  kt_exit result = kmob_open(&o.common, o.model, &o.holds, &o.sets, &pose);
  if (result == KT_DONE)
    result = check(&o, &pose, messages);
  kmob_close(&pose);
  km_messages_free(messages);
  return result;
}
