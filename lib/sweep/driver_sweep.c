/* Sweeps by one driven coordinate. */
#include "sweep/driver_sweep.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/rank_evidence.h"
#include "sweep/stop_cause.h"

#include <math.h>
#include <string.h>

/* FROM is out of reach and the motion towards it ended at a bound: does s lie in what is left of the range? */
static bool reachable(const km_sweeper *r, double s) {
  const km_sweep_plan *plan = r->plan;
  double bound = r->out->start.position, away = plan->to >= plan->from ? 1.0 : -1.0;
  return away * (bound - plan->from) > 0.0 && away * (s - bound) > 1e-9 * (1.0 + fabs(bound));
}

/* The driver's next value; false where the sweep is over. */
static bool next(km_driver_sweep *w, double *target) {
  km_sweeper *r = w->r;
  const km_sweep_plan *plan = r->plan;
  if (w->job->status || w->over)
    return false;
  *target = plan->from;
  if (w->step == 0)
    return true;
  for (; w->step <= plan->steps; ++w->step) {
    double s = km_walk_value(plan, w->step);
    if (r->out->start.stop && !reachable(r, s))
      continue;
    if (!km_sweeper_goes_on(r, w->step)) {
      w->job->status = km_fail(w->job->error, KM_CANCELLED, "stopped at %g", s);
      return false;
    }
    w->crossings = km_driver_motion_crossings(w->at.drive);
    *target = s;
    return true;
  }
  return false;
}

/* The singular value that lies within a factor of ten of the tolerance by which rounded data counts as dependent; 0: there is none. */
static double rank_value(const km_mechanism *m, km_state *s, int substructure) {
  static const double near = 10.0;
  const double tolerance = km_rank_tolerance(m, &m->substructures[substructure], 0.0);
  km_rank_evidence e;
  if (!m->closure_tolerance_given)
    return 0.0;
  km_update_and_search_pivots(m, s, substructure, KM_NO_DRIVER, 0.0);
  km_poses_compute(m, s);
  if (km_rank_evidence_find(m, s, substructure, &e, NULL))
    return 0.0;
  return e.dropped > tolerance / near ? e.dropped : e.kept < near * tolerance ? e.kept : 0.0;
}

/* Why the driver came no further, of the start and of the end. */
static void note_cause(const km_driver_sweep *w, const km_motion_end *reach) {
  km_sweep *out = w->r->out;
  char **cause = &out->causes[w->step > 0];
  if (reach->stop != KM_STOP_TOGGLE || reach->substructure < 0 || out->freedom == 0 || *cause)
    return;
  out->rank_value[w->step > 0] = rank_value(w->r->m, w->r->s, reach->substructure);
  if (out->rank_value[w->step > 0] == 0.0)
    *cause = km_stop_cause(w->r->m, w->r->s, reach->substructure, w->r->plan->coordinate);
}

/* The row where the drive has arrived; then what the observer wants to see near it has to follow. */
static void write_row(km_driver_sweep *w, km_motion_end reach) {
  km_sweeper *r = w->r;
  km_status status = KM_OK;
  if (w->job->status) /* on the way */
    return;
  km_driver_sweep_prepare(w);
  r->out->end = reach;
  if (w->step == 0)
    r->out->start = reach;
  bool again = w->step > 0 && reach.stop && fabs(reach.position - w->last) <= 1e-9 * (1.0 + fabs(w->last));
  if (reach.stop == KM_STOP_MAX_STEPS)
    status = km_fail(
        w->job->error, KM_DIVERGED,
        "the sweep gave out at %.9g: too many steps to the next row; expected a range that so many rows resolve",
        reach.position);
  else if (!again) /* the end may be where the last row stands already */
    status = km_sweeper_row(r, w->row++, reach.position, w->job->error);
  if (!status)
    note_cause(w, &reach);
  w->job->status = status;
}

