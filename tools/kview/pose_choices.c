/* Selectable configurations: assembly modes with one joint fixed, and named poses of the model. */
#include "kview/messages.h"
#include "kview/server/time_limit.h"

#include "kmech/continuation.h"
#include "kmech/mechanism.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STARTS = 200, MOST_MODES = 24 };

/* modes COORDINATE: finds them, the present one first. */
km_status kv_modes(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  km_modes modes;
  int n = km_model_coordinate_count(s->model);
  kv_limit limit = kv_limit_begin();
  km_status status =
      km_modes_find(s->mechanism, s->state, kv_index(c, 0), STARTS, 1, kv_limit_goes_on, &limit, &modes, error);
  status = kv_limit_report(status, "the search for assembly modes", error);
  if (!status) {
    int count = modes.count < MOST_MODES ? modes.count : MOST_MODES;
    size_t size = (size_t)count * (size_t)n * sizeof(double);
    free(s->modes);
    s->modes = malloc(size + 1);
    s->mode_count = s->modes ? count : 0;
    if (s->modes)
      memcpy(s->modes, modes.coordinates, size);
    km_text_format(&c->answer->bytes, "{\"kind\":\"modes\",\"request\":%u,\"count\":%d,\"isolated\":%s}", c->request,
                   s->mode_count, modes.isolated ? "true" : "false");
  }
  km_modes_free(&modes);
  return status;
}

static km_status give_pose(const kv_call *c) {
  c->session->move = (km_manipulation_step){.coordinate = -1, .is_reached = true};
  c->answer->binary = true;
  kv_add_pose(c->session, c->request, &c->answer->bytes);
  return KM_OK;
}

/* mode NUMBER: takes the pose of one of those found last. */
km_status kv_mode(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  int mode = kv_index(c, 0);
  if (mode < 0 || mode >= s->mode_count)
    return km_fail(error, KM_USAGE, "there is no assembly mode %d", mode);
  km_status status = kv_session_place(s, s->modes + (size_t)mode * (size_t)km_model_coordinate_count(s->model), error);
  return status ? status : give_pose(c);
}

/* Copies the coordinates that a named pose states to q; returns their number. */
static int copy_values(const kv_session *s, int pose, double *q, km_hold *sets) {
  int count = 0;
  for (int k = 0; k < km_model_coordinate_count(s->model); ++k) {
    double value = km_model_pose_value(s->model, pose, k);
    if (isnan(value))
      continue;
    q[k] = value;
    sets[count++] = (km_hold){k, value};
  }
  return count;
}

static bool stands(const kv_session *s, const km_hold *sets, int count) {
  bool there = true;
  for (int i = 0; i < count; ++i)
    there = there && fabs(km_state_coordinate(s->state, sets[i].coordinate) - sets[i].value) <=
                         1e-6 * (1.0 + fabs(sets[i].value));
  return there;
}

/* A pose that says all closes next to it; one that says less is driven to, on the present branch. */
static km_status move_to(kv_session *s, int pose, km_error *error) {
  size_t n = (size_t)km_model_coordinate_count(s->model);
  double *q = kv_session_coordinates(s), *before = kv_session_coordinates(s);
  km_hold *sets = calloc(n + 1, sizeof *sets);
  km_status status = q && before && sets ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  if (!status) {
    int count = copy_values(s, pose, q, sets);
    status = kv_session_place(s, q, error);
    if (status || !stands(s, sets, count)) {
      kv_session_place(s, before, error);
      status = km_state_move_to(s->mechanism, s->state, sets, count, error);
      km_manipulation_release(s->hand);
      kv_session_follow(s);
    }
  }
  free(q);
  free(before);
  free(sets);
  return status;
}

/* named POSE: one of those that the model names; what it doesn't say starts from the present pose. */
km_status kv_named(const kv_call *c, km_error *error) {
  int pose = kv_index(c, 0);
  if (pose < 0 || pose >= km_model_pose_count(c->session->model))
    return km_fail(error, KM_USAGE, "there is no pose %d", pose);
  km_status status = move_to(c->session, pose, error);
  return status ? status : give_pose(c);
}
