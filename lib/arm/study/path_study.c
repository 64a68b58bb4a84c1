/* Path studies: binding of a definition to a mechanism. */
#include "arm/study/study_binding.h"

#include "arm/ik/ik_branches.h"
#include "base/arguments.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool km_binder_fault(km_binder *b, const km_study_place *place, const char *format, ...) {
  char text[KM_ERROR_TEXT];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  km_messages_add(b->messages, KM_ERROR, "%s: %s", place->text, text);
  if (!b->status)
    b->status = km_fail(b->error, place->option ? KM_USAGE : KM_MODEL, "%s: %s", place->text, text);
  return false;
}

bool km_binder_memory(km_binder *b) {
  b->status = km_fail(b->error, KM_MEMORY, "out of memory for a study");
  return false;
}

bool km_binder_pass(km_binder *b, const km_study_place *place, km_status status, const km_error *found) {
  if (status == KM_MEMORY) {
    b->status = km_fail(b->error, KM_MEMORY, "%s", found->text);
    return false;
  }
  return !status || km_binder_fault(b, place, "%s", found->text);
}

/* Finds the effector's frame, by index or by its names. */
static bool find_effector(km_binder *b, int *frame) {
  const km_model *model = b->mechanism->model;
  const km_study_names *names = &b->def->effector;
  km_error error;
  *frame = b->def->frame;
  if (*frame >= 0)
    return true;
  if (names->count > 0)
    return km_binder_pass(b, &names->place,
                          km_model_find_frame(model, names->items, (size_t)names->count, frame, &error), &error);
  return km_binder_fault(
      b, &names->place,
      "found none; expected the frame that follows the path, as [\"%s\", \"tool\"] (or --effector BODY/FRAME)",
      model->body_count > 1 ? model->bodies[model->body_count - 1].name : "flange");
}

static bool make_arm(km_binder *b) {
  int frame;
  km_error error;
  if (!find_effector(b, &frame))
    return false;
  km_status status = km_arm_create(b->mechanism, b->state, frame, b->def->task, &b->study->arm, &error);
  return km_binder_pass(b, &b->def->effector.place, status, &error);
}

/* Finds the start by inverse kinematics from q to the first pose of the path. Failure isn't a fault of the study:
 * its tracks then end at their start. */
static void find_start(km_binder *b, const double *q) {
  km_study *s = b->study;
  const km_arm *a = s->arm;
  double start[KM_ARM_MAX_JOINTS];
  memcpy(start, q, (size_t)a->n * sizeof *q);
  if (s->path)
    s->start_status = km_arm_nearest(a, &s->path->points[0].pose, q, b->seed, NULL, NULL, start, &s->start_error);
  for (int k = 0; k < a->n; ++k) {
    double moved = start[k] - q[k];
    if (fabs(moved) < 1e-11)
      start[k] = q[k]; /* q was a solution already */
    s->start_moved = fmax(s->start_moved, fabs(moved));
    s->start[k] = s->start_status ? (double)NAN : km_arm_to_units(a, k, start[k]);
  }
}

/* Binds order, rates, methods, start and path, and finds the start by inverse kinematics. */
static bool bind_parts(km_binder *b) {
  double q[KM_ARM_MAX_JOINTS];
  if (!make_arm(b) || !km_bind_order(b))
    return false;
  b->study->start = KM_ARENA_NEW(&b->study->arena, double, (size_t)b->study->arm->n);
  if (!b->study->start)
    return km_binder_memory(b);
  bool is_ok = km_bind_rates(b);
  is_ok = km_bind_methods(b) && is_ok;
  if (!km_bind_start(b, q) || !km_bind_path(b, q) || !is_ok)
    return false;
  find_start(b, q);
  return true;
}

/* Checks the arguments of km_study_bind. */
static km_status check_arguments(const km_mechanism *mechanism, const km_state *state, const km_study_def *def,
                                 km_study **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(def != NULL, "definition of a study", error);
  if (!status)
    status = km_check_state(mechanism, state, error);
  if (!status)
    status = km_check_list(def->effector.items, def->effector.count, "names of the effector", error);
  if (!status)
    status = km_check_list(def->coordinates.items, def->coordinates.count, "labels of coordinates", error);
  if (!status)
    status = km_check_list(def->methods, def->method_count, "methods", error);
  return status;
}

km_status km_study_bind(const km_mechanism *mechanism, const km_state *state, const km_study_def *def,
                        unsigned long seed, km_messages *messages, km_study **out, km_error *error) {
  km_status fits = check_arguments(mechanism, state, def, out, error);
  if (fits)
    return fits;
  km_study *study = KM_NEW(km_study, 1);
  if (!study)
    return km_fail(error, KM_MEMORY, "out of memory for a study");
  km_binder b = {.study = study,
                 .def = def,
                 .mechanism = mechanism,
                 .state = state,
                 .seed = seed,
                 .messages = messages,
                 .error = error};
  km_status status = bind_parts(&b) ? study->start_status : b.status;
  if (status && status == study->start_status)
    km_fail(error, status, "%s", study->start_error.text);
  if (!status || study->start_status == KM_NO_RESULT)
    *out = study;
  else
    km_study_free(study);
  return status;
}

void km_study_free(km_study *study) {
  if (!study)
    return;
  km_path_free(study->path);
  km_arm_free(study->arm);
  km_clearance_free(study->clearance);
  km_arena_free(&study->arena);
  km_free(study);
}

const km_arm *km_study_arm(const km_study *study) {
  if (!study)
    return NULL;
  return study->arm;
}

const km_path *km_study_bound_path(const km_study *study) {
  return study ? study->path : NULL;
}

km_status km_study_start(const km_study *s, double *q, double *moved, km_error *error) {
  km_status status = km_check_given(s != NULL, "study", error);
  if (status)
    return status;
  if (s->start_status)
    return km_fail(error, s->start_status, "%s", s->start_error.text);
  if (q)
    memcpy(q, s->start, (size_t)s->arm->n * sizeof *q);
  if (moved)
    *moved = s->start_moved;
  return KM_OK;
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
