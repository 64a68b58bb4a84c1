/* Building a model from a description: messages, what is left out, and the settings of the whole. */
#include "exchange/robot/robot.h"

#include "model/written_numbers.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void report(km_robot *robot, km_severity severity, const km_xml *at, const char *format, va_list arguments) {
  char text[KM_ERROR_TEXT], place[400] = "";
  if (robot->arena.failed) /* later missing elements may be a consequence */
    return;
  vsnprintf(text, sizeof text, format, arguments);
  if (at)
    snprintf(place, sizeof place, "%.300s%sline %d, column %d: ", at->file ? at->file : "", at->file ? ": " : "",
             at->line, at->column);
  km_messages_add(robot->request->messages, severity, "%s%s", place, text);
  robot->failed = robot->failed || severity == KM_ERROR;
}

void km_robot_error(km_robot *robot, const km_xml *at, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  report(robot, KM_ERROR, at, format, arguments);
  va_end(arguments);
}

void km_robot_warn(km_robot *robot, const km_xml *at, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  report(robot, KM_WARNING, at, format, arguments);
  va_end(arguments);
}

const char *km_robot_text(km_robot *robot, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const char *text = km_arena_format_list(&robot->arena, format, arguments);
  va_end(arguments);
  return text ? text : "";
}

void km_robot_omit(km_robot *robot, const char *kind, const char *name) {
  km_omissions_add(&robot->omissions, kind, name);
}

/* Loops that a file's rounded numbers leave almost closed, or axes almost parallel, close to within the rounding, where
 * the file states no tolerance. */
static bool set_closure_tolerance(km_robot *robot) {
  double size = robot->reach > 0.0 ? robot->reach : 1.0;
  double rounding = fmax(robot->angles.several, robot->lengths.several / size);
  if (robot->settings.closure_tolerance > 0.0 || !robot->closes || 2.0 * rounding <= 1e-9)
    return false;
  robot->settings.closure_tolerance = fmin(2.0 * rounding, 1e-3);
  km_messages_add(robot->request->messages, KM_NOTE,
                  "closure_tolerance is set to %.2g, as the numbers in the file are rounded",
                  robot->settings.closure_tolerance);
  return true;
}

/* Half a unit of the last digit of the coordinates of frames: of the coarsest number with at least `several` digits. */
static double coarsest_half(const km_model *model, int several) {
  enum { ALL = 12 /* digits of a number that was computed */ };
  double half = 0.0;
  for (int f = 0; f < model->frame_count; ++f) {
    const km_vec3 *p = &model->frames[f].pose.p;
    const double x[3] = {p->x, p->y, p->z};
    for (int k = 0; k < 3; ++k) {
      int digits;
      double own = km_half_digit(x[k], &digits);
      if (digits >= several && digits <= ALL)
        half = fmax(half, own);
    }
  }
  return half;
}

/* Half a unit of the last digit of a description's lengths: of its numbers with four digits; if axes are rounded and no
 * length has more, of those with three. */
static double length_half(const km_robot *robot, const km_model *model) {
  double half = fmax(robot->lengths.several, coarsest_half(model, 4));
  return half > 0.0 || robot->angles.written == 0.0 ? half : coarsest_half(model, 3);
}

/* Records how the poses of frames are rounded (model/written_numbers.h): the coordinates of each frame and
 * its turns about its own axes, instead of the forms in which a description states them. */
static void record_numbers(const km_robot *robot, km_model *model) {
  double length = length_half(robot, model), angle = fmax(robot->angles.several, robot->angles.written);
  for (int f = 0; f < model->frame_count; ++f) {
    const km_pose *pose = &model->frames[f].pose;
    const double x[3] = {pose->p.x, pose->p.y, pose->p.z};
    if (strcmp(model->frames[f].name, "origin") == 0)
      continue;
    for (int k = 0; k < 3 && length > 0.0; ++k)
      if (x[k] != 0.0)
        km_model_add_written(model, &(km_written_number){.frame = {f, -1},
                                                         .key = "T",
                                                         .index = k,
                                                         .value = x[k],
                                                         .half = length,
                                                         .move = {k == 0, k == 1, k == 2}});
    for (int k = 0; k < 3 && angle > 0.0; ++k)
      km_model_add_written(
          model,
          &(km_written_number){
              .frame = {f, -1}, .key = "turn", .index = -1, .value = nan(""), .half = angle, .turn = pose->R.axis[k]});
  }
}

static void compute_masses(const km_robot *robot, km_model *model) {
  double sum = 0.0;
  for (int b = 1; b < model->body_count; ++b)
    sum += model->bodies[b].mass;
  if (!(robot->total_mass > 0.0) || !(sum > 0.0))
    return;
  for (int b = 1; b < model->body_count; ++b) {
    model->bodies[b].mass *= robot->total_mass / sum;
    for (int k = 0; k < 6; ++k)
      model->bodies[b].inertia[k] *= robot->total_mass / sum;
  }
}

static km_status first_error(const km_robot *robot, km_error *error) {
  const km_messages *messages = robot->request->messages;
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, KM_MODEL, "%s", km_messages_text(messages, i));
  return km_fail(error, KM_MODEL, "the file has faults");
}

static km_status finish(km_robot *robot, km_model **out, km_error *error) {
  if (robot->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory while reading the model");
  if (robot->failed)
    return first_error(robot, error);
  if (robot->request->closure_tolerance > 0.0)
    robot->settings.closure_tolerance = robot->request->closure_tolerance;
  bool is_inferred = set_closure_tolerance(robot);
  km_status status = km_model_set(robot->builder, &robot->settings, error);
  if (!status)
    status = km_builder_finish(robot->builder, out, error);
  if (status == KM_MODEL)
    km_messages_add(robot->request->messages, KM_ERROR, "%s", error->text);
  if (status)
    return status;
  compute_masses(robot, *out);
  (*out)->closure_tolerance_inferred = is_inferred;
  if (robot->closes)
    record_numbers(robot, *out);
  km_omissions_report(&robot->omissions, robot->request->messages);
  return KM_OK;
}

km_status km_robot_build(km_robot_read read, km_xml *root, const km_robot_request *request, km_model **out,
                         km_error *error) {
  km_robot robot = {.request = request, .settings = km_settings_default()};
  km_status status = km_builder_create(&robot.builder, error);
  if (!status) {
    read(&robot, root);
    status = finish(&robot, out, error);
  }
  km_builder_free(robot.builder);
  km_names_free(&robot.joints);
  km_names_free(&robot.bodies);
  km_names_free(&robot.frames);
  km_arena_free(&robot.arena);
  return status;
}
