/* Moves a state to prescribed coordinate values (theory 4.4).
 *
 *   for each coordinate, in order: drive it to its value along the present branch (4.6), then lock it
 *   held coordinates: the mechanism that holds them is compiled once, at the configuration that was reached */
#include "continuation/target_configuration.h"
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "kinematics/loop_closing.h"
#include "kmech/continuation.h"
#include "local/bifurcation.h"

#include <string.h>

/* A state that is moved to prescribed values; coordinates that have theirs are locked. */
typedef struct value_search {
  const km_model *model;
  const km_mechanism *mechanism;
  km_state *state;
} value_search;

static double coordinate_value(const value_search *j, int coordinate) {
  return km_state_coordinate(j->state, coordinate);
}

/* True if the coordinate has the value to the residual tolerance of closed loops. */
static bool has_value(const value_search *j, const km_hold *goal) {
  return fabs(coordinate_value(j, goal->coordinate) - goal->value) <= km_solved_rounding * (1.0 + fabs(goal->value));
}

/* Sets a coordinate to the goal's value and locks it. */
static void set_and_lock(value_search *j, const km_hold *goal) {
  j->state->q[goal->coordinate] = goal->value * km_model_coordinate_factor(j->model, goal->coordinate);
  km_state_lock(j->state, goal->coordinate);
}

/* Locks a coordinate, at the goal's value exactly if it has that value to rounding. */
static void lock_at_value(value_search *j, const km_hold *goal) {
  if (has_value(j, goal))
    set_and_lock(j, goal);
  else
    km_state_lock(j->state, goal->coordinate);
}

/* True if the value is right within the closure tolerance. A configuration stated as a whole can leave no freedom to
 * reach its rounded values. */
static bool is_within_tolerance(const value_search *j, const km_hold *goal) {
  const km_mechanism *m = j->mechanism;
  double factor = km_model_coordinate_factor(j->model, goal->coordinate);
  double error_size = fabs(coordinate_value(j, goal->coordinate) - goal->value) * factor * m->scale[goal->coordinate];
  return error_size <= m->closure_tolerance * (1.0 + fabs(goal->value) * factor * m->scale[goal->coordinate]);
}

static km_status fail_unreachable(const value_search *j, const km_hold *goal, double end, km_error *error) {
  const char *label = km_model_coordinate_label(j->model, goal->coordinate);
  const char *unit = km_model_coordinate_unit(j->model, goal->coordinate);
  return km_fail(error, KM_NO_RESULT, "%s = %.9g %s can't be reached from the file's pose: it ends at %.9g %s", label,
                 goal->value, unit, end, unit);
}

/* Drives a coordinate to its value; at a branch point the branch that moves it fastest is taken first. */
static km_status drive_to_value(value_search *j, const km_hold *goal, km_error *error) {
  if (has_value(j, goal))
    return KM_OK;
  double distance = goal->value - coordinate_value(j, goal->coordinate);
  if (km_branch_depart(j->mechanism, j->state, goal->coordinate, distance).branch_count < 0)
    return km_fail(error, KM_MEMORY, "out of memory while moving to a pose");
  km_driver_motion *drive;
  km_status status = km_driver_motion_create(j->mechanism, j->state, goal->coordinate, true, &drive, error);
  if (status)
    return status;
  km_motion_end reach = km_driver_motion_move_to(drive, goal->value);
  km_driver_motion_free(drive);
  if (reach.stop == KM_STOP_MAX_STEPS)
    return km_fail(error, KM_DIVERGED, "moving %s to %.9g stopped at %.9g: too many steps",
                   km_model_coordinate_label(j->model, goal->coordinate), goal->value, reach.position);
  return reach.stop && !is_within_tolerance(j, goal) ? fail_unreachable(j, goal, reach.position, error) : KM_OK;
}

/* Moves a ball joint: its three components are locked at values that change in 64 equal steps, with the loops closed
 * at each. */
