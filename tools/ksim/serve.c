/* The command for sessions: options, session, and the loop over requests. */
#include "ksim/serve.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct serve_options {
  kt_common common;
  kt_question asked; /* rates, crossings, frames and integrator, as of the question "run" */
  kt_texts holds, sets;
  const char *model, *step, *socket;
} serve_options;

/* "1ms", "0.5us", "2s", or a number in the model's time unit. */
static kt_exit read_step(const serve_options *o, const km_model *model, double *out) {
  static const struct {
    const char *suffix;
    double seconds;
  } units[] = {{"ms", 1e-3}, {"us", 1e-6}, {"s", 1.0}};
  char number[64];
  double factor = 1.0;
  size_t length = o->step ? strlen(o->step) : 0;
  if (!o->step)
    return KT_DONE;
  for (size_t i = 0; i < sizeof units / sizeof *units && factor == 1.0; ++i) {
    size_t suffix = strlen(units[i].suffix);
    if (length > suffix && strcmp(o->step + length - suffix, units[i].suffix) == 0) {
      factor = units[i].seconds / km_model_units(model).time->si;
      length -= suffix;
      break;
    }
  }
  snprintf(number, sizeof number, "%.*s", (int)length, o->step);
  if (length >= sizeof number || !kt_number(number, out) || !(*out > 0.0))
    return kt_usage(&o->common, "--step", o->step, "a positive time, as 1ms");
  *out *= factor;
  return KT_DONE;
}

static void serve(ksim_server *server, FILE *in, FILE *out) {
  char *line = NULL;
  size_t room = 0;
  km_text reply = {0};
  ksim_describe(server, &reply);
  for (ssize_t size = 0; size >= 0 && !reply.failed && !server->is_over;) {
    if (fwrite(reply.data, 1, reply.size, out) != reply.size || fflush(out))
      break;
    reply.size = 0;
    size = getline(&line, &room, in);
    if (size >= 0)
      ksim_reply(server, line, (size_t)size, &reply);
  }
  if (reply.size && !reply.failed) /* the last reply of a run that can't go on */
    fwrite(reply.data, 1, reply.size, out);
  if (reply.failed)
    server->result = KT_NO_MEMORY;
  km_text_free(&reply);
  free(line);
}

static void report_times(const ksim_server *server) {
  if (server->steps > 0)
    kt_print_message(server->common, KM_NOTE,
                     "%ld steps: mean %.3g ms, longest %.3g ms of computing for a step of %.3g ms", server->steps,
                     1e3 * server->total / (double)server->steps, 1e3 * server->longest,
                     1e3 * server->step * km_model_units(server->pose.model).time->si);
}

/* Warns of passed limits; the exit code of a session that otherwise is done. */
static kt_exit report_limits(const serve_options *o, const ksim_server *server) {
  const int count = km_session_limit_count(server->session);
  if (kt_question_given(&o->asked, "ignore-limits"))
    return server->result;
  for (int i = 0; i < count; ++i) {
    const km_passed_limit limit = km_session_limit(server->session, i);
    ksim_report_limit(&o->common, o->model, server->pose.model, &limit);
  }
  return count > 0 && server->result == KT_DONE ? KT_PARTIAL : server->result;
}

/* Reads an option of the question "run"; what its value points to goes to the arena. */
static kt_exit read(const serve_options *o, const km_model *model, const char *option, km_arena *arena,
                    km_option_value *out) {
  return kt_question_read(&o->common, model, &o->asked, option, arena, out);
}

static kt_exit set_rates(const serve_options *o, const kt_pose *pose, km_arena *arena) {
  km_option_value rates;
  km_error error;
  kt_exit result = read(o, pose->model, "rate", arena, &rates);
  km_status status = KM_OK;
  for (int i = 0; i < rates.count && result == KT_DONE && !status; ++i)
    status = km_state_set_rate(pose->mechanism, pose->state, rates.coordinates[i], rates.settings[i], &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "--rate: %s", error.text);
  return status ? kt_exit_of(status) : result;
}

static kt_exit add_crossings(const serve_options *o, const char *option, bool stops, ksim_server *server,
                             km_arena *arena) {
  km_option_value values;
  kt_exit result = read(o, server->pose.model, option, arena, &values);
  km_crossing *all = KM_ARENA_NEW(arena, km_crossing, (size_t)(server->crossing_count + values.count) + 1);
  if (result != KT_DONE || !all)
    return all ? result : KT_NO_MEMORY;
  for (int i = 0; i < server->crossing_count; ++i)
    all[i] = server->crossings[i];
  for (int i = 0; i < values.count; ++i)
    all[server->crossing_count++] =
        (km_crossing){.coordinate = values.coordinates[i], .value = values.settings[i], .stops = stops};
  server->crossings = all;
  return KT_DONE;
}

