/* kmob draw: a picture of a mechanism in one or more poses. */
#include "kmob/draw.h"

#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
  OPTION_HOLD = 0x4001,
  OPTION_SET,
  OPTION_AT,
  OPTION_POSES,
  OPTION_TRACE,
  OPTION_VIEW,
  OPTION_BODIES,
  OPTION_MESHES,
  OPTION_SIZE,
  OPTION_IGNORE,
  OPTION_FORMAT
};

static const struct argp_option table[] = {
    {"at", OPTION_AT, "JOINT=VALUE", 0,
     "Draw the pose at a joint's value (x,y,… for several coordinates); repeatable: "
     "the first in full, the others pale",
     1},
    {"poses", OPTION_POSES, "N", 0, "Draw N poses along the model's analysis.sweep", 1},
    {"trace", OPTION_TRACE, "BODY/FRAME", 0, "Draw the path of a frame's origin over the model's sweep (repeatable)",
     1},
    {"hold", OPTION_HOLD, "JOINT=VALUE", 0, "Keep a joint rigid at a value", 1},
    {"set", OPTION_SET, "JOINT=VALUE", 0, "Start from another pose: move a joint to a value first", 1},
    {"ignore-limits", OPTION_IGNORE, NULL, 0, "Pass joint limits", 1},
    {"view", OPTION_VIEW, "VIEW", 0, "xy, xz, yz, iso, or auto: the plane of motion, if there is one (default)", 2},
    {"bodies", OPTION_BODIES, NULL, 0, "Name the bodies too", 2},
    {"meshes", OPTION_MESHES, NULL, 0, "Draw bodies by their meshes, where they have one", 2},
    {"size", OPTION_SIZE, "WxH", 0, "Size of the page in points (1/72 inch)", 2},
    {"format", OPTION_FORMAT, "LIST", 0, "Some of svg,pdf,png (default svg)", 2},
    {"base", 'o', "BASE", 0, "Files are BASE.motion.FORMAT (default: the model's name)", 2},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
  kmob_draw_options *o = state->input;
  switch (key) {
  case ARGP_KEY_INIT:
    state->child_inputs[0] = &o->common;
    return 0;
  case OPTION_AT:
    kt_texts_add(&o->at, arg, state);
    return 0;
  case OPTION_POSES:
    o->poses = arg;
    return 0;
  case OPTION_TRACE:
    kt_texts_add(&o->traces, arg, state);
    return 0;
  case OPTION_HOLD:
    kt_texts_add(&o->holds, arg, state);
    return 0;
  case OPTION_SET:
    kt_texts_add(&o->sets, arg, state);
    return 0;
  case OPTION_IGNORE:
    o->ignore_limits = true;
    return 0;
  case OPTION_VIEW:
    o->view = arg;
    return 0;
  case OPTION_BODIES:
    o->bodies = true;
    return 0;
  case OPTION_MESHES:
    o->meshes = true;
    return 0;
  case OPTION_SIZE:
    o->size = arg;
    return 0;
  case OPTION_FORMAT:
    if (!kt_formats_parse(&o->common, arg, &o->formats))
      argp_failure(state, KT_USAGE, 0, "try --help");
    return 0;
  case 'o':
    o->base = arg;
    return 0;
  case ARGP_KEY_ARG:
    if (o->path)
      argp_error(state, "one model at a time; found \"%s\" too", arg);
    o->path = arg;
    return 0;
  case ARGP_KEY_NO_ARGS:
    argp_error(state, "no model is given");
    return 0;
  default:
    return ARGP_ERR_UNKNOWN;
  }
}

static kt_exit read_size(const kmob_draw_options *o, km_drawing *drawing) {
  const char *x = strchr(o->size, 'x');
  char width[32];
  if (!x || (size_t)(x - o->size) >= sizeof width)
    return kt_usage(&o->common, "--size", o->size, "WIDTHxHEIGHT in points");
  snprintf(width, sizeof width, "%.*s", (int)(x - o->size), o->size);
  if (!kt_number(width, &drawing->width) || !kt_number(x + 1, &drawing->height) || drawing->width <= 0.0 ||
      drawing->height <= 0.0)
    return kt_usage(&o->common, "--size", o->size, "WIDTHxHEIGHT in points");
  return KT_DONE;
}

/* What needs no model. */
static kt_exit read_options(const kmob_draw_options *o, km_drawing *drawing, int *poses) {
  double count = 0.0;
  if (o->formats.wanted[KT_CSV] || o->formats.wanted[KT_JSON])
    return kt_usage(&o->common, "--format", o->formats.wanted[KT_CSV] ? "csv" : "json", "some of svg,pdf,png");
  if (o->base && strcmp(o->base, "-") == 0)
    return kt_usage(&o->common, "-o", "-", "a file's name: pictures don't go to the standard output");
  if (o->view && !km_view_find(o->view, &drawing->view))
    return kt_usage(&o->common, "--view", o->view, "xy, xz, yz, iso or auto");
  if (o->poses && (!kt_number(o->poses, &count) || count < 1.0 || count > KT_MOST_TEXTS || count != floor(count)))
    return kt_usage(&o->common, "--poses", o->poses, "a whole number from 1 to 256");
  if (o->poses && o->at.count)
    return kt_usage(&o->common, "--poses", o->poses, "it without --at");
  *poses = (int)count;
  return o->size ? read_size(o, drawing) : KT_DONE;
}

static kt_exit write_files(const kmob_draw_options *o, const km_drawing *drawing) {
  char base[256];
  kt_exit result = KT_DONE;
  kt_base_name(o->path, base, sizeof base);
  for (int f = KT_SVG; f <= KT_PNG; ++f) {
    if (!o->formats.wanted[f])
      continue;
    km_text out = {0};
    km_error error;
    km_status status = km_drawing_render(drawing, kt_canvas_format((kt_format)f), &out, &error);
    kt_exit written = kt_exit_of(status);
    if (status)
      kt_say(&o->common, KM_ERROR, "%s", error.text);
    else
      written = kt_write(&o->common, o->base ? o->base : base, "motion", kt_format_word((kt_format)f), &out);
    km_text_free(&out);
    result = kt_worse(written, result);
  }
  return result;
}

kt_exit kmob_draw(int argc, char **argv) {
  const struct argp_child children[] = {{&kt_common_argp, 0, NULL, 90}, {0}};
  const struct argp argp = {
      table,    parse, "MODEL", "A picture of the mechanism: links, joints, poses, paths of points.",
      children, NULL,  NULL};
  kmob_draw_options o = {.common = {.tool = "kmob", .jobs = 1, .seed = 1}};
  o.formats.wanted[KT_SVG] = true;
  kt_parse(&argp, argc, argv, &o);
  km_drawing drawing = {0};
  kmob_shots shots = {.options = &o};
  kt_exit result = read_options(&o, &drawing, &shots.asked);
  if (result == KT_DONE)
    result = kmob_shots_take(&shots);
  if (result == KT_DONE || (result == KT_PARTIAL && shots.count)) {
    kmob_shots_show(&shots, &drawing);
    kt_exit written = write_files(&o, &drawing);
    result = kt_worse(written, result);
  }
  kmob_shots_free(&shots);
  return result;
}
