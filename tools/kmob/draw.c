/* kmob draw: a picture of a mechanism in one or more poses. */
#include "kmob/draw.h"

#include "kmech/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static kt_exit read_size(kmob_draw_options *o) {
  const char *x = strchr(o->size, 'x');
  char width[32];
  if (!x || (size_t)(x - o->size) >= sizeof width)
    return kt_usage(&o->common, "--size", o->size, "WIDTHxHEIGHT in points");
  snprintf(width, sizeof width, "%.*s", (int)(x - o->size), o->size);
  if (!kt_number(width, &o->look.width) || !kt_number(x + 1, &o->look.height) || o->look.width <= 0.0 ||
      o->look.height <= 0.0)
    return kt_usage(&o->common, "--size", o->size, "WIDTHxHEIGHT in points");
  return KT_DONE;
}

/* A:B, two lengths: on the page and in fact. */
static kt_exit read_scale(kmob_draw_options *o) {
  const char *colon = strchr(o->scale, ':');
  char page[32];
  double length = 0.0, real = 0.0;
  if (colon && (size_t)(colon - o->scale) < sizeof page) {
    snprintf(page, sizeof page, "%.*s", (int)(colon - o->scale), o->scale);
    if (!kt_number(page, &length) || !kt_number(colon + 1, &real))
      real = 0.0;
  }
  if (!(length > 0.0) || !(real > 0.0))
    return kt_usage(&o->common, "--scale", o->scale, "A:B, two numbers greater than 0, such as 1:1 or 1:10");
  o->drawn_scale = length / real;
  return KT_DONE;
}

/* --scale and --link-width. */
static kt_exit read_outlines(kmob_draw_options *o) {
  if (o->scale && o->animate)
    return kt_usage(&o->common, "--scale", o->scale, "it without --animate");
  if (o->link_width && !o->scale && !o->formats.wanted[KT_DXF])
    return kt_usage(&o->common, "--link-width", o->link_width, "--scale or --format dxf with it");
  if (o->link_width && (!kt_number(o->link_width, &o->width) || o->width <= 0.0))
    return kt_usage(&o->common, "--link-width", o->link_width, "a number greater than 0");
  return o->scale ? read_scale(o) : KT_DONE;
}

/* Checks of options that need no model. */
static kt_exit read_options(kmob_draw_options *o, int *poses) {
  *poses = 0;
  if (o->models.count > 1) {
    kt_print_message(&o->common, KM_ERROR, "one model at a time; found \"%s\" too", o->models.items[1]);
    return KT_USAGE;
  }
  if (!kt_formats_parse_among(&o->common,
                              o->format    ? o->format
                              : o->animate ? "html"
                                           : "svg",
                              o->animate ? "html,apng" : "svg,pdf,png,dxf", &o->formats))
    return KT_USAGE;
  if (o->animate && (o->poses || o->at.count))
    return kt_usage(&o->common, "--animate", o->poses ? "--poses" : "--at", "one of them: a motion has all its poses");
  if (o->animate && o->meshes && o->formats.wanted[KT_HTML])
    return kt_usage(&o->common, "--animate", "--meshes", "--format apng with it: a page draws links");
  if (kt_is_piped(o->base))
    return kt_usage(&o->common, "-o", "-", "a file's name: pictures don't go to the standard output");
  if (o->view && !km_view_find(o->view, &o->look.view))
    return kt_usage(&o->common, "--view", o->view, "xy, xz, yz, iso or auto");
  if (o->poses && !kt_integer(o->poses, 1, KT_MOST_TEXTS, poses))
    return kt_usage(&o->common, "--poses", o->poses, "a whole number from 1 to 256");
  if (o->poses && o->at.count)
    return kt_usage(&o->common, "--poses", o->poses, "it without --at");
  kt_exit outlines = read_outlines(o);
  if (outlines != KT_DONE)
    return outlines;
  return o->size ? read_size(o) : KT_DONE;
}

/* Options of a motion that the picture doesn't show. */
static void note_unused(const kmob_draw_options *o) {
  static const char *const of_motion[] = {"joint", "range", "arclength", "direction", "steps"};
  bool moves = o->animate || o->poses || o->traces.count > 0;
  for (size_t i = 0; i < sizeof of_motion / sizeof *of_motion && !moves; ++i)
    if (kt_question_given(&o->asked, of_motion[i]))
      kt_print_message(&o->common, KM_NOTE, "--%s doesn't count without --poses, --trace or --animate", of_motion[i]);
}

