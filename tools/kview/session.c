/* Session of a page: reading, compiling, moving to a configuration. */
#include "kview/session.h"

#include "kmech/base.h"
#include "kmech/continuation.h"
#include "kmech/rounding.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Objects made from a model. */
typedef struct compiled {
  km_mechanism *mechanism;
  km_state *state, *probe;
  km_manipulation *hand;
} compiled;

static void drop(compiled *c) {
  km_manipulation_free(c->hand);
  km_state_free(c->probe);
  km_state_free(c->state);
  km_mechanism_free(c->mechanism);
  *c = (compiled){0};
}

static km_status follow(const compiled *c, km_mobility *mobility) {
  km_poses_compute(c->mechanism, c->state);
  return km_mobility_compute(c->mechanism, c->state, mobility);
}

/* Compiles with holds; q: where to start from, NULL: the model's own pose. */
static km_status compile(const km_model *model, const km_hold *holds, int count, const double *q, compiled *out,
                         km_mobility *mobility, km_error *error) {
  km_assembly evidence;
  *out = (compiled){0};
  km_status status;
  if (q) {
    status = km_mechanism_compile(model, holds, count, &out->mechanism, error);
    if (!status)
      status = km_state_create(out->mechanism, &out->state, error);
    if (!status)
      status = km_state_set_coordinates(out->mechanism, out->state, q, error);
    if (!status)
      status = km_assemble(out->mechanism, out->state, &evidence, error);
  } else {
    status = km_mechanism_compile_at(model, holds, count, NULL, 0, &out->mechanism, &out->state, error);
  }
  if (!status)
    status = km_state_create(out->mechanism, &out->probe, error);
  if (!status)
    status = follow(out, mobility);
  if (!status)
    status = km_manipulation_create(out->mechanism, out->state, &out->hand, error);
  if (status)
    drop(out);
  return status;
}

static void forget_question(kv_session *s) {
  km_question_free(s->question);
  s->question = NULL;
  free(s->modes);
  s->modes = NULL;
  s->mode_count = 0;
}

static void adopt(kv_session *s, compiled *c) {
  compiled old = {s->mechanism, s->state, s->probe, s->hand};
  forget_question(s);
  kv_map_stop(s);
  km_space_map_free(&s->map);
  s->map = (km_space_map){0};
  s->mechanism = c->mechanism;
  s->state = c->state;
  s->probe = c->probe;
  s->hand = c->hand;
  s->move = (km_manipulation_step){.coordinate = -1, .is_reached = true};
  drop(&old);
}

static void forget_undo(kv_session *s) {
  for (int i = 0; i < s->undo_count; ++i)
    free(s->undo[i].numbers);
  s->undo_count = s->undo_at = 0;
}

static struct timespec written(const char *path) {
  struct stat there;
  return stat(path, &there) == 0 ? there.st_mtim : (struct timespec){0, 0};
}

bool kv_session_is_stale(const kv_session *s) {
  struct timespec now = written(s->opening.path);
  return now.tv_sec != 0 && (now.tv_sec != s->changed.tv_sec || now.tv_nsec != s->changed.tv_nsec);
}

/* The model of the file's bytes, in the requested configuration. */
static km_status make_model(kv_session *s, const km_text *file, km_messages *messages, km_model **out,
                            km_error *error) {
  km_read_def def = {
      .file = s->opening.path, .floating = s->opening.floating, .closure_tolerance = s->opening.closure_tolerance};
  km_status status = km_model_read_as(file->data ? file->data : "", file->size, &def, messages, out, error);
  int pose;
  if (!status && !s->opening.exact)
    status = km_model_idealise(*out, false, messages, NULL, error);
  if (!status && s->opening.pose) {
    status = km_model_find_pose(*out, s->opening.pose, &pose, error);
    if (!status)
      status = km_model_apply_pose(*out, pose, error);
  }
  return status;
}

/* The model and its parameters, of one reading: the standard input has no second one. */
static km_status read_file(kv_session *s, km_messages *messages, km_model **out, kv_parameters *parameters,
                           km_error *error) {
  km_text file = {0};
  km_status status = km_file_read(s->opening.path, &file, error);
  if (!status)
    status = make_model(s, &file, messages, out, error);
  if (!status)
    status = kv_parameters_read(&file, parameters, error);
  km_text_free(&file);
  return status;
}

