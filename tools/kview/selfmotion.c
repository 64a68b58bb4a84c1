/* Self-motions: how an arm with joints to spare moves while its effector stays. */
#include "kview/messages.h"
#include "kview/server/time_limit.h"

#include "kmech/arm.h"

#include <stdlib.h>

static void add_rows(const kv_call *call, const km_arm *arm, const km_selfmotion *motion) {
  km_text *out = &call->answer->bytes;
  int columns = km_arm_coordinates(arm);
  km_text_format(out, "{\"kind\":\"selfmotion\",\"request\":%u,\"whole\":%s,\"coordinates\":[", call->request,
                 motion->is_within_limits ? "true" : "false");
  for (int c = 0; c < columns; ++c) {
    kv_add_comma(out);
    km_text_format(out, "%d", km_arm_coordinate(arm, c));
  }
  km_text_add(out, "],\"u\":");
  kv_add_numbers(out, motion->row_u, motion->row_count);
  km_text_add(out, ",\"arc\":[");
  for (int r = 0; r < motion->row_count; ++r) {
    kv_add_comma(out);
    km_text_format(out, "%d", motion->row_arc[r]);
  }
  km_text_add(out, "],\"q\":[");
  for (int r = 0; r < motion->row_count; ++r) {
    kv_add_comma(out);
    kv_add_numbers(out, motion->row_q + (size_t)r * (size_t)columns, columns);
  }
  km_text_add(out, "]}");
}

/* selfmotion FRAME: the poses that hold this frame where it is, within the limits. */
km_status kv_selfmotion(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_arm *arm = NULL;
  km_selfmotion motion = {0};
  kv_limit limit = kv_limit_begin();
  km_status status = km_arm_create(s->mechanism, s->state, kv_index(call, 0), KM_TASK_POSE, &arm, error);
  double *q = status ? NULL : calloc((size_t)km_arm_coordinates(arm) + 1, sizeof *q);
  if (!status && !q)
    status = km_fail(error, KM_MEMORY, "out of memory");
  for (int c = 0; !status && c < km_arm_coordinates(arm); ++c)
    q[c] = km_state_coordinate(s->state, km_arm_coordinate(arm, c));
  if (!status)
    status = kv_limit_report(km_selfmotion_follow(arm, q, kv_limit_goes_on, &limit, &motion, error), "the self-motion",
                             error);
  if (!status)
    add_rows(call, arm, &motion);
  km_selfmotion_free(&motion);
  km_arm_free(arm);
  free(q);
  return status;
}
