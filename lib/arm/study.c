/* Path studies: reading one, and binding it to a mechanism. */
#include "arm/study.h"

#include "arm/selfmotion/branches.h"
#include "base/check.h"
#include "exchange/json/format.h"
#include "exchange/json/json.h"

#include <string.h>

/* `status`, unless the fault is in an option. */
static km_status first_error(const km_messages *messages, size_t from, km_status status, km_error *error) {
  for (size_t i = from; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, strncmp(km_messages_text(messages, i), "--", 2) == 0 ? KM_USAGE : status, "%s",
                     km_messages_text(messages, i));
  return km_fail(error, status, "the study is faulty");
}

static km_status read(km_study *study, const char *bytes, size_t size, km_messages *messages, km_error *error) {
  size_t had = km_messages_count(messages), errors = km_messages_errors(messages);
  km_status status = km_json_parse(bytes, size, &study->arena, &study->root, error);
  if (status)
    return status;
  km_format_check_as(study->root, &km_format_study, NULL, messages);
  return km_messages_errors(messages) > errors ? first_error(messages, had, KM_MODEL, error) : KM_OK;
}

km_status km_study_read(const char *bytes, size_t size, const char *folder, km_messages *messages, km_study **out,
                        km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_given(bytes && folder, "text or folder of a study", error);
  if (fits)
    return fits;
  km_study *study = KM_NEW(km_study, 1);
  if (!study)
    return km_fail(error, KM_MEMORY, "out of memory for a study");
  study->folder = km_arena_string(&study->arena, folder);
  km_messages *found = messages ? messages : km_messages_create();
  km_status status = study->folder && found ? read(study, bytes, size, found, error)
                                            : km_fail(error, KM_MEMORY, "out of memory for a study");
  if (!messages)
    km_messages_free(found);
  if (status) {
    km_study_free(study);
    return status;
  }
  *out = study;
  return KM_OK;
}

void km_study_free(km_study *study) {
  if (!study)
    return;
  km_path_free(study->path);
  km_arm_free(study->arm);
  km_arena_free(&study->arena);
  km_free(study);
}

const char *km_study_model(const km_study *study) {
  if (!study)
    return NULL;
  return km_reader_string(study->root, "model");
}

/* Reads one study against one mechanism. */
typedef struct binder {
  km_study *study;
  const km_mechanism *mechanism;
  const km_state *state;
  const km_study_changes *changes;
  unsigned long seed;
  km_reader reader;
  int *order; /* [n] arm's columns in the order of q0 and rates */
} binder;

/* The change, or the study's own member. */
static const km_value *member(const binder *b, const km_study_change *change, const char *key, km_place *place) {
  if (change->value) {
    *place = (km_place){NULL, change->place, 0};
    return change->value;
  }
  *place = (km_place){NULL, key, 0};
  return km_value_get(b->study->root, key);
}

static bool find_effector(binder *b) {
  const km_model *model = b->mechanism->model;
  const km_value *path = km_value_get(b->study->root, "effector");
  km_place place = {NULL, "effector", 0};
  km_error error;
  b->study->effector = b->changes->effector;
  if (b->study->effector >= 0)
    return true;
  if (!path) {
    km_reader_error(
        &b->reader, &place,
        "is missing; expected the frame that follows the path, as [\"%s\", \"tool\"] (or --effector BODY/FRAME)",
        model->body_count > 1 ? model->bodies[model->body_count - 1].name : "flange");
    return false;
  }
  if (km_effector_find(model, path, &b->study->arena, &b->study->effector, &error))
    return true;
  km_reader_error(&b->reader, &place, "%s", error.text);
  return false;
}

static bool find_task(binder *b) {
  static const char *const words[] = {"pose", "position", "axis"};
  km_place place;
  const km_value *value = member(b, &b->changes->task, "task", &place);
  b->study->task = KM_TASK_POSE;
  for (int k = 0; value && k < 3; ++k)
    if (strcmp(value->string, words[k]) == 0) {
      b->study->task = (km_task)k;
      return true;
    }
  if (value)
    km_reader_error(&b->reader, &place, "\"%.40s\" is not a task; expected pose, position or axis", value->string);
  return !value;
}

static bool make_arm(binder *b) {
  km_error error;
  km_place place = {NULL, "effector", 0};
  if (!find_effector(b) || !find_task(b))
    return false;
  if (!km_arm_create(b->mechanism, b->state, b->study->effector, b->study->task, &b->study->arm, &error))
    return true;
  km_reader_error(&b->reader, &place, "%s", error.text);
  return false;
}

