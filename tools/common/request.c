/* The options that the commands about one pose share. */
#include "common/pose.h"

#include <string.h>

enum { OPTION_SET = 0x2001, OPTION_HOLD, OPTION_FORMAT };

#define SHARED                                                                                                         \
  {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value (x,y,… for several coordinates)", 1},         \
      {"format", OPTION_FORMAT, "FORMAT", 0, "table (default) or json", 2}, {                                          \
    0                                                                                                                  \
  }

static const struct argp_option fixed_options[] = {SHARED};
static const struct argp_option settable_options[] = {
    {"set", OPTION_SET, "JOINT=VALUE", 0, "Move a joint to a value; the loops follow", 1}, SHARED};

static error_t parse(int key, char *arg, struct argp_state *state) {
  kt_request *r = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &r->common;
    return 0;
  case OPTION_SET:
    kt_texts_add(&r->sets, arg, state);
    return 0;
  case OPTION_HOLD:
    kt_texts_add(&r->holds, arg, state);
    return 0;
  case OPTION_FORMAT:
    r->json = strcmp(arg, "json") == 0;
    if (!r->json && strcmp(arg, "table") != 0)
      argp_error(state, "--format %s: expected table or json", arg);
    return 0;
  case ARGP_KEY_ARG:
    if (r->model)
      argp_error(state, "found a second model \"%s\"; expected one", arg);
    r->model = arg;
    return 0;
  case ARGP_KEY_NO_ARGS:
    argp_error(state, "no model is given");
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

static const struct argp_child children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
const struct argp kt_request_argp = {.options = fixed_options, .parser = parse, .children = children};
const struct argp kt_settable_argp = {.options = settable_options, .parser = parse, .children = children};

kt_exit kt_request_open(const kt_request *r, kt_pose *out) {
  return kt_open(&r->common, r->model, &r->holds, &r->sets, out);
}

kt_exit kt_answer(const kt_request *r, const char *result, const km_text *text) {
  return r->base ? kt_write(&r->common, r->base, result, r->json ? "json" : "txt", text) : kt_print(&r->common, text);
}
