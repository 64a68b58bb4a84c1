/* Undo list of configurations and designs. */
#include "kview/session.h"

#include <stdlib.h>
#include <string.h>

static size_t moment_size(const kv_session *s) {
  return (size_t)km_model_coordinate_count(s->model) + 3 * (size_t)km_model_frame_count(s->model) +
         (size_t)s->parameters.count;
}

static km_status take(const kv_session *s, double *numbers, km_error *error) {
  int n = km_model_coordinate_count(s->model);
  km_status status = km_state_coordinates(s->mechanism, s->state, numbers, error);
  for (int f = 0; f < km_model_frame_count(s->model) && !status; ++f) {
    double R[9];
    status = km_model_frame_pose(s->model, f, R, numbers + n + 3 * f, error);
  }
  for (int i = 0; i < s->parameters.count && !status; ++i)
    numbers[n + 3 * km_model_frame_count(s->model) + i] = s->parameters.items[i].value;
  return status;
}

static int most(const kv_session *s) {
  size_t fit = KV_UNDO_BYTES / (moment_size(s) * sizeof(double) + 1);
  return fit < 2 ? 2 : fit > KV_MOST_UNDO ? KV_MOST_UNDO : (int)fit;
}

static void drop_first(kv_session *s) {
  free(s->undo[0].numbers);
  memmove(s->undo, s->undo + 1, (size_t)(s->undo_count - 1) * sizeof *s->undo);
  --s->undo_count;
}

km_status kv_session_mark(kv_session *s, km_error *error) {
  size_t size = moment_size(s) * sizeof(double);
  double *numbers = malloc(size + 1);
  km_status status = numbers ? take(s, numbers, error) : km_fail(error, KM_MEMORY, "out of memory");
  bool same = !status && s->undo_count && memcmp(s->undo[s->undo_at].numbers, numbers, size) == 0;
  if (status || same) {
    free(numbers);
    return status;
  }
  while (s->undo_count > s->undo_at + 1)
    free(s->undo[--s->undo_count].numbers);
  if (s->undo_count == most(s))
    drop_first(s);
  s->undo_at = s->undo_count++;
  s->undo[s->undo_at].numbers = numbers;
  return KM_OK;
}

/* Held coordinates stay held, at the values of the configuration, which otherwise couldn't be reached. Swaps the
 * values with `other`[hold_count], at first those of the configuration. */
static void swap_held(kv_session *s, double *other) {
  for (int h = 0; h < s->hold_count; ++h) {
    double value = s->holds[h].value;
    s->holds[h].value = other[h];
    other[h] = value;
  }
}

/* Takes places and pose with the holds at the pose's values; on failure these are as before. */
static km_status copy_moment(kv_session *s, const double *places, const double *q, km_error *error) {
  double *held = malloc(((size_t)s->hold_count + 1) * sizeof *held);
  if (!held)
    return km_fail(error, KM_MEMORY, "out of memory");
  for (int h = 0; h < s->hold_count; ++h)
    held[h] = q[s->holds[h].coordinate];
  swap_held(s, held);
  km_status status = kv_session_set_design(s, places, q, error);
  if (status)
    swap_held(s, held);
  free(held);
  return status;
}

km_status kv_session_step(kv_session *s, int direction, km_error *error) {
  km_status status = kv_session_mark(s, error); /* the present state is stored before a step back */
  int to = s->undo_at + direction;
  if (status || to < 0 || to >= s->undo_count)
    return status;
  const double *numbers = s->undo[to].numbers;
  int n = km_model_coordinate_count(s->model);
  status = kv_session_set_parameters(s, numbers + n + 3 * km_model_frame_count(s->model), error);
  if (!status)
    status = copy_moment(s, numbers + n, numbers, error);
  if (!status)
    s->undo_at = to;
  return status;
}