static int column_named(const km_arm *a, const char *label) {
  for (int k = 0; k < a->n; ++k)
    if (strcmp(km_arm_label(a, k), label) == 0)
      return k;
  return -1;
}

static bool read_order(binder *b) {
  const km_arm *a = b->study->arm;
  const km_value *list = km_value_get(b->study->root, "coordinates");
  km_place place = {NULL, "coordinates", 0}, item = {&place, NULL, 0};
  b->order = KM_ARENA_NEW(&b->study->arena, int, (size_t)a->n);
  bool fine = b->order != NULL, seen[KM_ARM_MOST] = {false};
  for (int k = 0; k < a->n && fine; ++k)
    b->order[k] = k;
  if (!list || !fine)
    return fine;
  if (list->kind != KM_LIST || list->count != (size_t)a->n) {
    km_reader_error(&b->reader, &place, "found %zu joints; expected the %d on the way to the effector, from %s to %s",
                    list->kind == KM_LIST ? list->count : 1, a->n, km_arm_label(a, 0), km_arm_label(a, a->n - 1));
    return false;
  }
  for (const km_value *v = list->first; v; v = v->next, ++item.index) {
    int k = column_named(a, v->string);
    if (k < 0)
      km_reader_error(&b->reader, &item, "\"%.80s\" is no joint on the way to the effector; expected one from %s to %s",
                      v->string, km_arm_label(a, 0), km_arm_label(a, a->n - 1));
    else if (seen[k])
      km_reader_error(&b->reader, &item, "\"%.80s\" is given twice; expected each joint once", v->string);
    fine = fine && k >= 0 && !seen[k];
    if (k >= 0) {
      seen[k] = true;
      b->order[item.index] = k;
    }
  }
  return fine;
}

/* Numbers in the order of `coordinates`, into the arm's: out[n]. */
static bool read_numbers(binder *b, const km_value *list, const km_place *place, double *out) {
  const km_arm *a = b->study->arm;
  if (list->kind != KM_LIST || list->count != (size_t)a->n) {
    km_reader_error(&b->reader, place, "found %zu values; expected %d, one for each joint from %s to %s",
                    list->kind == KM_LIST ? list->count : 1, a->n, km_arm_label(a, 0), km_arm_label(a, a->n - 1));
    return false;
  }
  int i = 0;
  for (const km_value *v = list->first; v; v = v->next)
    out[b->order[i++]] = v->number;
  return true;
}

static bool read_rates(binder *b) {
  km_place place;
  const km_value *list = member(b, &b->changes->rates, "rates", &place);
  double rates[KM_ARM_MOST];
  km_error error;
  if (!list)
    return true;
  if (!read_numbers(b, list, &place, rates))
    return false;
  if (!km_arm_set_rates(b->study->arm, rates, b->study->arm->n, &error))
    return true;
  km_reader_error(&b->reader, &place, "%s", error.text);
  return false;
}

/* q0 in the arm's units; the state's pose if none is given. */
static bool read_q0(binder *b, double *q) {
  const km_arm *a = b->study->arm;
  km_place place;
  const km_value *list = member(b, &b->changes->q0, "q0", &place);
  double given[KM_ARM_MOST];
  if (list && !read_numbers(b, list, &place, given))
    return false;
  for (int k = 0; k < a->n; ++k)
    q[k] = list ? km_arm_read(a, k, given[k]) : b->state->q[a->coordinate[k]] / a->unit[k];
  int out = list ? km_arm_limit_passed(a, q) : -1;
  if (out >= 0)
    km_reader_error(&b->reader, &place, "%s at %s is outside its limits; expected %s to %s", km_arm_label(a, out),
                    KM_SHOWN(km_arm_shown(a, out, q[out])), KM_SHOWN(km_arm_shown(a, out, a->low[out])),
                    KM_SHOWN(km_arm_shown(a, out, a->high[out])));
  return out < 0;
}

static bool read_path(binder *b, const double *q) {
  const km_arm *a = b->study->arm;
  km_arm_space space;
  km_place place;
  const km_value *value = member(b, &b->changes->path, "path", &place);
  if (!value && b->changes->path_optional)
    return true;
  if (!value) {
    km_reader_error(&b->reader, &place, "is missing; expected the path to follow");
    return false;
  }
  size_t errors = km_messages_errors(b->reader.messages);
  if (b->changes->path.value)
    km_format_check_as(value, &km_format_path, &place, b->reader.messages);
  if (km_messages_errors(b->reader.messages) > errors)
    return false;
  if (!km_arm_space_create(a, &space))
    return false;
  km_arm_update(a, &space, q);
  const char *folder = b->changes->path.value ? b->changes->path_folder : b->study->folder;
  b->study->path = km_path_read(&b->reader, a, value, &place, &space.pose, folder);
  km_arm_space_free(&space);
  return b->study->path != NULL;
}

