/* Sweeps by one driven coordinate. */
#include "analysis/branches.h"
#include "analysis/sweeper.h"
#include "kinematics/closure.h"

#include <math.h>

/* FROM is out of reach and the motion towards it ended at a bound: does s lie in what is left of the range? */
static bool reachable(const km_sweeper *r, double s) {
  const km_sweep_plan *plan = r->plan;
  double bound = r->out->start.position;
  return plan->to >= plan->from ? bound > plan->from && s > bound : bound < plan->from && s < bound;
}

static km_status rows(km_sweeper *r, km_error *error) {
  km_drive *drive = r->mover.self;
  const km_sweep_plan *plan = r->plan;
  km_reach *start = &r->out->start, *end = &r->out->end;
  *start = *end = km_drive_to(drive, plan->from);
  km_status status = km_sweeper_row(r, 0, start->position, error);
  int row = 1;
  double last = start->position;
  for (int i = 1; i <= plan->steps && !status; ++i) {
    double s = i == plan->steps ? plan->to : plan->from + (plan->to - plan->from) * i / plan->steps;
    if (start->stop && !reachable(r, s))
      continue;
    if (!km_sweeper_goes_on(r, i))
      return km_fail(error, KM_CANCELLED, "stopped at %g", s);
    *end = km_drive_to(drive, s);
    bool again = end->stop && fabs(end->position - last) <= 1e-9 * (1.0 + fabs(last));
    if (!again) /* the end may be where the last row stands already */
      status = km_sweeper_row(r, row++, end->position, error);
    last = end->position;
    if (end->stop)
      break;
  }
  for (int i = 0; i < 2 && !status; ++i) { /* where the driver itself gives out */
    const km_reach *reach = i ? end : start;
    bool again = i && end->position == start->position;
    if (reach->stop == KM_STOP_TOGGLE && !again && !km_sweeper_add_toggle(r->out, plan->coordinate, reach->position))
      status = km_fail(error, KM_MEMORY, "out of memory for the toggles");
  }
  if (status)
    return status;
  if (start->stop == KM_STOP_GAVE_OUT || end->stop == KM_STOP_GAVE_OUT)
    return km_fail(error, KM_DIVERGED,
                   "the sweep gave out at %.9g: too many steps to the next row; expected a range that "
                   "so many rows resolve",
                   end->position);
  return start->stop || end->stop ? KM_PARTIAL : KM_OK;
}

static bool rates(void *self, double *out) {
  return km_drive_tangent(self, out);
}

static bool probe(void *self, double s, double *out) {
  return !km_drive_to(self, s).stop && km_drive_tangent(self, out);
}

static void settle(void *self, double s) {
  km_drive_to(self, s);
}

/* At a branch point no direction is the mechanism's own: a short step leads onto the motion that moves the driver
 * most, from where the branch point can be passed smoothly. */
static km_status leave_branch_point(km_sweeper *r, km_error *error) {
  enum { MOST_BRANCHES = 16 };
  static const double short_step = 5e-3;
  const km_mechanism *m = r->m;
  if (r->substructure < 0)
    return KM_OK;
  const km_substructure *sub = &m->substructures[r->substructure];
  double *directions = KM_NEW(double, (size_t)MOST_BRANCHES * (size_t)sub->columns), largest = 0.0;
  if (!directions)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  int column = m->column_of[r->plan->coordinate], best = -1;
  r->out->start_branches = km_branch_directions(m, r->s, r->substructure, directions, MOST_BRANCHES);
  for (int i = 0; i < r->out->start_branches; ++i) {
    double rate = fabs(directions[(size_t)i * (size_t)sub->columns + (size_t)column]);
    if (rate > 1.000001 * largest) {
      largest = rate;
      best = i;
    }
  }
  if (best >= 0) {
    km_closure evidence;
    double *step = directions + (size_t)best * (size_t)sub->columns;
    for (int k = 0; k < sub->columns; ++k)
      step[k] *= short_step;
    km_state_move(m, r->s, sub, step);
    r->s->pivoted[r->substructure] = KM_NEVER;
    km_close(m, r->s, r->substructure, KM_NO_DRIVER, &evidence);
  }
  km_free(directions);
  return KM_OK;
}

km_status km_sweep_by_driver(km_sweeper *r, km_error *error) {
  km_drive *drive;
  r->substructure = r->out->substructure = r->m->substructure_of[r->plan->coordinate];
  km_status status = leave_branch_point(r, error);
  if (status)
    return status;
  status = km_drive_create(r->m, r->s, r->plan->coordinate, r->plan->ignore_limits, &drive, error);
  if (status)
    return status;
  r->mover = (km_mover){drive, rates, probe, settle};
  km_sweeper_prepare(r);
  status = rows(r, error);
  km_drive_free(drive);
  return status;
}
