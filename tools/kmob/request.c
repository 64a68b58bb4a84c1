/* The options of kmob's commands about one pose. */
#include "kmob/kmob.h"

enum { OPTION_MODES = 0x2101 };

static const struct argp_option options[] = {
    {"modes", OPTION_MODES, NULL, 0, "List the other assembly modes at this value of the driver", 1},
    {"output", 'o', "BASE", 0, "Write BASE.RESULT.txt or .json instead of the standard output", 2},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  kmob_request *r = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &r->pose;
    return 0;
  case OPTION_MODES:
    r->modes = true;
    return 0;
  case 'o':
    r->pose.base = arg;
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

kmob_request kmob_read_request(int argc, char **argv, const char *about, bool settable) {
  const struct argp_child children[] = {{settable ? &kt_settable_argp : &kt_request_argp, 0, NULL, 0}, {0}};
  const struct argp argp = {options, parse, "MODEL", about, children, NULL, NULL};
  kmob_request r = {.pose = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}}};
  kt_parse(&argp, argc, argv, &r);
  return r;
}