/* From q to the first pose of the path. That this fails is the track's first finding, not a fault of the study. */
static void find_start(binder *b, const double *q) {
  km_study *s = b->study;
  const km_arm *a = s->arm;
  double start[KM_ARM_MOST];
  memcpy(start, q, (size_t)a->n * sizeof *q);
  if (s->path)
    s->start_status = km_arm_nearest(a, &s->path->points[0].pose, q, b->seed, NULL, NULL, start, &s->start_error);
  for (int k = 0; k < a->n; ++k) {
    double moved = start[k] - q[k];
    if (fabs(moved) < 1e-11)
      start[k] = q[k]; /* was there already */
    s->start_moved = fmax(s->start_moved, fabs(moved));
    s->start[k] = s->start_status ? (double)NAN : km_arm_shown(a, k, start[k]);
  }
}

static bool read_methods(binder *b) {
  static const km_value plain = {.kind = KM_STRING, .string = "greedy"};
  km_place methods_at, objective_at;
  const km_value *methods = member(b, &b->changes->methods, "methods", &methods_at);
  const km_value *objective = member(b, &b->changes->objective, "objective", &objective_at);
  km_study *s = b->study;
  s->objective = km_objective_of(KM_PATH_CONTROL);
  bool fine = km_methods_read(&b->reader, s->arm, methods ? methods : &plain, &methods_at, &s->arena, &s->methods,
                              &s->method_count);
  return (!objective || km_objective_read(&b->reader, objective, &objective_at, &s->objective)) && fine;
}

static bool bind(binder *b) {
  double q[KM_ARM_MOST];
  if (!make_arm(b) || !read_order(b))
    return false;
  b->study->start = KM_ARENA_NEW(&b->study->arena, double, (size_t)b->study->arm->n);
  if (!b->study->start)
    return false;
  bool fine = read_rates(b);
  fine = read_methods(b) && fine;
  if (!read_q0(b, q) || !read_path(b, q) || !fine)
    return false;
  find_start(b, q);
  return true;
}

km_status km_study_bind_as(km_study *study, const km_mechanism *mechanism, const km_state *state,
                           const km_study_changes *changes, unsigned long seed, km_messages *messages,
                           km_error *error) {
  binder b = {.study = study, .mechanism = mechanism, .state = state, .changes = changes, .seed = seed};
  b.reader.messages = messages ? messages : km_messages_create();
  if (!b.reader.messages)
    return km_fail(error, KM_MEMORY, "out of memory for a study");
  size_t had = km_messages_count(b.reader.messages), errors = km_messages_errors(b.reader.messages);
  km_status status = KM_OK;
  if (!bind(&b))
    status = km_messages_errors(b.reader.messages) > errors
                 ? first_error(b.reader.messages, had, b.reader.unreadable ? KM_IO : KM_MODEL, error)
                 : km_fail(error, KM_MEMORY, "out of memory for a study");
  if (!messages)
    km_messages_free(b.reader.messages);
  if (!status && study->start_status)
    return km_fail(error, study->start_status, "%s", study->start_error.text);
  return status;
}

km_status km_study_bind(km_study *study, const km_mechanism *mechanism, const km_state *state, unsigned long seed,
                        km_messages *messages, km_error *error) {
  km_status fits = km_check_given(study != NULL, "study", error);
  if (!fits)
    fits = km_check_state(mechanism, state, error);
  if (!fits && study->arm)
    fits = km_fail(error, KM_USAGE, "the study is bound to a mechanism already");
  if (fits)
    return fits;
  const km_study_changes none = {.effector = -1};
  return km_study_bind_as(study, mechanism, state, &none, seed, messages, error);
}

const km_arm *km_study_arm(const km_study *study) {
  if (!study)
    return NULL;
  return study->arm;
}

int km_study_methods(const km_study *study) {
  if (!study)
    return 0;
  return study->method_count;
}

km_track_plan km_study_plan(const km_study *study, int method) {
  if (!study || method < 0 || method >= study->method_count)
    return (km_track_plan){0};
  return (km_track_plan){.path = study->path,
                         .start = study->start,
                         .method = study->methods[method],
                         .objective = study->objective,
                         .jobs = 1,
                         .seed = 1};
}
