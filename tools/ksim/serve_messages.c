/* Requests and replies of a session (docs/simulation.md).
 *
 *   request: {"step": N, "force": {JOINT: F}, "load": {FRAME: [fx, fy, fz, tx, ty, tz]}, "reference": {MODULE: r or null},
 *             "rate": {JOINT: v}, "quit": true}, each key optional; one step where "step" is missing
 *   reply  : {"t", "q", "v", "a", "f", "frames", "modules", "passed"} or {"error"} */
#include "ksim/serve.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

#include <math.h>
#include <string.h>

enum { MOST_STEPS = 1000000 };

void ksim_describe(const ksim_server *server, km_text *out) {
  const km_model *model = server->pose.model;
  const km_units units = km_model_units(model);
  km_arena arena = {0};
  km_value *root = km_value_add(&arena, NULL, NULL, KM_OBJECT);
  km_value_string(&arena, root, "model", server->path);
  km_value_number(&arena, root, "step", server->step);
  km_value *used = km_value_add(&arena, root, "units", KM_OBJECT);
  km_value_string(&arena, used, "time", units.time->suffix);
  km_value_string(&arena, used, "length", units.length->suffix);
  km_value_string(&arena, used, "force", units.force->suffix);
  km_value *joints = km_value_add(&arena, root, "joints", KM_OBJECT);
  for (int c = 0; c < km_model_coordinate_count(model); ++c)
    km_value_string(&arena, joints, km_model_coordinate_label(model, c), km_model_coordinate_unit(model, c));
  km_value *frames = km_value_add(&arena, root, "frames", KM_LIST);
  for (int i = 0; i < server->frames.count; ++i)
    km_value_string(&arena, frames, NULL, server->frames.points[i].name);
  km_value *modules = km_value_add(&arena, root, "modules", KM_LIST);
  for (int i = 0; i < km_model_module_count(model); ++i)
    km_value_string(&arena, modules, NULL, km_model_module_name(model, i));
  km_json_write_line(arena.failed ? NULL : root, out);
  km_arena_free(&arena);
}

/* Sets one input, named by the member's key. */
typedef km_status (*set_input)(const ksim_server *server, const km_value *member, km_error *error);

static km_status expect_number(const km_value *member, km_error *error) {
  return member->kind == KM_NUMBER ? KM_OK : km_fail(error, KM_USAGE, "\"%s\": expected a number", member->key);
}

/* Sets a number of the coordinate that the key names. */
static km_status set_coordinate(const ksim_server *server, const km_value *member,
                                km_status (*set)(km_session *, int, double, km_error *), km_error *error) {
  int coordinate;
  km_status status = km_model_find_coordinate(server->pose.model, member->key, &coordinate, error);
  if (!status)
    status = expect_number(member, error);
  return status ? status : set(server->session, coordinate, member->number, error);
}

static km_status set_force(const ksim_server *server, const km_value *member, km_error *error) {
  return set_coordinate(server, member, km_session_set_force, error);
}

static km_status set_rate(const ksim_server *server, const km_value *member, km_error *error) {
  return set_coordinate(server, member, km_session_set_rate, error);
}

static km_status set_reference(const ksim_server *server, const km_value *member, km_error *error) {
  int module = km_model_find_module(server->pose.model, member->key);
  if (module < 0)
    return km_fail(error, KM_USAGE, "no force module is called \"%s\"", member->key);
  km_status status = member->kind == KM_NULL ? KM_OK : expect_number(member, error);
  double value = member->kind == KM_NULL ? nan("") : member->number;
  return status ? status : km_session_set_reference(server->session, module, value, error);
}

static km_status set_load(const ksim_server *server, const km_value *member, km_error *error) {
  const km_option_value *frames = &server->frames;
  double wrench[6];
  int index = 0, count = 0;
  while (index < frames->count && strcmp(frames->points[index].name, member->key) != 0)
    ++index;
  if (index == frames->count)
    return km_fail(error, KM_USAGE, "frame \"%s\" isn't one of --frame", member->key);
  for (const km_value *part = member->first; part && member->kind == KM_LIST; part = part->next, ++count)
    if (count < 6 && part->kind == KM_NUMBER)
      wrench[count] = part->number;
    else
      count = 6;
  if (count != 6)
    return km_fail(error, KM_USAGE, "load of \"%s\": expected six numbers, force and moment", member->key);
  return km_session_set_wrench(server->session, index, wrench, error);
}

static km_status set_all(const ksim_server *server, const km_value *request, const char *key, set_input set,
                         km_error *error) {
  const km_value *inputs = km_value_get(request, key);
  km_status status = KM_OK;
  if (inputs && inputs->kind != KM_OBJECT)
    return km_fail(error, KM_USAGE, "\"%s\": expected an object of names and values", key);
  for (const km_value *member = inputs ? inputs->first : NULL; member && !status; member = member->next)
    status = set(server, member, error);
  return status;
}

/* The keys of a request, and how their values are set; NULL: by ksim_reply itself. */
static const struct {
  const char *key;
  set_input set;
} keys[] = {{"step", NULL},    {"quit", NULL}, {"force", set_force}, {"load", set_load}, {"reference", set_reference},
            {"rate", set_rate}};
enum { KEYS = sizeof keys / sizeof *keys };