/* The first row at the branch point from which the drive has set out already, whose tangent it shows there. */
static void write_branch_point(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  size_t columns = (size_t)r->m->substructures[r->substructure].columns;
  double *pose = KM_NEW(double, KM_SAVED_PER_COLUMN *columns);
  if (!pose) {
    w->job->status = km_fail(w->job->error, KM_MEMORY, "out of memory for a sweep");
    return;
  }
  km_driver_motion_expect_stiff(w->at.drive);
  km_driver_motion_tangent(w->at.drive, r->rates);
  km_state_save(r->s, &r->m->substructures[r->substructure], pose);
  km_loops_restore_cached(r->m, r->s, r->substructure, r->branch_point);
  write_row(w, (km_motion_end){KM_STOP_NONE, r->plan->from, -1, -1});
  km_loops_restore_cached(r->m, r->s, r->substructure, pose);
  km_free(pose);
}

/* Shows the walks `going` what their observers want to see near the row, side by side as long as they ride. */
static void show_beside(km_driver_sweep *walks, unsigned going, km_batch *lanes) {
  double places[KM_BATCH_LANES], *rates[KM_BATCH_LANES];
  while (going) {
    unsigned wanting = going;
    for (unsigned rest = wanting; rest; rest &= rest - 1) {
      int i = __builtin_ctz(rest);
      const km_observer *observer = walks[i].r->observer;
      rates[i] = walks[i].r->rates;
      if (walks[i].job->status || !observer->wants || !observer->wants(observer->self, &places[i]))
        wanting &= ~(1u << i);
    }
    going = wanting ? km_batch_sample(lanes, wanting, places, rates) : 0;
    for (unsigned rest = going; rest; rest &= rest - 1) {
      const km_driver_sweep *w = &walks[__builtin_ctz(rest)];
      w->job->status = w->r->observer->shown(w->r->observer->self, w->r, w->r->rates, w->job->error);
    }
  }
}

/* What is left to be seen near the row is looked at by each drive alone. */
static void show_near_rows(km_driver_sweep *walks, unsigned going, km_batch *lanes) {
  if (lanes)
    show_beside(walks, going, lanes);
  for (unsigned rest = going; rest; rest &= rest - 1) {
    const km_driver_sweep *w = &walks[__builtin_ctz(rest)];
    if (!w->job->status)
      w->job->status = km_sweeper_near_row(w->r, w->job->error);
  }
}

/* Behind the row. */
static void leave_row(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  const km_motion_end *reach = &r->out->end;
  km_status status = w->job->status;
  r->rides = false;
  if (!status && w->step > 0 && km_driver_motion_crossings(w->at.drive) > w->crossings && r->substructure >= 0)
    status = km_sweeper_find_branch(r, w->job->error);
  w->last = reach->position;
  w->over = w->step > 0 && reach->stop;
  w->step++;
  w->job->status = status;
}

/* Behind the last row: where the driver itself gives out. */
static km_status finish(const km_driver_sweep *w) {
  km_sweeper *r = w->r;
  const km_motion_end *start = &r->out->start, *end = &r->out->end;
  km_status status = KM_OK;
  for (int i = 0; i < 2 && !status; ++i) {
    const km_motion_end *reach = i ? end : start;
    bool again = i && end->position == start->position;
    if (reach->stop == KM_STOP_TOGGLE && !again && r->observer->ended)
      status = r->observer->ended(r->observer->self, r, reach->position, w->job->error);
  }
  if (status)
    return status;
  return start->stop || end->stop ? KM_PARTIAL : KM_OK;
}

static bool rates(void *self, double *out) {
  return km_driver_motion_tangent(((const km_seat *)self)->drive, out);
}

static bool probe(void *self, double s, double *out) {
  km_seat *at = self;
  if (!at->away)
    km_driver_motion_save(at->drive);
  if (!km_driver_motion_restore_previous(at->drive, s) && at->away)
    km_driver_motion_restore(at->drive);
  at->away = true;
  return !km_driver_motion_move_to(at->drive, s).stop && km_driver_motion_tangent(at->drive, out);
}

static void settle(void *self) {
  km_seat *at = self;
  if (at->away)
    km_driver_motion_restore(at->drive);
  at->away = false;
}

