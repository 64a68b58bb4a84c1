/* Driven sweeps: rows, probes near rows, branch points and ends (theory 10). */
#include "sweep/driver_sweep.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/rank_evidence.h"
#include "sweep/stop_cause.h"

#include <math.h>
#include <string.h>

/* True if s lies in the part of the range that can be reached; the motion towards FROM ended before it. */
static bool reachable(const km_sweeper *r, double s) {
  const km_sweep_plan *plan = r->plan;
  double bound = r->out->start.position, sense = plan->to >= plan->from ? 1.0 : -1.0;
  return sense * (bound - plan->from) > 0.0 && sense * (s - bound) > 1e-9 * (1.0 + fabs(bound));
}

/* Computes the driver's next target; false if the sweep is finished or cancelled. */
static bool next_target(km_driver_sweep *w, double *target) {
  km_sweeper *r = w->r;
  const km_sweep_plan *plan = r->plan;
  if (w->job->status || w->is_finished)
    return false;
  *target = plan->from;
  if (w->step == 0)
    return true;
  for (; w->step <= plan->steps; ++w->step) {
    double s = km_driver_sweep_value(plan, w->step);
    if (r->out->start.stop && !reachable(r, s))
      continue;
    if (!km_sweeper_continues(r, w->step)) {
      w->job->status = km_fail(w->job->error, KM_CANCELLED, "stopped at %g", s);
      return false;
    }
    w->crossings = km_driver_motion_crossings(w->at.motion);
    *target = s;
    return true;
  }
  return false;
}

/* Returns the singular value near the rank tolerance of rounded data; 0: the rank is not doubtful. A doubtful end is no
 * dead point. */
static double rank_value(const km_mechanism *m, km_state *s, int substructure) {
  km_rank_evidence e;
  if (!m->closure_tolerance_given)
    return 0.0;
  km_update_and_search_pivots(m, s, substructure, KM_NO_DRIVER, 0.0);
  km_poses_compute(m, s);
  if (km_rank_evidence_find(m, s, substructure, &e, NULL) || !e.doubtful)
    return 0.0;
  return e.dropped > m->closure_tolerance ? e.dropped : e.kept;
}

/* Records the cause of a dead point at the start or the end: a doubtful rank, else the loops and joints. */
static void note_cause(const km_driver_sweep *w, const km_motion_end *reach) {
  km_sweep *out = w->r->out;
  char **cause = &out->causes[w->step > 0];
  if (reach->stop != KM_STOP_TOGGLE || reach->substructure < 0 || out->freedom == 0 || *cause)
    return;
  out->rank_value[w->step > 0] = rank_value(w->r->m, w->r->s, reach->substructure);
  if (out->rank_value[w->step > 0] == 0.0)
    *cause = km_stop_cause(w->r->m, w->r->s, reach->substructure, w->r->plan->coordinate);
}

/* Writes the row at the reached configuration. Probes near it follow. */
static void write_row(km_driver_sweep *w, km_motion_end reach) {
  km_sweeper *r = w->r;
  km_status status = KM_OK;
  if (w->job->status) /* failed between the rows */
    return;
  km_driver_sweep_prepare(w);
  r->out->end = reach;
  if (w->step == 0)
    r->out->start = reach;
  bool repeats_last_row = w->step > 0 && reach.stop && fabs(reach.position - w->last) <= 1e-9 * (1.0 + fabs(w->last));
  if (reach.stop == KM_STOP_MAX_STEPS)
    status =
        km_fail(w->job->error, KM_DIVERGED,
                "the sweep stopped at %.9g: too many steps to the next row; expected a range that so many rows resolve",
                reach.position);
  else if (!repeats_last_row) /* an end at the last row is not written twice */
    status = km_sweeper_row(r, w->row++, reach.position, w->job->error);
  if (!status)
    note_cause(w, &reach);
  w->job->status = status;
}

