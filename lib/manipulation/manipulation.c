/* Manipulation of a mechanism: creation, and motion of a joint (theory 4.14).
 *
 *   a joint moves by sqrt(m_j) of the mechanism's step |D δq|, at least 2 %: slowly near its dead point */
#include "manipulation/manipulation.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "local/bifurcation.h"
#include "mobility/mobility_numbers.h"

#include <string.h>

/* Part of `most` by which a joint moves at a dead point, where its mobility number does not determine the motion. */
static const double min_part = 0.02;

const char *km_manipulation_stop_name(km_manipulation_stop stop) {
  static const char *const names[] = {"free", "limit", "toggle", "nearest"};
  return (unsigned)stop < sizeof names / sizeof *names ? names[stop] : "";
}

static bool allocate(km_manipulation *h) {
  size_t n = (size_t)h->mechanism->coordinate_count, subs = (size_t)h->mechanism->topology.substructure_count;
  km_arena *a = &h->arena;
  h->substructures = KM_ARENA_NEW(a, int, subs);
  h->is_on_path = KM_ARENA_NEW(a, bool, subs);
  h->tree = KM_ARENA_NEW(a, int, n);
  h->rank = KM_ARENA_NEW(a, int, subs);
  h->has_left_branch_point = KM_ARENA_NEW(a, bool, subs);
  h->column = KM_ARENA_NEW(a, km_vec3, n);
  h->A = KM_ARENA_NEW(a, double, 3 * n);
  h->w = KM_ARENA_NEW(a, double, n);
  h->z = KM_ARENA_NEW(a, double, n);
  h->blocked = KM_ARENA_NEW(a, bool, n);
  h->saved_q = KM_ARENA_NEW(a, double, n);
  h->saved_ball = KM_ARENA_NEW(a, km_quaternion, (size_t)h->mechanism->ball_count);
  return !a->failed;
}

km_status km_manipulation_create(const km_mechanism *m, km_state *s, km_manipulation **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_state(m, s, error);
  if (status)
    return status;
  km_manipulation *h = KM_NEW(km_manipulation, 1);
  if (h)
    *h = (km_manipulation){.mechanism = m, .state = s, .driven = -1, .blocking = -1};
  if (!h || !allocate(h)) {
    km_manipulation_free(h);
    return km_fail(error, KM_MEMORY, "out of memory for a hand");
  }
  *out = h;
  return KM_OK;
}

void km_manipulation_free(km_manipulation *h) {
  if (!h)
    return;
  km_driver_motion_free(h->drive);
  km_arena_free(&h->arena);
  km_free(h);
}

void km_manipulation_release(km_manipulation *h) {
  if (!h)
    return;
  km_driver_motion_free(h->drive);
  h->drive = NULL;
  h->driven = -1;
  for (int i = 0; i < h->mechanism->topology.substructure_count; ++i) {
    h->rank[i] = 0;
    h->has_left_branch_point[i] = false;
  }
}

void km_manipulation_save(km_manipulation *h) {
  memcpy(h->saved_q, h->state->q, (size_t)h->mechanism->coordinate_count * sizeof *h->saved_q);
  if (h->mechanism->ball_count)
    memcpy(h->saved_ball, h->state->ball, (size_t)h->mechanism->ball_count * sizeof *h->saved_ball);
}

void km_manipulation_restore(km_manipulation *h) {
  memcpy(h->state->q, h->saved_q, (size_t)h->mechanism->coordinate_count * sizeof *h->saved_q);
  if (h->mechanism->ball_count)
    memcpy(h->state->ball, h->saved_ball, (size_t)h->mechanism->ball_count * sizeof *h->saved_ball);
}

/* Selects the driven motion of a coordinate; the last one is continued, so that the branch is kept. */
static km_status select_motion(km_manipulation *h, int coordinate, km_error *error) {
  if (h->drive && h->driven == coordinate)
    return KM_OK;
  km_manipulation_release(h);
  if (km_branch_depart(h->mechanism, h->state, coordinate, 0.0).branch_count < 0)
    return km_fail(error, KM_MEMORY, "out of memory for a hand");
  km_status status = km_driver_motion_create(h->mechanism, h->state, coordinate, false, &h->drive, error);
  h->driven = status ? -1 : coordinate;
  return status;
}