static bool pass(void *self) {
  return km_driver_motion_save_passed(((const km_seat *)self)->drive);
}

static void direction(void *self, double *z) {
  km_driver_motion_batched_direction(((const km_seat *)self)->drive, z);
}

static km_status begin_walk(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  km_error *error = w->job->error;
  r->substructure = r->out->substructure = r->m->substructure_of[r->plan->coordinate];
  km_status status = km_sweeper_leave_branch(r, error);
  if (!status)
    status = km_sweep_enter_limits(r->m, r->s, r->plan, error);
  if (!status)
    status = km_driver_motion_create_in(&w->job->room->drive, r->m, r->s, r->plan->coordinate, r->plan->ignore_limits,
                                        &w->at.drive, error);
  if (status)
    return status;
  km_driver_motion_set_observer(w->at.drive, km_sweeper_step_watch(r));
  r->mover = (km_mover){&w->at, rates, probe, settle, pass, direction};
  return km_sweeper_prepare(r, error);
}

/* Moves each of the walks that goes on to its next row, or over several. False where none does. */
static bool advance(km_driver_sweep *walks, int count, km_batch *lanes) {
  double targets[KM_BATCH_LANES] = {0.0};
  km_motion_end reaches[KM_BATCH_LANES];
  unsigned going = 0;
  unsigned setting_out = 0;
  for (int i = 0; i < count; ++i) {
    unsigned lane = next(&walks[i], &targets[i]) ? 1u << i : 0;
    going |= lane;
    setting_out |= walks[i].step == 0 && walks[i].r->branch_point ? lane : 0;
  }
  for (unsigned rest = setting_out; rest; rest &= rest - 1) {
    km_driver_sweep *w = &walks[__builtin_ctz(rest)];
    write_branch_point(w);
    leave_row(w);
  }
  going &= ~setting_out;
  km_driver_sweeps_advance(walks, going, lanes, targets, reaches);
  for (int i = 0; i < count; ++i)
    if (going >> i & 1)
      write_row(&walks[i], reaches[i]);
  show_near_rows(walks, going, lanes);
  for (int i = 0; i < count; ++i)
    if (going >> i & 1)
      leave_row(&walks[i]);
  return (going | setting_out) != 0;
}

/* Side by side, if there are several and lanes are for them. */
static km_status advance_all(km_driver_sweep *walks, int count) {
  km_driver_motion *drives[KM_BATCH_LANES];
  km_arena *memory = &walks[0].job->room->lanes;
  km_batch *lanes = NULL;
  for (int i = 0; i < count; ++i)
    drives[i] = walks[i].at.drive;
  km_status status = count > 1 ? km_batch_create(memory, drives, count, &lanes, NULL) : KM_OK;
  while (!status && advance(walks, count, lanes))
    continue;
  for (int i = 0; i < count; ++i)
    if (walks[i].job->table_only)
      km_driver_motion_leave_batch(walks[i].at.drive);
  km_batch_free(memory, lanes);
  return status;
}

void km_sweeps_by_driver(km_sweeper *sweepers, km_sweep_job *jobs, int count) {
  km_driver_sweep walks[KM_BATCH_LANES];
  int going = 0;
  for (int i = 0; i < count; ++i) {
    if (jobs[i].status || !km_plan_is_driven(jobs[i].plan))
      continue;
    walks[going] = (km_driver_sweep){.r = &sweepers[i], .job = &jobs[i]};
    jobs[i].status = begin_walk(&walks[going]);
    if (jobs[i].status)
      km_driver_motion_free_into(&jobs[i].room->drive, walks[going].at.drive);
    else
      ++going;
  }
  bool failed = going > 0 && advance_all(walks, going) == KM_MEMORY;
  for (int i = 0; i < going; ++i) {
    km_sweep_job *job = walks[i].job;
    if (failed)
      job->status = km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
    else if (!job->status)
      job->status = finish(&walks[i]);
    km_driver_motion_free_into(&job->room->drive, walks[i].at.drive);
  }
}
