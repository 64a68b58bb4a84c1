/* The design by hand: frames of a model get other places, and the mechanism takes them over. */
#include "kview/session.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_LENGTHS = 100 };

/* The mechanism takes over the model's numbers, at the pose next to q[coordinate] where its loops close; it is compiled
 * anew where a loop's motion space has changed, or something is held, perhaps at another value than before. */
static km_status take_over(kv_session *s, const double *q, km_error *error) {
  int n = km_model_coordinate_count(s->model);
  km_status status = KM_OK;
  for (int c = 0; c < n && !status; ++c)
    status = km_model_set_position(s->model, c, q[c], error);
  if (status)
    return status;
  status = s->hold_count > 0 ? KM_PARTIAL : km_mechanism_renumber(s->mechanism, error);
  if (status == KM_PARTIAL)
    return kv_session_compile(s, q, error);
  if (status)
    return status;
  km_state_restart(s->state);
  km_state_restart(s->probe);
  if (s->question)
    km_question_refresh(s->question);
  return kv_session_place(s, q, error);
}

double *kv_frame_places(const km_model *model) {
  int count = km_model_frame_count(model);
  double *places = malloc((size_t)(3 * count + 1) * sizeof *places);
  double R[9];
  km_error error;
  for (int f = 0; places && f < count; ++f)
    km_model_frame_pose(model, f, R, places + 3 * f, &error);
  return places;
}

/* Links of a million lengths have no digits left to close loops with. */
static km_status check_places(const kv_session *s, const double *T, km_error *error) {
  for (int k = 0; k < 3 * km_model_frame_count(s->model); ++k)
    if (!(fabs(T[k] - s->file_places[k]) <= MOST_LENGTHS * s->file_length))
      return km_fail(error, KM_USAGE, "frame \"%s\" would be moved by %g; expected at most %d characteristic lengths",
                     km_model_frame_name(s->model, k / 3), T[k] - s->file_places[k], MOST_LENGTHS);
  return KM_OK;
}

static km_status set_frames(kv_session *s, const double *T, km_error *error) {
  km_status status = check_places(s, T, error);
  for (int f = 0; f < km_model_frame_count(s->model) && !status; ++f)
    status = km_model_set_frame(s->model, f, T + 3 * f, NULL, error);
  return status;
}

/* Changes what `T` says, at the pose next to q (NULL: the present one); where the loops don't close then, everything is
 * as before. */
static km_status change(kv_session *s, const double *before, const double *T, const double *q, km_error *error) {
  km_error ignored;
  double *present = kv_session_coordinates(s);
  if (!present)
    return km_fail(error, KM_MEMORY, "out of memory");
  km_status status = set_frames(s, T, error);
  if (!status)
    status = take_over(s, q ? q : present, error);
  if (status && !set_frames(s, before, &ignored))
    take_over(s, present, &ignored);
  if (!status)
    kv_session_note_edits(s);
  free(present);
  return status;
}

km_status kv_session_take_design(kv_session *s, const double *T, const double *q, km_error *error) {
  double *before = kv_frame_places(s->model);
  size_t size = 3 * (size_t)km_model_frame_count(s->model) * sizeof *before;
  if (!before)
    return km_fail(error, KM_MEMORY, "out of memory");
  km_status status = KM_OK;
  if (memcmp(before, T, size))
    status = change(s, before, T, q, error);
  else if (q)
    status = s->hold_count > 0 ? kv_session_compile(s, q, error) : kv_session_place(s, q, error);
  free(before);
  return status;
}

km_status kv_session_move_frame(kv_session *s, int frame, const double T[3], km_error *error) {
  double *before = kv_frame_places(s->model), *after = kv_frame_places(s->model);
  km_status status = KM_OK;
  if (!before || !after)
    status = km_fail(error, KM_MEMORY, "out of memory");
  else if (frame < 0 || frame >= km_model_frame_count(s->model))
    status = km_fail(error, KM_USAGE, "there is no frame %d", frame);
  if (!status) {
    memcpy(after + 3 * frame, T, 3 * sizeof *T);
    status = change(s, before, after, NULL, error);
  }
  free(before);
  free(after);
  return status;
}

