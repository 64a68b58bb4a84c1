/* The design by hand: frames of a model get other places, and the mechanism takes them over. */
#include "kview/session.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_LENGTHS = 100 };

/* The mechanism takes over the model's numbers, at the pose next to q[coordinate] where its loops close; it is compiled
 * anew where a loop's motion space has changed, or something is held, perhaps at another value than before. */
static km_status copy_over(kv_session *s, const double *q, km_error *error) {
  int n = km_model_coordinate_count(s->model);
  km_status status = KM_OK;
  kv_map_stop(s);
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
  if (!status)
    kv_map_stop(s);
  for (int f = 0; f < km_model_frame_count(s->model) && !status; ++f)
    status = km_model_set_frame(s->model, f, T + 3 * f, NULL, error);
  return status;
}

static bool slides(const km_model *m, int joint) {
  int type = km_model_joint_type(m, joint);
  return type == KM_TX || type == KM_TY || type == KM_TZ;
}

static int body_at(const km_model *m, int joint, int end) {
  return km_model_frame_body(m, km_model_joint_frame(m, joint, end));
}

/* Number of joints of a body, and its prismatic joint; −1: none. */
static int joints_of(const km_model *m, int body, int *slide) {
  int count = 0;
  *slide = -1;
  for (int j = 0; j < km_model_joint_count(m); ++j)
    for (int end = 0; end < 2; ++end)
      if (body_at(m, j, end) == body) {
        ++count;
        *slide = slides(m, j) ? j : *slide;
      }
  return count;
}

/* A cylinder or its rod, between which a slide is and which have a pin each: they keep their pins, and follow the
 * one that is moved. */
static bool is_strut_end(const km_model *m, int body) {
  int slide, other;
  if (body <= 0 || joints_of(m, body, &slide) != 2 || slide < 0)
    return false;
  int beyond = body_at(m, slide, body_at(m, slide, 0) == body);
  return beyond > 0 && joints_of(m, beyond, &other) == 2;
}

/* True for the prismatic joint between a cylinder and its rod, which isn't part of a pin. Another prismatic joint
 * whose frame is a pin's moves with it. */
static bool is_strut(const km_model *m, int joint) {
  return slides(m, joint) && is_strut_end(m, body_at(m, joint, 0));
}

/* The holds of all joints but those of struts, and the slide (-1: none). Returns how many there are, as many as
 * there are coordinates where nothing is to follow. */
static int hold_others(const km_model *m, int slide, const double *q, km_hold *holds) {
  int count = 0;
  for (int c = 0; c < km_model_coordinate_count(m); ++c) {
    int joint = km_model_coordinate_joint(m, c);
    if (joint != slide && !is_strut_end(m, body_at(m, joint, 0)) && !is_strut_end(m, body_at(m, joint, 1)))
      holds[count++] = (km_hold){c, q[c]};
  }
  return count;
}

/* After a change of the model's numbers: solves for the coordinates of struts, or of the prismatic joint, in
 * q[coordinate] that close the loops while all other joints are fixed. Otherwise q is unchanged. */
static void follow(const kv_session *s, int slide, double *q) {
  int n = km_model_coordinate_count(s->model);
  km_hold *holds = calloc((size_t)n + 1, sizeof *holds);
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_assembly evidence;
  km_error ignored;
  int count = holds ? hold_others(s->model, slide, q, holds) : n;
  if (count < n && !km_mechanism_compile(s->model, holds, count, &mechanism, &ignored) &&
      !km_state_create(mechanism, &state, &ignored) && !km_state_set_coordinates(mechanism, state, q, &ignored) &&
      !km_assemble(mechanism, state, &evidence, &ignored))
    km_state_coordinates(mechanism, state, q, &ignored);
  km_state_free(state);
  km_mechanism_free(mechanism);
  free(holds);
}

/* Changes what `T` says, at the pose next to q (NULL: the present one, which struts and the slide alone leave);
 * where the loops don't close then, everything is as before. */
static km_status change(kv_session *s, const double *before, const double *T, const double *q, int slide,
                        km_error *error) {
  km_error ignored;
  double *present = kv_session_coordinates(s), *next = kv_session_coordinates(s);
  km_status status = present && next ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  if (!status)
    status = set_frames(s, T, error);
  if (!status && !q)
    follow(s, slide, next);
  if (!status)
    status = copy_over(s, q ? q : next, error);
  if (status && present && !set_frames(s, before, &ignored))
    copy_over(s, present, &ignored);
  if (!status)
    kv_session_note_edits(s);
  free(present);
  free(next);
  return status;
}