/* The values at which a coordinate of the old model of that name was held, in the new one. */
static int carry_holds(const kv_session *s, const km_model *model, km_hold *out) {
  int count = 0;
  for (int h = 0; h < s->hold_count; ++h) {
    km_error error;
    const char *label = km_model_coordinate_label(s->model, s->holds[h].coordinate);
    if (!km_model_find_coordinate(model, label, &out[count].coordinate, &error))
      out[count++].value = s->holds[h].value;
  }
  return count;
}

static int *find_origins(const km_model *model) {
  int *origin = malloc((size_t)(km_model_body_count(model) + 1) * sizeof *origin);
  for (int f = km_model_frame_count(model); origin && f-- > 0;)
    origin[km_model_frame_body(model, f)] = f; /* the first of each body */
  return origin;
}

/* The model's own holds at the first reading; later those that the page has. */
static int first_holds(const kv_session *s, const km_model *model, km_hold *out) {
  if (s->model)
    return carry_holds(s, model, out);
  for (int h = 0; h < km_model_hold_count(model); ++h)
    out[h] = km_model_hold_at(model, h);
  return km_model_hold_count(model);
}

km_status kv_session_load(kv_session *s, km_error *error) {
  compiled made = {0};
  km_mobility mobility;
  km_model *model = NULL;
  km_messages *messages = km_messages_create();
  s->changed = written(s->opening.path);
  kv_parameters parameters = {0};
  km_status status =
      messages ? read_file(s, messages, &model, &parameters, error) : km_fail(error, KM_MEMORY, "out of memory");
  size_t room = status ? 0 : (size_t)km_model_coordinate_count(model) + 1;
  km_hold *holds = status ? NULL : calloc(room, sizeof *holds);
  int *origin = status ? NULL : find_origins(model);
  double *places = status ? NULL : kv_frame_places(model), *own = status ? NULL : kv_frame_places(model);
  int count = 0;
  if (!status && (!holds || !origin || !places || !own))
    status = km_fail(error, KM_MEMORY, "out of memory");
  if (!status) {
    count = first_holds(s, model, holds);
    status = compile(model, holds, count, NULL, &made, &mobility, error);
  }
  if (status) {
    kv_parameters_free(&parameters);
    free(holds);
    free(origin);
    free(places);
    free(own);
    km_model_free(model);
    km_messages_free(messages);
    return status;
  }
  forget_undo(s);
  adopt(s, &made);
  km_model_free(s->model);
  km_messages_free(s->messages);
  free(s->holds);
  free(s->origin);
  free(s->file_places);
  free(s->own_places);
  kv_parameters_free(&s->parameters);
  s->model = model;
  s->messages = messages;
  s->holds = holds;
  s->hold_count = count;
  s->origin = origin;
  s->file_places = places;
  s->own_places = own;
  s->parameters = parameters;
  s->file_length = km_mechanism_characteristic_length(s->mechanism, NULL);
  s->mobility = mobility;
  s->edited = s->unsaved = false;
  s->asked.kind = -1;
  return kv_session_mark(s, error);
}

void kv_session_close(kv_session *s) {
  compiled none = {0};
  adopt(s, &none);
  forget_undo(s);
  km_model_free(s->model);
  km_messages_free(s->messages);
  free(s->holds);
  free(s->origin);
  free(s->file_places);
  free(s->own_places);
  kv_parameters_free(&s->parameters);
  *s = (kv_session){.opening = s->opening};
}

double *kv_session_coordinates(const kv_session *s) {
  double *q = calloc((size_t)km_model_coordinate_count(s->model) + 1, sizeof *q);
  km_error error;
  if (q)
    km_state_coordinates(s->mechanism, s->state, q, &error);
  return q;
}

