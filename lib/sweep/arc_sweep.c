/* Sweeps by arc length: rows, branch points, cycles and samples between rows (theory 4.9, 10.1). */
#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"
#include "local/bifurcation.h"
#include "sweep/sweep.h"

#include <math.h>

static bool read_rates(void *self, double *out) {
  km_arc_motion_tangent(self, out);
  return true;
}

static bool probe(void *self, double s, double *out) {
  return km_arc_motion_sample(self, s - km_arc_motion_length(self), out);
}

static void restore(void *self) {
  km_arc_motion_restore(self);
}

static double dot(const km_sweeper *r, const double *a, const double *b) {
  return km_step_dot(r->m, &r->m->substructures[r->substructure], a, b);
}

/* Returns the direction of the plan's branch: 1 continues smoothly (NULL); 2, 3 are the next branch ahead and back,
 * 4, 5 the one after. */
static const double *choose_branch(const km_sweeper *r, double *directions, int count, const double *smooth) {
  const km_substructure *sub = &r->m->substructures[r->substructure];
  int other = 0;
  for (int i = 0; i < count; ++i) {
    double *x = directions + (size_t)i * (size_t)sub->columns;
    if (fabs(dot(r, x, smooth)) > 0.99 * sqrt(dot(r, smooth, smooth)))
      continue;
    if (other++ != (r->plan->branch - 2) / 2)
      continue;
    double sense = dot(r, x, smooth) < 0.0 ? -1.0 : 1.0;
    if (r->plan->branch % 2 == 1)
      sense = -sense;
    for (int k = 0; k < sub->columns; ++k)
      x[k] *= sense;
    return x;
  }
  return NULL;
}

static km_status fail_unknown_branch(int branch, const km_branch_point *point, km_error *error) {
  if (point->branches == 0)
    return km_fail(error, KM_USAGE, "branch %d: the motions that meet at %.9g weren't found; expected 1", branch,
                   point->s);
  return km_fail(error, KM_USAGE, "branch %d: %d motions meet at %.9g; expected at most %d", branch, point->branches,
                 point->s, 2 * point->branches - 1);
}

/* Records the branch point that was passed, and switches the branch if the plan requests it. */
static km_status handle_branch_point(km_sweeper *r, km_arc_motion *motion, km_error *error) {
  km_branch_point point;
  size_t columns = (size_t)r->m->substructures[r->substructure].columns;
  if (!km_arc_motion_branch(motion, &point))
    return KM_OK;
  double *directions = KM_NEW(double, (KM_MAX_BRANCHES + 1) * columns);
  if (!directions)
    return km_fail(error, KM_MEMORY, "out of memory for the branch points");
  double *smooth = directions + KM_MAX_BRANCHES * columns;
  km_arc_motion_move_to_branch_point(motion, smooth);
  km_status status = km_sweeper_find_branch_directions(r, r->s, directions, &point.branches, error);
  if (!status)
    status = km_sweeper_add_branch(r, point, error);
  bool may_switch = r->plan->branch > 1 && r->out->branch_count == 1;
  const double *branch = may_switch ? choose_branch(r, directions, point.branches, smooth) : NULL;
  if (branch) {
    km_arc_motion_take_branch(motion, branch);
    if (r->observer->corner)
      r->observer->corner(r->observer->self);
  } else {
    km_arc_motion_restore(motion);
  }
  km_free(directions);
  return status || !may_switch || branch ? status : fail_unknown_branch(r->plan->branch, &point, error);
}

/* Returns the next step: all of `left`, or the longest arc between samples from which one step returns. */
static double choose_step(const km_sweeper *r, km_arc_motion *motion, double left) {
  double reached, longest = fmin(KM_LONGEST_ARC, r->plan->arclength * r->plan->steps / KM_MIN_SAMPLES);
  double step = r->observer->sampled_between && left > 1.5 * longest ? longest : left;
  while (r->observer->sampled_between && step > 1e-3 * longest && !km_arc_motion_step(motion, step, &reached))
    step *= 0.5;
  if (r->observer->sampled_between)
    km_arc_motion_restore(motion);
  return step;
}

/* Samples between s and the end of the motion at geometrically decreasing distances; away: from the start to s. */
static km_status sample_near_end(km_sweeper *r, double s, double end, bool away, km_error *error) {
  km_status status = KM_OK;
  if (!r->observer->sampled_between || km_sweeper_is_at_branch_point(r))
    return KM_OK;
  for (int k = 1; k <= KM_END_SAMPLES && !status; ++k) {
    double x = km_sweeper_end_sample(s, end, away ? KM_END_SAMPLES + 1 - k : k);
    if (probe(r->mover.self, x, r->rates))
      status = r->observer->sampled_between(r->observer->self, r, x, error);
  }
  restore(r->mover.self);
  return status;
}

