/* Assembly modes: the ways in which the loops close where one joint stands. */
#include "kview/messages.h"

#include "kmech/modes.h"

#include <stdlib.h>
#include <string.h>

enum { STARTS = 200, MOST_MODES = 24 };

/* modes COORDINATE: finds them, the present one first. */
km_status kv_modes(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  km_modes modes;
  int n = km_model_coordinate_count(s->model);
  km_status status = km_modes_find(s->mechanism, s->state, kv_index(c, 0), STARTS, 1, NULL, NULL, &modes, error);
  if (!status) {
    int count = modes.count < MOST_MODES ? modes.count : MOST_MODES;
    size_t size = (size_t)count * (size_t)n * sizeof(double);
    free(s->modes);
    s->modes = malloc(size + 1);
    s->mode_count = s->modes ? count : 0;
    if (s->modes)
      memcpy(s->modes, modes.coordinates, size);
    kv_add(&c->answer->bytes, "{\"kind\":\"modes\",\"request\":%u,\"count\":%d,\"isolated\":%s}", c->request,
           s->mode_count, modes.isolated ? "true" : "false");
  }
  km_modes_free(&modes);
  return status;
}

/* mode NUMBER: takes the pose of one of those found last. */
km_status kv_mode(const kv_call *c, km_error *error) {
  kv_session *s = c->session;
  int mode = kv_index(c, 0);
  if (mode < 0 || mode >= s->mode_count)
    return km_fail(error, KM_USAGE, "there is no assembly mode %d", mode);
  km_status status = kv_session_place(s, s->modes + (size_t)mode * (size_t)km_model_coordinate_count(s->model), error);
  if (status)
    return status;
  s->move = (km_hand_move){.coordinate = -1, .there = true};
  c->answer->binary = true;
  kv_add_pose(s, c->request, &c->answer->bytes);
  return KM_OK;
}