/* Writes the first row at the branch point that the motion has left already, with the tangent found after it. */
static void write_branch_point(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  size_t columns = (size_t)r->m->substructures[r->substructure].columns;
  double *saved = KM_NEW(double, KM_SAVED_PER_COLUMN *columns);
  if (!saved) {
    w->job->status = km_fail(w->job->error, KM_MEMORY, "out of memory for a sweep");
    return;
  }
  km_driver_motion_expect_stiff(w->at.motion);
  km_driver_motion_tangent(w->at.motion, r->rates);
  km_state_save(r->s, &r->m->substructures[r->substructure], saved);
  km_loops_restore_cached(r->m, r->s, r->substructure, r->branch_first_row);
  write_row(w, (km_motion_end){KM_STOP_NONE, r->plan->from, -1, -1});
  km_loops_restore_cached(r->m, r->s, r->substructure, saved);
  km_free(saved);
}

/* Runs the probes of the sweeps `active` in the batch, as long as it can. */
static void probe_batched(km_driver_sweep *sweeps, unsigned active, km_batch *lanes) {
  double probes[KM_BATCH_LANES], *read_rates[KM_BATCH_LANES];
  while (active) {
    unsigned probing = active;
    for (unsigned bits = probing; bits; bits &= bits - 1) {
      int i = __builtin_ctz(bits);
      const km_observer *observer = sweeps[i].r->observer;
      read_rates[i] = sweeps[i].r->rates;
      if (sweeps[i].job->status || !observer->next_probe || !observer->next_probe(observer->self, &probes[i]))
        probing &= ~(1u << i);
    }
    active = probing ? km_batch_sample(lanes, probing, probes, read_rates) : 0;
    for (unsigned bits = active; bits; bits &= bits - 1) {
      const km_driver_sweep *w = &sweeps[__builtin_ctz(bits)];
      w->job->status = w->r->observer->probed(w->r->observer->self, w->r, w->r->rates, w->job->error);
    }
  }
}

/* Runs the probes near the rows: in the batch, the remaining ones singly. */
static void probe_near_rows(km_driver_sweep *sweeps, unsigned active, km_batch *lanes) {
  if (lanes)
    probe_batched(sweeps, active, lanes);
  for (unsigned bits = active; bits; bits &= bits - 1) {
    const km_driver_sweep *w = &sweeps[__builtin_ctz(bits)];
    if (!w->job->status)
      w->job->status = km_sweeper_near_row(w->r, w->job->error);
  }
}

/* Completes a row: branch points before it, and the next step. */
static void complete_row(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  const km_motion_end *reach = &r->out->end;
  km_status status = w->job->status;
  r->is_batched = false;
  if (!status && w->step > 0 && km_driver_motion_crossings(w->at.motion) > w->crossings && r->substructure >= 0)
    status = km_sweeper_find_branch(r, w->job->error);
  w->last = reach->position;
  w->is_finished = w->step > 0 && reach->stop;
  w->step++;
  w->job->status = status;
}

/* Completes a sweep: reports turning points of the driver at both ends to the observer. */
static km_status complete_sweep(const km_driver_sweep *w) {
  km_sweeper *r = w->r;
  const km_motion_end *start = &r->out->start, *end = &r->out->end;
  km_status status = KM_OK;
  for (int i = 0; i < 2 && !status; ++i) {
    const km_motion_end *reach = i ? end : start;
    bool repeats_last_row = i && end->position == start->position;
    if (reach->stop == KM_STOP_TOGGLE && !repeats_last_row && r->observer->end_reached)
      status = r->observer->end_reached(r->observer->self, r, reach->position, w->job->error);
  }
  if (status)
    return status;
  return start->stop || end->stop ? KM_PARTIAL : KM_OK;
}

static bool read_rates(void *self, double *out) {
  return km_driver_motion_tangent(((const km_probing_driver *)self)->motion, out);
}

static bool probe(void *self, double s, double *out) {
  km_probing_driver *at = self;
  if (!at->is_probing)
    km_driver_motion_save(at->motion);
  if (!km_driver_motion_restore_previous(at->motion, s) && at->is_probing)
    km_driver_motion_restore(at->motion);
  at->is_probing = true;
  return !km_driver_motion_move_to(at->motion, s).stop && km_driver_motion_tangent(at->motion, out);
}

static void restore(void *self) {
  km_probing_driver *at = self;
  if (at->is_probing)
    km_driver_motion_restore(at->motion);
  at->is_probing = false;
}