/* Advances to an arc length, through branch points, not past the start of the cycle. */
static km_status advance_to(km_sweeper *r, km_arc_motion *motion, double length, bool last, km_status *motion_status,
                            km_error *error) {
  km_status status = KM_OK;
  *motion_status = KM_OK;
  if (km_arc_motion_length(motion) == 0.0)
    status = sample_near_end(r, choose_step(r, motion, length), 0.0, true, error);
  double near = fmax(1e-9 * r->plan->arclength, KM_SHORTEST_ARC);
  while (!status && !*motion_status && !km_arc_motion_closed(motion) && length - km_arc_motion_length(motion) > near) {
    double left = length - km_arc_motion_length(motion), step = choose_step(r, motion, left),
           last_sample = km_arc_motion_length(motion);
    *motion_status = km_arc_motion_advance(motion, step);
    status = handle_branch_point(r, motion, error);
    if (!status && !*motion_status && step < left && !km_arc_motion_closed(motion))
      status = r->observer->sampled_between(r->observer->self, r, km_arc_motion_length(motion), error);
    if (!status && (*motion_status || (last && step >= left)))
      status = sample_near_end(r, last_sample, km_arc_motion_length(motion), false, error);
  }
  return status;
}

static km_stop stop_reason(const km_arc_motion *motion, km_status motion_status) {
  return !motion_status ? KM_STOP_NONE : km_arc_motion_limit(motion) >= 0 ? KM_STOP_LIMIT : KM_STOP_TOGGLE;
}

static km_status write_row(km_sweeper *r, int step, double s, km_error *error) {
  km_status status = km_sweeper_row(r, step, s, error);
  return status ? status : km_sweeper_near_row(r, error);
}

static km_status write_rows(km_sweeper *r, km_arc_motion *motion, km_error *error) {
  const km_sweep_plan *plan = r->plan;
  km_status status = write_row(r, 0, 0.0, error);
  for (int i = 1; i <= plan->steps && !status; ++i) {
    if (!km_sweeper_continues(r, i))
      return km_fail(error, KM_CANCELLED, "stopped at %g", km_arc_motion_length(motion));
    km_status motion_status;
    status = advance_to(r, motion, plan->arclength * i, i == plan->steps, &motion_status, error);
    if (km_arc_motion_closed(motion)) {
      r->out->cycle = km_arc_motion_cycle_length(motion);
      km_arc_motion_continue_past_cycle(motion);
      if (!plan->cycle && !status)
        status = advance_to(r, motion, plan->arclength * i, i == plan->steps, &motion_status, error);
    }
    r->out->end = (km_motion_end){stop_reason(motion, motion_status), km_arc_motion_length(motion), r->substructure,
                                  km_arc_motion_limit(motion)};
    if (plan->cycle && r->out->cycle > 0.0)
      return status; /* the row that repeats the start is omitted */
    if (!status)
      status = write_row(r, i, motion_status ? km_arc_motion_length(motion) : plan->arclength * i, error);
    if (motion_status)
      return status ? status : KM_PARTIAL;
  }
  return !status && plan->cycle ? KM_PARTIAL : status;
}

km_status km_sweep_by_length(km_sweeper *r, km_error *error) {
  km_arc_motion *motion;
  km_status status = km_sweeper_prepare(r, error);
  if (!status)
    status =
        km_arc_motion_create(r->m, r->s, r->plan->direction, r->plan->sign, r->plan->ignore_limits, &motion, error);
  if (status == KM_NO_RESULT) { /* nothing moves */
    r->out->end = (km_motion_end){KM_STOP_TOGGLE, 0.0, -1, -1};
    status = km_sweeper_single_row(r, error);
    return status ? status : KM_PARTIAL;
  }
  if (status)
    return status;
  km_arc_motion_set_observer(motion, km_sweeper_step_observer(r));
  r->mover = (km_mover){motion, read_rates, probe, restore, NULL, NULL};
  r->substructure = r->out->substructure = km_arc_motion_substructure(motion);
  r->out->start_branches = km_arc_motion_start_branches(motion);
  status = km_sweeper_prepare(r, error);
  if (!status)
    status = write_rows(r, motion, error);
  km_arc_motion_free(motion);
  return status;
}