static km_status move_ball_to_value(value_search *j, const km_hold *goal, km_error *error) {
  enum { STEPS = 64 };
  double from[3];
  bool there = true;
  for (int k = 0; k < 3; ++k) {
    from[k] = coordinate_value(j, goal[k].coordinate);
    there = there && (has_value(j, &goal[k]) || is_within_tolerance(j, &goal[k]));
  }
  for (int i = there ? STEPS : 1; i <= STEPS; ++i) {
    for (int k = 0; k < 3; ++k) {
      double value = i == STEPS ? goal[k].value : from[k] + (goal[k].value - from[k]) * i / STEPS;
      set_and_lock(j, &(km_hold){goal[k].coordinate, value});
    }
    km_state_set(j->mechanism, j->state, j->state->q);
    for (int s = 0; s < j->mechanism->topology.substructure_count; ++s) {
      km_closure evidence;
      if (km_loops_close(j->mechanism, j->state, s, KM_NO_DRIVER, &evidence) != KM_CLOSED || evidence.correction > 0.5)
        return fail_unreachable(j, goal, from[0] + (goal[0].value - from[0]) * (i - 1) / STEPS, error);
    }
  }
  return KM_OK;
}

static km_status check_ball_components(const value_search *j, const km_hold *goals, int count, int index,
                                       km_error *error) {
  int ball = j->mechanism->ball_of[goals[index].coordinate], first = j->mechanism->ball_coordinate[ball];
  for (int k = 0; k < 3; ++k)
    if (index + k >= count || goals[index + k].coordinate != first + k)
      return km_fail(error, KM_USAGE,
                     "\"%s\" is a component of a rotation vector; expected all three together, as %s=x,y,z",
                     km_model_coordinate_label(j->model, goals[index].coordinate),
                     j->model->joints[j->model->coordinates[first].joint].label);
  return KM_OK;
}

/* Assembles from the start with the goals' values in place of the file's; these are locked. */
static km_status assemble_at_goals(value_search *j, const km_hold *holds, int hold_count, const km_hold *sets,
                                   int set_count, km_error *error) {
  km_state_restart(j->state);
  for (int i = 0; i < hold_count + set_count; ++i)
    set_and_lock(j, i < hold_count ? &holds[i] : &sets[i - hold_count]);
  km_state_set(j->mechanism, j->state, j->state->q);
  return km_assemble(j->mechanism, j->state, NULL, error);
}

/* Moves each coordinate to its value in turn and locks it. */
static km_status move_to_values(value_search *j, const km_hold *goals, int count, km_error *error) {
  for (int i = 0; i < count;) {
    bool ball = j->mechanism->ball_of[goals[i].coordinate] >= 0;
    km_status status = ball ? check_ball_components(j, goals, count, i, error) : KM_OK;
    if (!status)
      status = ball ? move_ball_to_value(j, &goals[i], error) : drive_to_value(j, &goals[i], error);
    if (status)
      return status;
    for (int end = i + (ball ? 3 : 1); i < end; ++i)
      lock_at_value(j, &goals[i]);
  }
  return KM_OK;
}

/* Renumbers a mechanism that holds the same coordinates, with new held values. */
static km_status renumber_held(km_mechanism *held, const km_hold *holds, int hold_count, km_error *error) {
  for (int h = 0; h < hold_count; ++h)
    held->holds[h].value = holds[h].value;
  return km_mechanism_renumber(held, error);
}

static km_status compile_held(const km_mechanism *free, const km_hold *holds, int hold_count, km_mechanism **held,
                              km_state **at, km_error *error) {
  km_compiling options = {
      .holds = holds, .hold_count = hold_count, .length = free->length, .length_source = free->length_source};
  km_status status = km_mechanism_compile_as(free->model, &options, held, error);
  return status ? status : km_state_create(*held, at, error);
}

/* Creates or renumbers the mechanism with the holds, and its state at the configuration reached without them: a held
 * loop has its own motion space. */
