/* The command for sessions: options, session, and the loop over requests. */
#include "ksim/serve.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct serve_options {
  ksim_options ksim; /* model, pose, rates, crossings, frames */
  const char *step, *socket;
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
    return kt_usage(&o->ksim.common, "--step", o->step, "a positive time, as 1ms");
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
    kt_print_message(&server->work->options->common, KM_NOTE,
                     "%ld steps: mean %.3g ms, longest %.3g ms of computing for a step of %.3g ms", server->steps,
                     1e3 * server->total / (double)server->steps, 1e3 * server->longest,
                     1e3 * server->step * km_model_units(server->work->pose.model).time->si);
}

static kt_exit create_session(const serve_options *o, ksim_server *server) {
  ksim_work *w = server->work;
  km_error error;
  km_session_def def = km_session_default(w->pose.model);
  if (o->ksim.integrator >= 0)
    def.simulation.integrator = (km_integrator)o->ksim.integrator;
  def.simulation.crossings = w->def.simulation.crossings;
  def.simulation.crossing_count = w->def.simulation.crossing_count;
  kt_exit result = read_step(o, w->pose.model, &def.step);
  int *frames = KM_NEW(int, (size_t)w->def.frame_count + 1);
  if (!frames)
    return KT_NO_MEMORY;
  for (int i = 0; i < w->def.frame_count; ++i)
    frames[i] = w->def.frames[i].frame;
  def.frames = frames;
  def.frame_count = w->def.frame_count;
  server->step = def.step;
  if (result == KT_DONE) {
    km_status status = km_session_create(w->pose.mechanism, w->pose.state, &def, &server->session, &error);
    if (status)
      kt_print_message(&o->ksim.common, KM_ERROR, "%s: %s", o->ksim.model, error.text);
    result = kt_exit_of(status);
  }
  km_free(frames);
  return result;
}

static kt_exit open_and_serve(serve_options *o) {
  ksim_work w = {.options = &o->ksim};
  ksim_server server = {.work = &w};
  FILE *in = stdin, *out = stdout;
  kt_exit result = kt_open(&o->ksim.common, o->ksim.model, &o->ksim.holds, &o->ksim.sets, &w.pose);
  if (result == KT_DONE) {
    w.def = km_history_default(w.pose.model);
    result = ksim_set_rates(&w);
  }
  if (result == KT_DONE)
    result = ksim_read_crossings(&w);
  if (result == KT_DONE)
    result = ksim_read_frames(&o->ksim.common, w.pose.model, &o->ksim.frames, &w.def.frames, &w.def.frame_count);
  if (result == KT_DONE)
    result = create_session(o, &server);
  if (result == KT_DONE && o->socket && !ksim_accept(&o->ksim.common, o->socket, &in, &out))
    result = KT_USAGE;
  if (result == KT_DONE) {
    serve(&server, in, out);
    report_times(&server);
    result = server.result;
  }
  if (o->socket && in && out) {
    fclose(in);
    fclose(out);
  }
  km_session_free(server.session);
  km_free(w.crossings);
  km_free((km_traced_frame *)w.def.frames);
  kt_close(&w.pose);
  return result;
}

kt_exit ksim_serve(int argc, char **argv) {
  serve_options o = {.ksim = {.common = KT_COMMON("ksim"), .integrator = -1}};
  ksim_options *k = &o.ksim;
  kt_options all = {.operand = {"model", "MODEL", true, &k->model, NULL}};
  const kt_option table[] = {
      {"step", 0, "DT", "Length of a step: 1ms (default), 50us, or a number in the model's time unit", KT_TEXT, &o.step,
       KT_ABOUT_METHOD},
      {"socket", 0, "PLACE",
       "Serve one client at a Unix socket (a path) or a TCP port of this machine (a number), instead of the standard "
       "input and output",
       KT_TEXT, &o.socket, KT_ABOUT_FILES},
      KT_SET(&k->sets, KT_SET_FIRST),
      {"rate", 0, "JOINT=RATE", "Rate at the start, instead of the model's: A=60rpm (repeatable)", KT_TEXTS, &k->rates,
       KT_ABOUT_MODEL},
      KT_HOLD(&k->holds, KT_HOLD_RIGID),
      KT_MODE(k->common),
      KT_POSE(k->common),
      {"event", 0, "JOINT=VALUE", "Tell when a joint passes a value (repeatable)", KT_TEXTS, &k->events,
       KT_ABOUT_MODEL},
      {"stop", 0, "JOINT=VALUE", "End a step where a joint passes a value; the next one completes it (repeatable)",
       KT_TEXTS, &k->stops, KT_ABOUT_MODEL},
      {"frame", 0, "BODY/FRAME", "Take loads on a frame, and reply its motion (repeatable)", KT_TEXTS, &k->frames,
       KT_ABOUT_MODEL},
      {"integrator", 0, "NAME", "fixed (default: bounded work in every step), adams or bdf",
       KT_WORD("adams or bdf or fixed"), &k->integrator, KT_ABOUT_METHOD},
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &k->common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "Steps one by one for a controller, hardware or a co-simulation: reads requests and writes replies, one line of JSON "
      "each. The first line describes the session."
      "\vRequest, every key optional: {\"step\": 1, \"force\": {JOINT: F}, \"load\": {BODY/FRAME: [fx, fy, fz, tx, ty, "
      "tz]}, \"reference\": {CONTROLLER: r}, \"rate\": {JOINT: v}, \"quit\": true}. Inputs act until they are set again; "
      "a reference of null is that of the model. Reply: t; q, v, a by joint; frames (origin, axes by rows, velocity, "
      "angular_velocity); passed, the events since the last reply; or error, and nothing has moved. Exit status 4 if the "
      "run can't go on. At the end the tool tells how long its steps took.",
      argc, argv);
  return open_and_serve(&o);
}