static bool save_passed(void *self) {
  return km_driver_motion_save_passed(((const km_probing_driver *)self)->motion);
}

static void read_direction(void *self, double *z) {
  km_driver_motion_batched_direction(((const km_probing_driver *)self)->motion, z);
}

static km_status begin_sweep(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  km_error *error = w->job->error;
  r->substructure = r->out->substructure = r->m->substructure_of[r->plan->coordinate];
  km_status status = km_sweeper_leave_branch(r, error);
  if (!status)
    status = km_sweep_enter_limits(r->m, r->s, r->plan, error);
  if (!status)
    status = km_driver_motion_create_in(&w->job->workspace->motion, r->m, r->s, r->plan->coordinate,
                                        r->plan->ignore_limits, &w->at.motion, error);
  if (status)
    return status;
  km_driver_motion_set_observer(w->at.motion, km_sweeper_step_observer(r));
  r->mover = (km_mover){&w->at, read_rates, probe, restore, save_passed, read_direction};
  return km_sweeper_prepare(r, error);
}

/* Moves each active sweep to its next row, or over several; false if none is active. */
static bool advance(km_driver_sweep *sweeps, int count, km_batch *lanes) {
  double targets[KM_BATCH_LANES] = {0.0};
  km_motion_end reaches[KM_BATCH_LANES];
  unsigned active = 0;
  unsigned at_branch_point = 0;
  for (int i = 0; i < count; ++i) {
    unsigned lane = next_target(&sweeps[i], &targets[i]) ? 1u << i : 0;
    active |= lane;
    at_branch_point |= sweeps[i].step == 0 && sweeps[i].r->branch_first_row ? lane : 0;
  }
  for (unsigned bits = at_branch_point; bits; bits &= bits - 1) {
    km_driver_sweep *w = &sweeps[__builtin_ctz(bits)];
    write_branch_point(w);
    complete_row(w);
  }
  active &= ~at_branch_point;
  km_driver_sweeps_advance(sweeps, active, lanes, targets, reaches);
  for (int i = 0; i < count; ++i)
    if (active >> i & 1)
      write_row(&sweeps[i], reaches[i]);
  probe_near_rows(sweeps, active, lanes);
  for (int i = 0; i < count; ++i)
    if (active >> i & 1)
      complete_row(&sweeps[i]);
  return (active | at_branch_point) != 0;
}

/* Runs all sweeps, in a batch if there are several and it covers them. */
static km_status advance_all(km_driver_sweep *sweeps, int count) {
  km_driver_motion *drives[KM_BATCH_LANES];
  km_arena *memory = &sweeps[0].job->workspace->lanes;
  km_batch *lanes = NULL;
  for (int i = 0; i < count; ++i)
    drives[i] = sweeps[i].at.motion;
  km_status status = count > 1 ? km_batch_create(memory, drives, count, &lanes, NULL) : KM_OK;
  while (!status && advance(sweeps, count, lanes))
    continue;
  for (int i = 0; i < count; ++i)
    if (sweeps[i].job->table_only)
      km_driver_motion_leave_batch(sweeps[i].at.motion);
  km_batch_free(memory, lanes);
  return status;
}

void km_sweeps_by_driver(km_sweeper *sweepers, km_sweep_job *jobs, int count) {
  km_driver_sweep sweeps[KM_BATCH_LANES];
  int active = 0;
  for (int i = 0; i < count; ++i) {
    if (jobs[i].status || !km_plan_is_driven(jobs[i].plan))
      continue;
    sweeps[active] = (km_driver_sweep){.r = &sweepers[i], .job = &jobs[i]};
    jobs[i].status = begin_sweep(&sweeps[active]);
    if (jobs[i].status)
      km_driver_motion_free_into(&jobs[i].workspace->motion, sweeps[active].at.motion);
    else
      ++active;
  }
  bool failed = active > 0 && advance_all(sweeps, active) == KM_MEMORY;
  for (int i = 0; i < active; ++i) {
    km_sweep_job *job = sweeps[i].job;
    if (failed)
      job->status = km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
    else if (!job->status)
      job->status = complete_sweep(&sweeps[i]);
    km_driver_motion_free_into(&job->workspace->motion, sweeps[i].at.motion);
  }
}