static km_status transfer_to_held(const km_mechanism *free, const km_state *there, const km_hold *holds, int hold_count,
                                  km_mechanism **held, km_state **at, km_error *error) {
  km_status status =
      *held ? renumber_held(*held, holds, hold_count, error) : compile_held(free, holds, hold_count, held, at, error);
  if (status)
    return status;
  km_state_restart(*at);
  km_state_copy(*held, *at, there);
  return KM_OK;
}

km_status km_mechanism_recompile_at(const km_mechanism *free, km_state *there, const km_hold *holds, int hold_count,
                                    const km_hold *sets, int set_count, km_mechanism **held, km_state **at,
                                    km_error *error) {
  value_search j = {free->model, free, there};
  km_state_restart(there);
  km_status status = km_assemble(free, there, NULL, error);
  km_error ignored;
  if (status == KM_MODEL && hold_count + set_count > 0 &&
      !assemble_at_goals(&j, holds, hold_count, sets, set_count, &ignored))
    status = KM_OK;
  if (!status)
    status = move_to_values(&j, holds, hold_count, error);
  if (!status)
    status = move_to_values(&j, sets, set_count, error);
  if (!status && hold_count > 0)
    status = transfer_to_held(free, there, holds, hold_count, held, at, error);
  if (!status && hold_count == 0)
    km_state_unlock(there);
  return status;
}

static km_status compile_and_move(const km_model *model, const km_hold *holds, int hold_count, const km_hold *sets,
                                  int set_count, km_mechanism **mechanism, km_state **state, km_error *error) {
  km_mechanism *free = NULL;
  km_state *there = NULL;
  km_status status = km_mechanism_compile(model, NULL, 0, &free, error);
  if (!status)
    status = km_state_create(free, &there, error);
  if (!status)
    status = km_mechanism_recompile_at(free, there, holds, hold_count, sets, set_count, mechanism, state, error);
  if (!status && hold_count == 0) {
    *mechanism = free;
    *state = there;
    return KM_OK;
  }
  km_state_free(there);
  km_mechanism_free(free);
  return status;
}

static km_status check_goals(const km_model *model, const km_hold *goals, int count, const char *what,
                             km_error *error) {
  km_status status = km_check_list(goals, count, what, error);
  for (int i = 0; i < count && !status; ++i)
    status = km_check_index(goals[i].coordinate, model->coordinate_count, "coordinate", error);
  return status;
}

km_status km_mechanism_compile_at(const km_model *model, const km_hold *holds, int hold_count, const km_hold *sets,
                                  int set_count, km_mechanism **mechanism, km_state **state, km_error *error) {
  if (!mechanism || !state)
    return km_check_given(false, "place for the result", error);
  *mechanism = NULL;
  *state = NULL;
  km_status fits = km_check_given(model != NULL, "model", error);
  if (!fits)
    fits = check_goals(model, holds, hold_count, "holds", error);
  if (!fits)
    fits = check_goals(model, sets, set_count, "values", error);
  if (fits)
    return fits;
  km_status status = compile_and_move(model, holds, hold_count, sets, set_count, mechanism, state, error);
  if (status) {
    km_state_free(*state);
    km_mechanism_free(*mechanism);
    *state = NULL;
    *mechanism = NULL;
  }
  return status;
}

km_status km_state_move_to(const km_mechanism *m, km_state *s, const km_hold *sets, int set_count, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = check_goals(m->model, sets, set_count, "values", error);
  for (int i = 0; i < set_count && !status; ++i)
    if (m->held[sets[i].coordinate])
      status = km_fail(error, KM_USAGE, "\"%s\" is held; expected a joint that is free to move",
                       km_model_coordinate_label(m->model, sets[i].coordinate));
  if (status)
    return status;
  km_state *there = NULL;
  status = km_state_create(m, &there, error);
  value_search j = {m->model, m, there};
  if (!status) {
    km_state_copy(m, there, s);
    status = move_to_values(&j, sets, set_count, error);
  }
  if (!status) {
    km_state_copy(m, s, there);
    for (int i = 0; i < m->topology.substructure_count; ++i)
      km_state_invalidate_pivots(s, i);
    status = km_assemble(m, s, NULL, error);
  }
  km_state_free(there);
  return status;
}