/* Returns the largest move of the coordinate, model's unit. */
static double max_move(const km_manipulation *h, int coordinate, double most) {
  const km_mechanism *m = h->mechanism;
  double number = h->state->mobility_number[coordinate];
  double part = fmax(sqrt(fmax(number, 0.0)), min_part) * most / m->scale[coordinate];
  return part / km_model_coordinate_factor(m->model, coordinate);
}

static void update_results(km_manipulation *h, int coordinate) {
  int index = h->mechanism->substructure_of[coordinate];
  if (index >= 0)
    km_numbers_update(h->mechanism, h->state, index);
  km_poses_compute(h->mechanism, h->state);
}

/* Moves a component of a rotation vector outside loops, within its limits and the ball joint's. */
static void move_ball_component(km_manipulation *h, int coordinate, double target, double most,
                                km_manipulation_step *out) {
  const km_mechanism *m = h->mechanism;
  int first = m->ball_coordinate[m->ball_of[coordinate]];
  double factor = km_model_coordinate_factor(m->model, coordinate), goal = target * factor, others = 0.0;
  double q = h->state->q[coordinate], limited_goal = fmin(fmax(goal, m->low[coordinate]), m->high[coordinate]);
  for (int c = first; c < first + 3; ++c)
    others += c == coordinate ? 0.0 : h->state->q[c] * h->state->q[c];
  double ball = sqrt(fmax(m->max_ball_angle[first] * m->max_ball_angle[first] - others, 0.0));
  limited_goal = fmin(fmax(limited_goal, -ball), ball);
  memcpy(h->z, h->state->q, (size_t)m->coordinate_count * sizeof *h->z);
  h->z[coordinate] = q + fmin(fmax(limited_goal - q, -most), most);
  km_state_set(m, h->state, h->z);
  bool limited = h->z[coordinate] == limited_goal && limited_goal != goal;
  *out = (km_manipulation_step){.stop = limited ? KM_MANIPULATION_LIMIT : KM_MANIPULATION_FREE,
                                .coordinate = limited ? coordinate : -1,
                                .is_reached = h->z[coordinate] == goal,
                                .remaining = (goal - h->z[coordinate]) / factor};
}

static void move_driven_joint(km_manipulation *h, int coordinate, double target, double most,
                              km_manipulation_step *out) {
  double at = km_state_coordinate(h->state, coordinate), reach = max_move(h, coordinate, most);
  double goal = fabs(target - at) <= reach ? target : at + copysign(reach, target - at);
  km_motion_end reached = km_driver_motion_move_to(h->drive, goal);
  *out = (km_manipulation_step){.coordinate = -1, .is_reached = reached.stop == KM_STOP_NONE && goal == target};
  if (reached.stop == KM_STOP_LIMIT) {
    out->stop = KM_MANIPULATION_LIMIT;
    out->coordinate = reached.coordinate;
  } else if (reached.stop) {
    out->stop = KM_MANIPULATION_TOGGLE;
    out->coordinate = coordinate;
  }
  out->remaining = out->is_reached ? 0.0 : target - km_state_coordinate(h->state, coordinate);
}

km_status km_manipulation_check(const km_manipulation *h, double most, const km_manipulation_step *out,
                                km_error *error) {
  km_status status = km_check_given(h != NULL, "hand", error);
  if (!status)
    status = km_check_given(out != NULL, "place for the result", error);
  if (!status && !(most > 0.0))
    return km_fail(error, KM_USAGE, "found a way of %g; expected more than 0", most);
  return status;
}

km_status km_manipulation_pull_joint(km_manipulation *h, int coordinate, double target, double most,
                                     km_manipulation_step *out, km_error *error) {
  km_status status = km_manipulation_check(h, most, out, error);
  if (!status)
    status = km_check_index(coordinate, h->mechanism->coordinate_count, "coordinate", error);
  if (!status && !isfinite(target))
    status = km_fail(error, KM_USAGE, "found a target that is not finite");
  if (status)
    return status;
  const km_mechanism *m = h->mechanism;
  if (m->ball_of[coordinate] >= 0 && m->substructure_of[coordinate] < 0 && !m->held[coordinate]) {
    km_manipulation_release(h);
    move_ball_component(h, coordinate, target, most, out);
  } else {
    status = select_motion(h, coordinate, error);
    if (status)
      return status;
    move_driven_joint(h, coordinate, target, most, out);
  }
  update_results(h, coordinate);
  return KM_OK;
}