static km_status check_keys(const km_value *request, km_error *error) {
  for (const km_value *member = request->first; member; member = member->next) {
    bool is_known = false;
    for (int i = 0; i < KEYS; ++i)
      is_known = is_known || strcmp(member->key, keys[i].key) == 0;
    if (!is_known)
      return km_fail(error, KM_USAGE, "unknown key \"%s\"; expected step, force, load, reference, rate or quit",
                     member->key);
  }
  return KM_OK;
}

static km_status read_steps(const km_value *request, int *out, km_error *error) {
  const km_value *step = km_value_get(request, "step");
  *out = 1;
  if (!step)
    return KM_OK;
  if (step->kind != KM_NUMBER || !(step->number >= 0.0) || step->number > MOST_STEPS ||
      step->number != floor(step->number))
    return km_fail(error, KM_USAGE, "\"step\": expected a whole number from 0 to %d", MOST_STEPS);
  *out = (int)step->number;
  return KM_OK;
}

static km_status make_steps(ksim_server *server, int count, km_error *error) {
  km_status status = KM_OK;
  for (int i = 0; i < count && !status; ++i) {
    double start = kt_clock();
    status = km_session_step(server->session, 1, error);
    double spent = kt_clock() - start;
    server->steps++;
    server->total += spent;
    server->longest = fmax(server->longest, spent);
  }
  return status == KM_PARTIAL ? KM_OK : status;
}

static void add_coordinates(const ksim_server *server, km_value *root, const char *key,
                            double (*get)(const km_state *, int), km_arena *arena) {
  const km_model *model = server->pose.model;
  km_value *object = km_value_add(arena, root, key, KM_OBJECT);
  for (int c = 0; c < km_model_coordinate_count(model); ++c)
    km_value_number(arena, object, km_model_coordinate_label(model, c), get(km_session_state(server->session), c));
}

static void add_frames(const ksim_server *server, km_value *root, km_arena *arena) {
  km_value *frames = km_value_add(arena, root, "frames", KM_OBJECT);
  for (int i = 0; i < server->frames.count; ++i) {
    km_frame_motion motion = km_session_frame(server->session, i);
    km_value *frame = km_value_add(arena, frames, server->frames.points[i].name, KM_OBJECT);
    km_value_numbers(arena, frame, "origin", motion.origin, 3);
    km_value_numbers(arena, frame, "axes", motion.axes, 9);
    km_value_numbers(arena, frame, "velocity", motion.velocity, 3);
    km_value_numbers(arena, frame, "angular_velocity", motion.angular_velocity, 3);
  }
}

/* Crossings since the last reply. */
static void add_passed(ksim_server *server, km_value *root, km_arena *arena) {
  const km_simulation *run = km_session_run(server->session);
  km_value *passed = km_value_add(arena, root, "passed", KM_LIST);
  for (; server->crossings_told < km_simulation_crossing_count(run); ++server->crossings_told) {
    km_crossing_met met = km_simulation_crossing(run, server->crossings_told);
    const km_crossing *crossing = &server->crossings[met.crossing];
    km_value *one = km_value_add(arena, passed, NULL, KM_OBJECT);
    km_value_string(arena, one, "joint", km_model_coordinate_label(server->pose.model, crossing->coordinate));
    km_value_number(arena, one, "value", crossing->value);
    km_value_number(arena, one, "t", met.time);
    km_value_string(arena, one, "sense", met.sense > 0 ? "up" : "down");
  }
}

static const km_value *motion(ksim_server *server, km_arena *arena) {
  km_value *root = km_value_add(arena, NULL, NULL, KM_OBJECT);
  km_value_number(arena, root, "t", km_session_time(server->session));
  add_coordinates(server, root, "q", km_state_coordinate, arena);
  add_coordinates(server, root, "v", km_state_rate, arena);
  add_coordinates(server, root, "a", km_state_acceleration, arena);
  if (server->frames.count > 0)
    add_frames(server, root, arena);
  if (server->crossing_count > 0)
    add_passed(server, root, arena);
  return arena->failed ? NULL : root;
}

/* Sets the inputs of a request and makes its steps. */
static km_status handle(ksim_server *server, const char *text, size_t size, km_arena *arena, km_error *error) {
  const km_value *request;
  int steps = 0;
  km_status status = km_json_parse(text, size, arena, &request, error);
  if (!status && request->kind != KM_OBJECT)
    status = km_fail(error, KM_USAGE, "a request is an object, {…}");
  if (!status)
    status = check_keys(request, error);
  if (!status)
    status = read_steps(request, &steps, error);
  for (int i = 0; i < KEYS && !status; ++i)
    if (keys[i].set)
      status = set_all(server, request, keys[i].key, keys[i].set, error);
  if (status)
    return status;
  const km_value *quit = km_value_get(request, "quit");
  server->is_over = quit && quit->number != 0.0;
  return server->is_over ? KM_OK : make_steps(server, steps, error);
}

void ksim_reply(ksim_server *server, const char *request, size_t size, km_text *out) {
  km_arena arena = {0};
  km_error error;
  km_status status = handle(server, request, size, &arena, &error);
  const km_value *reply;
  if (status) {
    km_value *root = km_value_add(&arena, NULL, NULL, KM_OBJECT);
    km_value_string(&arena, root, "error", error.text);
    reply = root;
  } else {
    reply = motion(server, &arena);
  }
  if (status == KM_DIVERGED || status == KM_MEMORY) {
    server->is_over = true;
    server->result = kt_exit_of(status);
  }
  out->failed = out->failed || arena.failed;
  km_json_write_line(arena.failed ? NULL : reply, out);
  km_arena_free(&arena);
}
