/* The pose of a session as bytes: evidence, coordinates, mobility numbers, bodies. */
#include "kview/messages.h"

#include <string.h>

enum { THERE = 1, EDITED = 2, CAN_UNDO = 4, CAN_REDO = 8 };

/* The body's own frame in the inertial frame: its origin's pose less where that lies in the body. */
static void add_body(const kv_session *s, int body, km_text *out) {
  km_frame_pose X;
  double R[9], T[3];
  km_error error;
  memset(&X, 0, sizeof X);
  memset(R, 0, sizeof R);
  memset(T, 0, sizeof T);
  km_frame_place(s->mechanism, s->state, s->origin[body], &X, &error);
  km_model_frame_pose(s->model, s->origin[body], R, T, &error);
  double own[9], p[3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      own[3 * i + j] = X.R[3 * i] * R[3 * j] + X.R[3 * i + 1] * R[3 * j + 1] + X.R[3 * i + 2] * R[3 * j + 2];
  for (int i = 0; i < 3; ++i)
    p[i] = X.p[i] - own[3 * i] * T[0] - own[3 * i + 1] * T[1] - own[3 * i + 2] * T[2];
  for (int k = 0; k < 9; ++k)
    kv_add_f32(out, own[k]);
  for (int k = 0; k < 3; ++k)
    kv_add_f32(out, p[k]);
}

void kv_add_pose(const kv_session *s, unsigned request, km_text *out) {
  int n = km_model_coordinate_count(s->model), bodies = km_model_body_count(s->model) + 1;
  bool undo = s->undo_at > 0 || s->undo_count == 0, redo = s->undo_at + 1 < s->undo_count;
  uint32_t flags =
      (s->move.is_reached ? THERE : 0u) | (s->edited ? EDITED : 0u) | (undo ? CAN_UNDO : 0u) | (redo ? CAN_REDO : 0u);
  kv_add_u32(out, KV_POSE);
  kv_add_u32(out, request);
  kv_add_u32(out, (uint32_t)n);
  kv_add_u32(out, (uint32_t)bodies);
  kv_add_u32(out, (uint32_t)s->move.stop);
  kv_add_u32(out, (uint32_t)s->move.coordinate);
  kv_add_u32(out, flags);
  kv_add_u32(out, (uint32_t)s->mobility.mobility);
  kv_add_f64(out, s->move.remaining);
  kv_add_f64(out, s->mobility.residual);
  for (int c = 0; c < n; ++c)
    kv_add_f64(out, km_state_coordinate(s->state, c));
  for (int c = 0; c < n; ++c)
    kv_add_f64(out, km_mobility_number(s->state, c));
  for (int b = 0; b < bodies; ++b)
    add_body(s, b, out);
}
