/* Building a model from a description: messages, what is left out, and the settings of the whole. */
#include "exchange/robot/robot.h"

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
static void set_closure_tolerance(km_robot *robot) {
  double size = robot->reach > 0.0 ? robot->reach : 1.0;
  double rounding = fmax(robot->angle_rounding, robot->length_rounding / size);
  if (robot->settings.closure_tolerance > 0.0 || !robot->closes || 2.0 * rounding <= 1e-9)
    return;
  robot->settings.closure_tolerance = fmin(2.0 * rounding, 1e-3);
  km_messages_add(robot->request->messages, KM_NOTE,
                  "closure_tolerance is set to %.2g, as the numbers in the file are rounded",
                  robot->settings.closure_tolerance);
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
  set_closure_tolerance(robot);
  km_status status = km_model_set(robot->builder, &robot->settings, error);
  if (!status)
    status = km_builder_finish(robot->builder, out, error);
  if (status == KM_MODEL)
    km_messages_add(robot->request->messages, KM_ERROR, "%s", error->text);
  if (status)
    return status;
  compute_masses(robot, *out);
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