km_status kv_session_set_design(kv_session *s, const double *T, const double *q, km_error *error) {
  double *before = kv_frame_places(s->model);
  size_t size = 3 * (size_t)km_model_frame_count(s->model) * sizeof *before;
  if (!before)
    return km_fail(error, KM_MEMORY, "out of memory");
  km_status status = KM_OK;
  if (memcmp(before, T, size))
    status = change(s, before, T, q, -1, error);
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
    status = change(s, before, after, NULL, -1, error);
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

/* Elements that move with a pin. */
typedef struct pin {
  bool *moved;     /* [frame] */
  double shift[3]; /* position in the inertial frame */
  int slide;       /* prismatic joint along which the pin's body moves with all its frames; −1: none */
} pin;

/* The frames of a joint, and of others that share one with it; of slides where it goes `through` them. */
static void mark_pin(const km_model *m, int joint, bool through, bool *moved) {
  memset(moved, 0, (size_t)km_model_frame_count(m) * sizeof *moved);
  moved[km_model_joint_frame(m, joint, false)] = moved[km_model_joint_frame(m, joint, true)] = true;
  for (bool more = true; more;) {
    more = false;
    for (int j = 0; j < km_model_joint_count(m); ++j) {
      bool *parent = &moved[km_model_joint_frame(m, j, false)], *child = &moved[km_model_joint_frame(m, j, true)];
      if (*parent == *child || is_strut(m, j) || (slides(m, j) && !through))
        continue;
      *parent = *child = more = true;
    }
  }
}

/* The slide that one of the pin's frames is on; -1: none. */
static int slide_at(const km_model *m, const bool *moved) {
  for (int j = 0; j < km_model_joint_count(m); ++j)
    if (slides(m, j) && !is_strut(m, j) &&
        moved[km_model_joint_frame(m, j, false)] != moved[km_model_joint_frame(m, j, true)])
      return j;
  return -1;
}

/* The displacement is projected on the prismatic joint. */
static km_status store_along(const kv_session *s, int slide, double way[3], km_error *error) {
  km_frame_pose X;
  int axis = km_model_joint_type(s->model, slide) - KM_TX;
  km_status status = km_frame_place(s->mechanism, s->state, km_model_joint_frame(s->model, slide, false), &X, error);
  double along = 0.0;
  for (int k = 0; k < 3 && !status; ++k)
    along += X.R[3 * k + axis] * way[k];
  for (int k = 0; k < 3 && !status; ++k)
    way[k] = along * X.R[3 * k + axis];
  return status;
}

/* A slide moves with its pin; where that would move the inertial frame's own origin, which a file can't say, the pin
 * goes along the slide alone. */
static km_status find_pin(const kv_session *s, int joint, pin *p, km_error *error) {
  mark_pin(s->model, joint, true, p->moved);
  p->slide = -1;
  if (!p->moved[s->origin[0]])
    return KM_OK;
  mark_pin(s->model, joint, false, p->moved);
  p->slide = p->moved[s->origin[0]] ? -1 : slide_at(s->model, p->moved);
  if (p->slide < 0)
    return km_fail(error, KM_USAGE,
                   "joint \"%s\" stands at the origin of the inertial frame, which can't be moved; expected one with a "
                   "frame of its own",
                   km_model_joint_label(s->model, joint));
  return store_along(s, p->slide, p->shift, error);
}

/* Cylinders and rods stay as they are and follow, as does the body that goes along a slide. */
static bool stays_whole(const km_model *m, const pin *p, int body) {
  if (is_strut_end(m, body))
    return true;
  return p->slide >= 0 && body_at(m, p->slide, p->moved[km_model_joint_frame(m, p->slide, true)]) == body;
}

/* Moves the marked frames of one body by `way`. Its own origin can't move in it: there the others go the other way. */
static void move_on_body(const km_model *m, int body, int origin, const bool *moved, const double way[3], double *T) {
  bool whole = body > 0 && moved[origin];
  for (int f = 0; f < km_model_frame_count(m); ++f)
    for (int k = 0; k < 3 && km_model_frame_body(m, f) == body && moved[f] != whole; ++k)
      T[3 * f + k] += whole ? -way[k] : way[k];
}

static km_status shift_pin(const kv_session *s, const pin *p, double *T, km_error *error) {
  km_status status = KM_OK;
  for (int b = 0; b <= km_model_body_count(s->model) && !status; ++b) {
    double way[3];
    bool has = false;
    for (int f = 0; f < km_model_frame_count(s->model); ++f)
      has = has || (p->moved[f] && km_model_frame_body(s->model, f) == b);
    if (!has || stays_whole(s->model, p, b))
      continue;
    status = turn_into_body(s, b, p->shift, way, error);
    if (!status)
      move_on_body(s->model, b, s->origin[b], p->moved, way, T);
  }
  return status;
}

km_status kv_session_move_pivot(kv_session *s, int joint, const double point[3], km_error *error) {
  double *before = kv_frame_places(s->model), *after = kv_frame_places(s->model), place[3];
  pin p = {calloc((size_t)km_model_frame_count(s->model) + 1, sizeof *p.moved), {0.0, 0.0, 0.0}, -1};
  km_status status = before && after && p.moved ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  if (!status && km_model_joint_frame(s->model, joint, false) < 0)
    status = km_fail(error, KM_USAGE, "there is no joint %d", joint);
  if (!status) {
    km_frame_position(s->mechanism, s->state, km_model_joint_frame(s->model, joint, true), place);
    for (int k = 0; k < 3; ++k)
      p.shift[k] = point[k] - place[k];
    status = find_pin(s, joint, &p, error);
  }
  if (!status)
    status = shift_pin(s, &p, after, error);
  if (!status)
    status = change(s, before, after, NULL, p.slide, error);
  free(before);
  free(after);
  free(p.moved);
  return status;
}