static kt_exit write_picture(const kmob_shots *shots, const char *base, kt_format format) {
  const kmob_draw_options *o = shots->options;
  const km_drawing_look look = kmob_shots_style(shots);
  km_text out = {0};
  km_error error;
  km_status status = km_drawing_picture(shots->drawing, &look, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(&o->common, base, "motion", kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_files(const kmob_shots *shots) {
  const kmob_draw_options *o = shots->options;
  const char *base = o->base ? o->base : shots->name;
  kt_exit result = KT_DONE;
  if (o->drawn_scale > 0.0 || o->formats.wanted[KT_DXF])
    result = kmob_write_outlines(o, shots->drawing, base);
  for (int f = KT_SVG; f <= KT_PNG; ++f)
    if (o->formats.wanted[f] && !(o->drawn_scale > 0.0))
      result = kt_worse(result, write_picture(shots, base, (kt_format)f));
  return result;
}

static void add_options(kt_options *out, kmob_draw_options *o) {
  const kt_option table[] = {
      {"at", 0, "JOINT=VALUE",
       "Draw the pose at a joint's value (x,y,… for several coordinates); repeatable: the first in full, the others "
       "pale",
       KT_TEXTS, &o->at, KT_ABOUT_MODEL},
      {"poses", 0, "N", "Draw N poses along the motion", KT_TEXT, &o->poses, KT_ABOUT_MODEL},
      {"trace", 0, "BODY/FRAME", "Draw the path of a frame's origin over the motion (repeatable)", KT_TEXTS, &o->traces,
       KT_ABOUT_MODEL},
      {"animate", 0, NULL, "Draw the motion as a page that plays it, beside its mobility numbers", KT_FLAG, &o->animate,
       KT_ABOUT_MODEL},
      KT_HOLD(&o->holds, "Keep a joint rigid at a value"),
      KT_MODE(o->common),
      KT_POSE(o->common),
      KT_SET(&o->sets, KT_SET_FIRST),
      {"view", 0, "VIEW", "xy, xz, yz, iso, or auto: the plane of motion, if there is one (default)",
       KT_TEXT_OF("xy or xz or yz or iso or auto"), &o->view, KT_ABOUT_FILES},
      {"bodies", 0, NULL, "Name the bodies too", KT_FLAG, &o->look.bodies, KT_ABOUT_FILES},
      {"meshes", 0, NULL, "Draw bodies by their meshes, where they have one", KT_FLAG, &o->meshes, KT_ABOUT_FILES},
      {"size", 0, "WxH", "Size of the page in points (1/72 inch)", KT_TEXT, &o->size, KT_ABOUT_FILES},
      {"scale", 0, "A:B", "Draw the outlines of a planar mechanism's links, with holes for hinges, at this scale: 1:1",
       KT_TEXT, &o->scale, KT_ABOUT_FILES},
      {"link-width", 0, "W", "Width of the outlined links in the model's unit (default: as drawn)", KT_TEXT,
       &o->link_width, KT_ABOUT_FILES},
      {"format", 0, "LIST",
       "Some of svg,pdf,png,dxf (default svg; dxf: outlines in the model's unit); of html,apng with --animate (default html)",
       KT_TEXT_OF("svg or pdf or png or dxf or html or apng"), &o->format, KT_ABOUT_FILES},
      KT_BASE(&o->base, "Files are BASE.motion.FORMAT (default: the model's name)"),
  };
  static const char *const motion[] = {"joint", "range", "steps", "arclength", "direction", "ignore-limits", NULL};
  KT_OPTIONS_ADD(out, table);
  kt_question_some(out, &o->asked, "mobility", motion);
  kt_question_explain(out, "steps", "N", "Pictures of --animate, less one (default 240 in a plane, 120 in space)");
  kt_common_options(out, &o->common, KT_USES_FLOAT);
  out->operand = (kt_operand){"model", "MODEL", true, NULL, &o->models};
}

kt_exit kmob_draw(int argc, char **argv) {
  kmob_draw_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  add_options(&all, &o);
  kt_options_read(&all, "A picture of the mechanism: links, joints, poses, paths of points.", argc, argv);
  o.path = o.models.items[0];
  kmob_shots shots = {.options = &o};
  kt_exit result = read_options(&o, &shots.asked);
  if (result == KT_DONE) {
    note_unused(&o);
    result = kmob_shots_compute(&shots);
  }
  if (result == KT_DONE && o.animate) {
    result = kmob_animate(&shots);
  } else if (result == KT_DONE || (result == KT_PARTIAL && km_drawing_poses(shots.drawing))) {
    kt_exit written = write_files(&shots);
    result = kt_worse(written, result);
  }
  kmob_shots_free(&shots);
  return result;
}