static kt_exit create_session(const serve_options *o, ksim_server *server, km_arena *arena) {
  km_error error;
  km_option_value method, stops;
  km_session_def def = km_session_default(server->pose.model);
  kt_exit result = read(o, server->pose.model, "integrator", arena, &method);
  if (result == KT_DONE)
    result = read_step(o, server->pose.model, &def.step);
  if (result == KT_DONE)
    result = read(o, server->pose.model, "limit-stops", arena, &stops);
  if (result == KT_DONE && kt_question_given(&o->asked, "limit-stops")) {
    def.limit_stop[0] = stops.numbers[0];
    def.limit_stop[1] = stops.numbers[1];
  }
  int *frames = KM_ARENA_NEW(arena, int, (size_t)server->frames.count + 1);
  if (!frames)
    return KT_NO_MEMORY;
  for (int i = 0; i < server->frames.count; ++i)
    frames[i] = server->frames.points[i].frame;
  def.frames = frames;
  def.frame_count = server->frames.count;
  def.simulation.crossings = server->crossings;
  def.simulation.crossing_count = server->crossing_count;
  if (kt_question_given(&o->asked, "integrator"))
    def.simulation.integrator = (km_integrator)method.whole;
  server->step = def.step;
  if (result != KT_DONE)
    return result;
  km_status status = km_session_create(server->pose.mechanism, server->pose.state, &def, &server->session, &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  return kt_exit_of(status);
}

static kt_exit open_session(const serve_options *o, ksim_server *server, km_arena *arena) {
  kt_exit result = kt_open(&o->common, o->model, &o->holds, &o->sets, &server->pose);
  if (result == KT_DONE)
    result = set_rates(o, &server->pose, arena);
  if (result == KT_DONE)
    result = add_crossings(o, "event", false, server, arena);
  if (result == KT_DONE)
    result = add_crossings(o, "stop", true, server, arena);
  if (result == KT_DONE)
    result = read(o, server->pose.model, "frame", arena, &server->frames);
  return result == KT_DONE ? create_session(o, server, arena) : result;
}

static kt_exit open_and_serve(const serve_options *o) {
  km_arena arena = {0};
  ksim_server server = {.common = &o->common, .path = o->model};
  FILE *in = stdin, *out = stdout;
  kt_exit result = open_session(o, &server, &arena);
  if (result == KT_DONE && o->socket && !ksim_accept(&o->common, o->socket, &in, &out))
    result = KT_USAGE;
  if (result == KT_DONE) {
    serve(&server, in, out);
    report_times(&server);
    result = report_limits(o, &server);
  }
  if (o->socket && in && out) {
    fclose(in);
    fclose(out);
  }
  km_session_free(server.session);
  kt_close(&server.pose);
  km_arena_free(&arena);
  return result;
}

kt_exit ksim_serve(int argc, char **argv) {
  static const char *const of_run[] = {"rate",       "event",       "stop",          "frame",
                                       "integrator", "limit-stops", "ignore-limits", NULL};
  serve_options o = {.common = KT_COMMON("ksim")};
  kt_options all = {.operand = {"model", "MODEL", true, &o.model, NULL}};
  const kt_option table[] = {
      {"step", 0, "DT", "Length of a step: 1ms (default), 50us, or a number in the model's time unit", KT_TEXT, &o.step,
       KT_ABOUT_METHOD},
      {"socket", 0, "PLACE",
       "Serve one client at a Unix socket (a path) or a TCP port of this machine (a number), instead of the standard "
       "input and output",
       KT_TEXT, &o.socket, KT_ABOUT_FILES},
      KT_SET(&o.sets, KT_SET_FIRST),
      KT_HOLD(&o.holds, KT_HOLD_RIGID),
      KT_MODE(o.common),
      KT_POSE(o.common),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_question_some(&all, &o.asked, "run", of_run);
  kt_question_explain(&all, "rate", "JOINT=RATE", "Rate at the start, instead of the model's: A=60rpm (repeatable)");
  kt_question_explain(&all, "stop", "JOINT=VALUE",
                      "End a step where a joint passes a value; the next one completes it (repeatable)");
  kt_question_explain(&all, "frame", "BODY/FRAME", "Take loads on a frame, and reply its motion (repeatable)");
  kt_question_explain(&all, "integrator", "NAME", "fixed (default: bounded work in every step), adams or bdf");
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "Steps one by one for a controller, hardware or a co-simulation: reads requests and writes replies, one line of JSON "
      "each. The first line describes the session."
      "\vRequest, every key optional: {\"step\": 1, \"force\": {JOINT: F}, \"load\": {BODY/FRAME: [fx, fy, fz, tx, ty, "
      "tz]}, \"reference\": {CONTROLLER: r}, \"rate\": {JOINT: v}, \"quit\": true}. Inputs act until they are set again; "
      "a reference of null is that of the model. Reply: t; q, v, a by joint; frames (origin, axes by rows, velocity, "
      "angular_velocity); passed, the events since the last reply; or error, and nothing has moved. Exit status 4 if the "
      "run can't go on, 1 if a step passes a limit where no stop acts. At the end the tool tells how long its steps took.",
      argc, argv);
  return open_and_serve(&o);
}
