/* Sweeps by arc length. */
#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"
#include "local/bifurcation.h"
#include "sweep/sweep.h"

#include <math.h>

static bool rates(void *self, double *out) {
  km_arc_motion_tangent(self, out);
  return true;
}

static bool probe(void *self, double s, double *out) {
  return km_arc_motion_sample(self, s - km_arc_motion_length(self), out);
}

static void settle(void *self) {
  km_arc_motion_restore(self);
}

static double dot(const km_sweeper *r, const double *a, const double *b) {
  return km_step_dot(r->m, &r->m->substructures[r->substructure], a, b);
}

/* The plan's branch: 1 goes on smoothly; 2, 3 are the next motion ahead and back, 4, 5 the one after. */
static const double *chosen(const km_sweeper *r, double *directions, int count, const double *smooth) {
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

static km_status no_such_branch(int branch, const km_branch_point *point, km_error *error) {
  if (point->branches == 0)
    return km_fail(error, KM_USAGE, "branch %d: the motions that meet at %.9g weren't found; expected 1", branch,
                   point->s);
  return km_fail(error, KM_USAGE, "branch %d: %d motions meet at %.9g; expected at most %d", branch, point->branches,
                 point->s, 2 * point->branches - 1);
}

/* Looks at the branch point that was passed, and turns there if the plan says so. */
static km_status meet_branch(km_sweeper *r, km_arc_motion *follow, km_error *error) {
  km_branch_point point;
  size_t columns = (size_t)r->m->substructures[r->substructure].columns;
  if (!km_arc_motion_branch(follow, &point))
    return KM_OK;
  double *directions = KM_NEW(double, (KM_MAX_BRANCHES + 1) * columns);
  if (!directions)
    return km_fail(error, KM_MEMORY, "out of memory for the branch points");
  double *smooth = directions + KM_MAX_BRANCHES * columns;
  km_arc_motion_move_to_branch_point(follow, smooth);
  km_status status = km_sweeper_look_at_branch(r, r->s, directions, &point.branches, error);
  if (!status)
    status = km_sweeper_add_branch(r, point, error);
  bool here = r->plan->branch > 1 && r->out->branch_count == 1;
  const double *turn = here ? chosen(r, directions, point.branches, smooth) : NULL;
  if (turn) {
    km_arc_motion_take_branch(follow, turn);
    if (r->observer->corner)
      r->observer->corner(r->observer->self);
  } else {
    km_arc_motion_continue(follow);
  }
  km_free(directions);
  return status || !here || turn ? status : no_such_branch(r->plan->branch, &point, error);
}

/* How far to go at once: all of it, or as far as the observer may miss and come back from in one step. */
static double stretch(const km_sweeper *r, km_arc_motion *follow, double left) {
  double reached, longest = fmin(KM_LONGEST_ARC, r->plan->arclength * r->plan->steps / KM_LEAST_SAMPLES);
  double step = r->observer->passed && left > 1.5 * longest ? longest : left;
  while (r->observer->passed && step > 1e-3 * longest && !km_arc_motion_step(follow, step, &reached))
    step *= 0.5;
  if (r->observer->passed)
    km_arc_motion_restore(follow);
  return step;
}

/* Shows the observer the poses between s and the end of the motion, where the state stands, or (away) from there to s.
 */
static km_status show_end(km_sweeper *r, double s, double end, bool away, km_error *error) {
  km_status status = KM_OK;
  if (!r->observer->passed || km_sweeper_meets(r))
    return KM_OK;
  for (int k = 1; k <= KM_END_PLACES && !status; ++k) {
    double x = km_sweeper_near_end(s, end, away ? KM_END_PLACES + 1 - k : k);
    if (probe(r->mover.self, x, r->rates))
      status = r->observer->passed(r->observer->self, r, x, error);
  }
  settle(r->mover.self);
  return status;
}

/* To an arc length, through the branch points on the way; not past the start of the cycle. */
static km_status advance_to(km_sweeper *r, km_arc_motion *follow, double length, bool last, km_status *moved,
                            km_error *error) {
  km_status status = KM_OK;
  *moved = KM_OK;
  if (km_arc_motion_length(follow) == 0.0)
    status = show_end(r, stretch(r, follow, length), 0.0, true, error);
  double near = fmax(1e-9 * r->plan->arclength, KM_SHORTEST_ARC);
  while (!status && !*moved && !km_arc_motion_closed(follow) && length - km_arc_motion_length(follow) > near) {
    double left = length - km_arc_motion_length(follow), step = stretch(r, follow, left),
           seen = km_arc_motion_length(follow);
    *moved = km_arc_motion_advance(follow, step);
    status = meet_branch(r, follow, error);
    if (!status && !*moved && step < left && !km_arc_motion_closed(follow))
      status = r->observer->passed(r->observer->self, r, km_arc_motion_length(follow), error);
    if (!status && (*moved || (last && step >= left)))
      status = show_end(r, seen, km_arc_motion_length(follow), false, error);
  }
  return status;
}

static km_stop reason(const km_arc_motion *follow, km_status moved) {
  return !moved ? KM_STOP_NONE : km_arc_motion_limit(follow) >= 0 ? KM_STOP_LIMIT : KM_STOP_TOGGLE;
}

static km_status row(km_sweeper *r, int step, double s, km_error *error) {
  km_status status = km_sweeper_row(r, step, s, error);
  return status ? status : km_sweeper_near_row(r, error);
}

static km_status rows(km_sweeper *r, km_arc_motion *follow, km_error *error) {
  const km_sweep_plan *plan = r->plan;
  km_status status = row(r, 0, 0.0, error);
  for (int i = 1; i <= plan->steps && !status; ++i) {
    if (!km_sweeper_goes_on(r, i))
      return km_fail(error, KM_CANCELLED, "stopped at %g", km_arc_motion_length(follow));
    km_status moved;
    status = advance_to(r, follow, plan->arclength * i, i == plan->steps, &moved, error);
    if (km_arc_motion_closed(follow)) {
      r->out->cycle = km_arc_motion_cycle(follow);
      km_arc_motion_pass_cycle(follow);
      if (!plan->cycle && !status)
        status = advance_to(r, follow, plan->arclength * i, i == plan->steps, &moved, error);
    }
    r->out->end = (km_motion_end){reason(follow, moved), km_arc_motion_length(follow), r->substructure,
                                  km_arc_motion_limit(follow)};
    if (plan->cycle && r->out->cycle > 0.0)
      return status; /* the row that repeats the start is left out */
    if (!status)
      status = row(r, i, moved ? km_arc_motion_length(follow) : plan->arclength * i, error);
    if (moved)
      return status ? status : KM_PARTIAL;
  }
  return !status && plan->cycle ? KM_PARTIAL : status;
}

static bool stands(void *self, double *out) {
  (void)self;
  (void)out;
  return false;
}

/* Nothing moves: the starting pose is all there is. */
static km_status only_row(km_sweeper *r, km_error *error) {
  r->mover = (km_mover){NULL, stands, NULL, NULL, NULL, NULL};
  r->out->end = (km_motion_end){KM_STOP_TOGGLE, 0.0, -1, -1};
  km_status status = km_sweeper_row(r, 0, 0.0, error);
  return status ? status : KM_PARTIAL;
}

km_status km_sweep_by_length(km_sweeper *r, km_error *error) {
  km_arc_motion *follow;
  km_status status = km_sweeper_prepare(r, error);
  if (!status)
    status =
        km_arc_motion_create(r->m, r->s, r->plan->direction, r->plan->sign, r->plan->ignore_limits, &follow, error);
  if (status)
    return status == KM_NO_RESULT ? only_row(r, error) : status;
  km_arc_motion_set_observer(follow, km_sweeper_step_watch(r));
  r->mover = (km_mover){follow, rates, probe, settle, NULL, NULL};
  r->substructure = r->out->substructure = km_arc_motion_substructure(follow);
  r->out->start_branches = km_arc_motion_start_branches(follow);
  status = km_sweeper_prepare(r, error);
  if (!status)
    status = rows(r, follow, error);
  km_arc_motion_free(follow);
  return status;
}