/* A way in the inertial frame as the body sees it. */
static km_status turn_into_body(const kv_session *s, int body, const double way[3], double out[3], km_error *error) {
  km_frame_pose X;
  double R[9], T[3], own[3];
  km_status status = km_frame_place(s->mechanism, s->state, s->origin[body], &X, error);
  if (!status)
    status = km_model_frame_pose(s->model, s->origin[body], R, T, error);
  for (int i = 0; i < 3 && !status; ++i)
    own[i] = X.R[i] * way[0] + X.R[3 + i] * way[1] + X.R[6 + i] * way[2];
  for (int i = 0; i < 3 && !status; ++i)
    out[i] = R[3 * i] * own[0] + R[3 * i + 1] * own[1] + R[3 * i + 2] * own[2];
  return status;
}

static bool slides(const km_model *m, int joint) {
  int type = km_model_joint_type(m, joint);
  return type == KM_TX || type == KM_TY || type == KM_TZ;
}

/* A cylinder or its rod keeps its pins, and follows the one that is moved. */
static bool is_strut_end(const km_model *m, int body) {
  int joints = 0;
  bool slide = false;
  for (int j = 0; j < km_model_joint_count(m); ++j)
    for (int end = 0; end < 2; ++end)
      if (km_model_frame_body(m, km_model_joint_frame(m, j, end)) == body) {
        ++joints;
        slide = slide || slides(m, j);
      }
  return body > 0 && slide && joints == 2;
}

/* The frames of a pin: those of the joint, and of others that share one with it. */
static void mark_pin(const km_model *m, int joint, bool *moved) {
  moved[km_model_joint_frame(m, joint, false)] = moved[km_model_joint_frame(m, joint, true)] = true;
  for (bool more = true; more;) {
    more = false;
    for (int j = 0; j < km_model_joint_count(m); ++j) {
      bool *parent = &moved[km_model_joint_frame(m, j, false)], *child = &moved[km_model_joint_frame(m, j, true)];
      if (*parent == *child || slides(m, j))
        continue;
      *parent = *child = more = true;
    }
  }
}

/* Moves the marked frames of one body by `way`. Its own origin can't move in it: there the others go the other way. */
static void move_on_body(const km_model *m, int body, int origin, const bool *moved, const double way[3], double *T) {
  bool whole = body > 0 && moved[origin];
  for (int f = 0; f < km_model_frame_count(m); ++f)
    for (int k = 0; k < 3 && km_model_frame_body(m, f) == body && moved[f] != whole; ++k)
      T[3 * f + k] += whole ? -way[k] : way[k];
}

static km_status shift_pin(const kv_session *s, int joint, const double shift[3], double *T, km_error *error) {
  bool *moved = calloc((size_t)km_model_frame_count(s->model), sizeof *moved);
  km_status status = moved ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  if (!status)
    mark_pin(s->model, joint, moved);
  for (int b = 0; b <= km_model_body_count(s->model) && !status; ++b) {
    double way[3];
    bool has = false;
    for (int f = 0; f < km_model_frame_count(s->model); ++f)
      has = has || (moved[f] && km_model_frame_body(s->model, f) == b);
    if (!has || is_strut_end(s->model, b))
      continue;
    status = turn_into_body(s, b, shift, way, error);
    if (!status)
      move_on_body(s->model, b, s->origin[b], moved, way, T);
  }
  free(moved);
  return status;
}

km_status kv_session_move_pivot(kv_session *s, int joint, const double point[3], km_error *error) {
  double *before = kv_frame_places(s->model), *after = kv_frame_places(s->model), shift[3], place[3];
  km_status status = before && after ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  if (!status && km_model_joint_frame(s->model, joint, false) < 0)
    status = km_fail(error, KM_USAGE, "there is no joint %d", joint);
  if (!status) {
    km_frame_position(s->mechanism, s->state, km_model_joint_frame(s->model, joint, true), place);
    for (int k = 0; k < 3; ++k)
      shift[k] = point[k] - place[k];
    status = shift_pin(s, joint, shift, after, error);
  }
  if (!status)
    status = change(s, before, after, NULL, error);
  free(before);
  free(after);
  return status;
}
