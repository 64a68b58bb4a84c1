/* Columns of an arm: how its joints move for a step of the effector, and how while it stays. */
#include "kview/messages.h"

#include "kmech/arm.h"

#include <stdlib.h>

/* [J | −ξ] over the arm's length scale: translations divided by it, slides multiplied. */
static void scale_matrix(const kv_session *s, const km_arm *arm, int direction, double *M) {
  int n = km_arm_coordinates(arm);
  double L = km_arm_length(arm);
  for (int c = 0; c < n; ++c) {
    double unit = km_model_coordinate_is_length(s->model, km_arm_coordinate(arm, c)) ? L : 1.0;
    for (int r = 0; r < 6; ++r)
      M[6 * c + r] *= unit / (r < 3 ? L : 1.0);
  }
  for (int r = 0; r < 6; ++r)
    M[6 * n + r] = r == direction ? -1.0 : 0.0;
}

static void add_columns(const kv_call *call, const km_arm *arm, const km_control *found, const double *Z) {
  km_text *out = &call->answer->bytes;
  int n = km_arm_coordinates(arm);
  km_text_format(out, "{\"kind\":\"columns\",\"request\":%u,\"entry\":", call->request);
  kv_add_number(out, found->path_entry);
  km_text_add(out, ",\"coordinates\":[");
  for (int c = 0; c < n; ++c) {
    kv_add_comma(out);
    km_text_format(out, "%d", km_arm_coordinate(arm, c));
  }
  km_text_add(out, "],\"columns\":[");
  for (int k = 0; k < found->freedom; ++k) {
    kv_add_comma(out);
    kv_add_numbers(out, Z + (size_t)k * (size_t)(n + 1), n);
  }
  km_text_add(out, "]}");
}

/* columns FRAME DIRECTION: of a step of the frame along x, y, z (0 to 2) or about them (3 to 5), in the inertial
 * frame: first the path-control column, then the pose-control columns (theory 6). */
km_status kv_columns(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  int direction = kv_index(call, 1);
  km_arm *arm = NULL;
  km_control found;
  if (direction < 0 || direction > 5)
    return km_fail(error, KM_USAGE, "there is no direction %d; expected 0 to 5", direction);
  km_status status = km_arm_create(s->mechanism, s->state, kv_index(call, 0), KM_TASK_POSE, &arm, error);
  size_t n = status ? 0 : (size_t)km_arm_coordinates(arm);
  double *q = calloc(n + 1, sizeof *q), *M = calloc(6 * (n + 1), sizeof *M), *Z = calloc((n + 1) * (n + 1), sizeof *Z);
  if (!status && (!q || !M || !Z))
    status = km_fail(error, KM_MEMORY, "out of memory");
  for (size_t c = 0; !status && c < n; ++c)
    q[c] = km_state_coordinate(s->state, km_arm_coordinate(arm, (int)c));
  if (!status)
    status = km_arm_jacobian(arm, q, M, error);
  if (!status) {
    scale_matrix(s, arm, direction, M);
    status = km_control_of_matrix(M, 6, (int)n + 1, Z, &found, error);
  }
  if (!status)
    add_columns(call, arm, &found, Z);
  km_arm_free(arm);
  free(q);
  free(M);
  free(Z);
  return status;
}
