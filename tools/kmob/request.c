/* The options that the commands about one pose share. */
#include "kmob/kmob.h"

#include <string.h>

enum { OPTION_SET = 0x2001, OPTION_HOLD, OPTION_FORMAT, OPTION_MODES };

#define SHARED                                                                                                         \
  {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value (x,y,… for several coordinates)", 1},         \
      {"modes", OPTION_MODES, NULL, 0, "List the other assembly modes at this value of the driver", 1},                \
      {"format", OPTION_FORMAT, "FORMAT", 0, "table (default) or json", 1},                                            \
      {"output", 'o', "BASE", 0, "Write BASE.RESULT.txt or .json instead of the standard output", 1}, {                \
    0                                                                                                                  \
  }

static const struct argp_option fixed_options[] = {SHARED};
static const struct argp_option settable_options[] = {
    {"set", OPTION_SET, "JOINT=VALUE", 0, "Move a joint to a value; the loops follow", 1}, SHARED};

static error_t parse(int key, char *arg, struct argp_state *state) {
  kmob_request *r = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &r->common;
    return 0;
  case OPTION_SET:
    kmob_texts_add(&r->sets, arg, state);
    return 0;
  case OPTION_HOLD:
    kmob_texts_add(&r->holds, arg, state);
    return 0;
  case OPTION_FORMAT:
    r->json = strcmp(arg, "json") == 0;
    if (!r->json && strcmp(arg, "table") != 0)
      argp_error(state, "--format %s: expected table or json", arg);
    return 0;
  case OPTION_MODES:
    r->modes = true;
    return 0;
  case 'o':
    r->base = arg;
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

kmob_request kmob_read_request(int argc, char **argv, const char *about, bool settable) {
  const struct argp_child children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
  const struct argp argp = {settable ? settable_options : fixed_options, parse, "MODEL", about, children, NULL, NULL};
  kmob_request r = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}};
  kt_parse(&argp, argc, argv, &r);
  return r;
}

kt_exit kmob_answer(const kmob_request *r, const char *result, const km_text *text) {
  return r->base ? kt_write(&r->common, r->base, result, r->json ? "json" : "txt", text) : kt_print(&r->common, text);
}