km_status kv_session_hold(kv_session *s, int coordinate, bool held, km_error *error) {
  int joint = km_model_coordinate_joint(s->model, coordinate), first, freedom, count = 0;
  if (joint < 0)
    return km_fail(error, KM_USAGE, "there is no coordinate %d", coordinate);
  freedom = km_model_joint_freedom(s->model, joint, &first);
  /* A rotation vector is held as a whole, so a joint always is. */
  km_hold *holds = calloc((size_t)km_model_coordinate_count(s->model) + 1, sizeof *holds);
  double *q = kv_session_coordinates(s);
  if (!holds || !q) {
    free(holds);
    free(q);
    return km_fail(error, KM_MEMORY, "out of memory");
  }
  for (int h = 0; h < s->hold_count; ++h)
    if (s->holds[h].coordinate < first || s->holds[h].coordinate >= first + freedom)
      holds[count++] = s->holds[h];
  for (int k = 0; held && k < freedom; ++k)
    holds[count++] = (km_hold){first + k, q[first + k]};
  compiled made;
  km_status status = compile(s->model, holds, count, q, &made, &s->mobility, error);
  free(q);
  if (status) {
    free(holds);
    return status;
  }
  adopt(s, &made);
  free(s->holds);
  s->holds = holds;
  s->hold_count = count;
  return KM_OK;
}

km_status kv_session_compile(kv_session *s, const double *q, km_error *error) {
  compiled made;
  km_status status = compile(s->model, s->holds, s->hold_count, q, &made, &s->mobility, error);
  if (!status)
    adopt(s, &made);
  return status;
}

km_status kv_session_set_model(kv_session *s, km_model *model, const double *q, km_error *error) {
  compiled made;
  km_status status = compile(model, s->holds, s->hold_count, q, &made, &s->mobility, error);
  if (status)
    return status;
  adopt(s, &made);
  km_model_free(s->model);
  s->model = model;
  return KM_OK;
}

void kv_session_note_edits(kv_session *s) {
  double *places = kv_frame_places(s->model);
  size_t size = 3 * (size_t)km_model_frame_count(s->model) * sizeof *places;
  s->edited = !places || kv_parameters_differ(&s->parameters) || memcmp(places, s->file_places, size) != 0;
  s->unsaved = s->edited;
  free(places);
}

void kv_session_follow(kv_session *s) {
  const compiled c = {s->mechanism, s->state, s->probe, s->hand};
  follow(&c, &s->mobility);
}

km_status kv_session_probe(kv_session *s, km_error *error) {
  km_assembly evidence;
  double *q = kv_session_coordinates(s);
  km_status status =
      q ? km_state_set_coordinates(s->mechanism, s->probe, q, error) : km_fail(error, KM_MEMORY, "out of memory");
  free(q);
  return status ? status : km_assemble(s->mechanism, s->probe, &evidence, error);
}

/* Past a million radians or characteristic lengths the rounding of a coordinate is larger than what loops are closed
 * to. */
static km_status check_size(const kv_session *s, const double *q, km_error *error) {
  static const double most = 1e6;
  for (int c = 0; c < km_model_coordinate_count(s->model); ++c) {
    bool length = km_model_coordinate_is_length(s->model, c);
    bool degrees = !length && strcmp(km_model_coordinate_unit(s->model, c), "deg") == 0;
    double size = length ? s->file_length : degrees ? 180.0 / M_PI : 1.0;
    if (!(fabs(q[c]) <= most * size))
      return km_fail(error, KM_USAGE, "found %g for %s; expected at most a million %s", q[c],
                     km_model_coordinate_label(s->model, c), length ? "characteristic lengths" : "radians");
  }
  return KM_OK;
}

km_status kv_session_place(kv_session *s, const double *q, km_error *error) {
  km_assembly evidence;
  km_status size = check_size(s, q, error);
  if (size)
    return size;
  double *before = kv_session_coordinates(s);
  km_error ignored;
  if (!before)
    return km_fail(error, KM_MEMORY, "out of memory");
  km_status status = km_state_set_coordinates(s->mechanism, s->state, q, error);
  if (!status)
    status = km_assemble(s->mechanism, s->state, &evidence, error);
  if (status) {
    km_state_set_coordinates(s->mechanism, s->state, before, &ignored);
    km_assemble(s->mechanism, s->state, &evidence, &ignored);
  }
  free(before);
  km_manipulation_release(s->hand);
  kv_session_follow(s);
  return status;
}
