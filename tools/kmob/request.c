/* The options of kmob's commands about one pose. */
#include "kmob/kmob.h"

enum { OPTION_MODES = 0x2101, OPTION_STRICT };

#define BASE                                                                                                           \
  { "base", 'o', "BASE", 0, "Write BASE.RESULT.txt or .json instead of the standard output", 2 }

static const struct argp_option pose_options[] = {
    {"modes", OPTION_MODES, NULL, 0, "List the other assembly modes at this value of the driver", 1}, BASE, {0}};
static const struct argp_option check_options[] = {
    {"strict", OPTION_STRICT, NULL, 0, "Exit status 1 for remarks too", 1}, BASE, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  kmob_request *r = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &r->pose;
    return 0;
  case OPTION_MODES:
    r->modes = true;
    return 0;
  case OPTION_STRICT:
    r->strict = true;
    return 0;
  case 'o':
    r->pose.base = arg;
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

kmob_request kmob_read_request(int argc, char **argv, const char *about, kmob_asking asking) {
  const struct argp_child children[] = {{asking == KMOB_INFO ? &kt_request_argp : &kt_settable_argp, 0, NULL, 0}, {0}};
  const struct argp argp = {asking == KMOB_CHECKS ? check_options : pose_options, parse, "MODEL", about, children, NULL, NULL};
  kmob_request r = {.pose = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}}};
  kt_parse(&argp, argc, argv, &r);
  return r;
}
