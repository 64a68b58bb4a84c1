/* Branch points of driven sweeps: location between rows by arc length, and departure from one at the start (theory
 * 4.10). */
#include "continuation/arc_motion.h"
#include "local/bifurcation.h"
#include "sweep/sweep.h"

#include <math.h>

km_status km_sweeper_add_branch(km_sweeper *r, km_branch_point point, km_error *error) {
  void *branches = r->out->branches;
  if (!km_reserve(&branches, &r->out->branch_capacity, r->out->branch_count + 1, sizeof point))
    return km_fail(error, KM_MEMORY, "out of memory for the branch points");
  r->out->branches = branches;
  r->out->branches[r->out->branch_count++] = point;
  return KM_OK;
}

km_status km_sweeper_find_branch_directions(const km_sweeper *r, km_state *state, double *directions, int *count,
                                            km_error *error) {
  int found = km_branch_directions(r->m, state, r->substructure, directions);
  *count = found > 1 ? found : 0;
  return found < 0 ? km_fail(error, KM_MEMORY, "out of memory for the branch points") : KM_OK;
}

/* Adds a branch point with its branches; `always`: even if fewer than two branches are found. */
static km_status add_branch(km_sweeper *r, km_state *state, km_branch_point point, bool always, km_error *error) {
  size_t columns = (size_t)r->m->substructures[r->substructure].columns;
  double *directions = KM_NEW(double, KM_MAX_BRANCHES *columns);
  if (!directions)
    return km_fail(error, KM_MEMORY, "out of memory for the branch points");
  km_status status = km_sweeper_find_branch_directions(r, state, directions, &point.branches, error);
  km_free(directions);
  return status || (!always && point.branches == 0) ? status : km_sweeper_add_branch(r, point, error);
}

/* Follows the motion by arc length from a row of the table to the branch point behind it, at most to driver value
 * `to`, on a state of its own. */
static km_status follow_to_branch(km_sweeper *r, km_state *state, size_t row, double to, km_error *error) {
  const double *cells = km_table_row(r->out->table, row);
  double from = cells[1], most = 1000.0;
  for (int c = 0; c < r->m->coordinate_count; ++c)
    r->scratch[c] = cells[2 + c] * km_model_coordinate_factor(r->m->model, c);
  km_state_set(r->m, state, r->scratch);
  km_arc_motion *follow;
  km_branch_point point;
  if (km_arc_motion_create(r->m, state, r->plan->coordinate, to - from, true, &follow, NULL))
    return KM_OK; /* a singular row was added before */
  km_status status = KM_OK;
  bool found = false, is_passed = false;
  while (!found && !is_passed && !km_arc_motion_closed(follow) && km_arc_motion_length(follow) < most &&
         !km_arc_motion_advance(follow, 0.05)) {
    found = km_arc_motion_branch(follow, &point);
    is_passed = (km_state_coordinate(state, r->plan->coordinate) - to) * (to - from) > 0.0;
  }
  if (found) {
    km_arc_motion_move_to_branch_point(follow, r->scratch);
    point.s = km_state_coordinate(state, r->plan->coordinate);
    status = add_branch(r, state, point, true, error);
  }
  km_arc_motion_free(follow);
  return status;
}

/* Locates the branch point that the motion passed before the last row, and its branches. Not searched if some columns
 * are unread. */
km_status km_sweeper_find_branch(km_sweeper *r, km_error *error) {
  size_t rows = km_table_rows(r->out->table);
  const double *last = km_table_row(r->out->table, rows - 1);
  int mobility = km_factor_freedom(r->s->factor[r->substructure]);
  /* the row itself is singular; with the motion's own number of freedoms its rank was only hard to determine */
  if (mobility > 1)
    return add_branch(r, r->s, (km_branch_point){last[1], mobility, 0}, mobility > r->out->freedom, error);
  if (rows < 2 || r->observer->unread)
    return KM_OK;
  km_state *state;
  km_status status = km_state_create(r->m, &state, error);
  if (status)
    return status;
  status = follow_to_branch(r, state, rows - 2, last[1], error);
  km_state_free(state);
  return status;
}

/* Returns the distance of the driver's first step: to FROM or, at FROM, to the first sample. */
static double first_distance(const km_sweeper *r, bool *is_first) {
  const km_sweep_plan *plan = r->plan;
  double position = km_state_coordinate(r->s, plan->coordinate), distance = plan->from - position;
  *is_first = fabs(distance) <= 1e-12 * (1.0 + fabs(position));
  int samples = r->observer->sampled_between && plan->steps < KM_MIN_SAMPLES ? KM_MIN_SAMPLES : plan->steps;
  return *is_first ? (plan->to - plan->from) / samples : distance;
}

km_status km_sweeper_leave_branch(km_sweeper *r, km_error *error) {
  int coordinate = r->plan->coordinate, index = r->m->substructure_of[coordinate];
  if (index < 0)
    return KM_OK;
  const km_substructure *sub = &r->m->substructures[index];
  bool is_first;
  double distance = first_distance(r, &is_first);
  double *pose = KM_NEW(double, KM_SAVED_PER_COLUMN *(size_t)sub->columns);
  km_branch_exit exit_point = {.branch_count = -1};
  if (pose) {
    km_state_save(r->s, sub, pose);
    exit_point = km_branch_depart(r->m, r->s, coordinate, distance);
  }
  r->out->start_branches = exit_point.branch_count;
  if (exit_point.branch_count < 0) {
    km_free(pose);
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  if (is_first && exit_point.has_further_freedoms)
    r->branch_first_row = pose;
  else
    km_free(pose);
  return KM_OK;
}
