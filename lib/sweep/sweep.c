/* Plans of sweeps, and their run: common part of driven sweeps and sweeps by arc length. */
#include "sweep/sweep.h"
#include "base/arguments.h"
#include "base/table.h"
#include "mobility/mobility_numbers.h"

#include <math.h>

km_sweep_plan km_sweep_plan_default(const km_model *model) {
  if (!model)
    return (km_sweep_plan){.coordinate = -1, .direction = -1};
  const km_model_sweep *sweep = &model->sweep;
  return (km_sweep_plan){.coordinate = sweep->coordinate,
                         .from = sweep->range[0],
                         .to = sweep->range[1],
                         .steps = sweep->steps,
                         .arclength = sweep->arclength,
                         .direction = sweep->direction,
                         .sign = sweep->sign};
}

static km_status check_range(const km_mechanism *m, const km_sweep_plan *plan, km_error *error) {
  if (plan->steps == 0)
    return KM_OK;
  if (plan->arclength > 0.0)
    return plan->arclength > KM_MIN_ARCLENGTH && plan->arclength <= KM_MAX_ARCLENGTH
               ? KM_OK
               : km_fail(error, KM_USAGE, "steps of an arc length of %g; expected one greater than %g and at most %g",
                         plan->arclength, KM_MIN_ARCLENGTH, KM_MAX_ARCLENGTH);
  if (!isfinite(plan->from) || !isfinite(plan->to))
    return km_fail(error, KM_USAGE, "a range from %g to %g; expected finite values", plan->from, plan->to);
  return km_check_index(plan->coordinate, m->coordinate_count, "coordinate", error);
}

km_status km_check_sweep(const km_mechanism *m, const km_state *s, const km_sweep_plan *plan, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(plan != NULL, "plan", error);
  if (!status)
    status = check_range(m, plan, error);
  if (!status && (plan->steps < 0 || plan->steps > KM_MAX_SWEEP_STEPS))
    status = km_fail(error, KM_USAGE, "%d steps; expected 0 to %d", plan->steps, KM_MAX_SWEEP_STEPS);
  if (!status && plan->direction != -1)
    status = km_check_index(plan->direction, m->coordinate_count, "coordinate", error);
  if (!status)
    status = km_check_list(plan->points, plan->point_count, "points", error);
  for (int i = 0; !status && i < plan->point_count; ++i) {
    status = km_check_index(plan->points[i].frame, m->model->frame_count, "frame", error);
    if (!status)
      status = km_check_given(plan->points[i].name != NULL, "name of a point", error);
  }
  return status;
}

static bool no_rates(void *self, double *rates) {
  (void)self;
  (void)rates;
  return false;
}

static bool no_probe(void *self, double s, double *rates) {
  (void)s;
  return no_rates(self, rates);
}

static void no_restore(void *self) {
  (void)self;
}

km_status km_sweeper_single_row(km_sweeper *r, km_error *error) {
  r->mover = (km_mover){NULL, no_rates, no_probe, no_restore, NULL, NULL};
  km_status status = km_sweeper_prepare(r, error);
  return status ? status : km_sweeper_row(r, 0, 0.0, error);
}

static km_status open_sweeper(km_sweeper *r, const km_sweep_job *job) {
  *r = (km_sweeper){.m = job->m, .s = job->s, .plan = job->plan, .observer = job->observer, .out = job->out};
  r->substructure = -1;
  *r->out = (km_sweep){.substructure = -1};
  size_t count = (size_t)r->m->coordinate_count;
  r->out->table = km_table_restart(job->workspace->table);
  job->workspace->table = NULL;
  r->out->between = km_table_create();
  r->rates = KM_NEW(double, 2 * count);
  if (!r->out->table || !r->out->between || !r->rates)
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  r->scratch = r->rates + count;
  return km_sweeper_columns(r, job->error);
}

static void report_step(void *self, double s, const double *rates) {
  const km_sweeper *r = self;
  r->observer->step_taken(r->observer->self, r, s, rates);
}

km_step_observer km_sweeper_step_observer(km_sweeper *r) {
  return (km_step_observer){r->observer->step_taken ? report_step : NULL, r, r->scratch};
}

bool km_sweeper_is_at_branch_point(km_sweeper *r) {
  if (r->substructure >= 0)
    km_motions_update(r->m, r->s, r->substructure);
  return km_sweeper_has_more_freedoms(r);
}

double km_sweeper_end_sample(double s, double end, int k) {
  return end + (s - end) * ldexp(1.0, -2 * k);
}

void km_sweep_workspace_free(km_sweep_workspace *workspace) {
  km_table_free(workspace->table);
  km_arena_free(&workspace->motion);
  km_arena_free(&workspace->lanes);
  workspace->table = NULL;
}

/* Prepares a sweep, and runs it completely unless it is driven. */
static km_status begin_sweep(km_sweeper *r, const km_sweep_job *job) {
  km_status status = open_sweeper(r, job);
  if (status || km_plan_is_driven(job->plan))
    return status;
  return job->plan->steps == 0 ? km_sweeper_single_row(r, job->error) : km_sweep_by_length(r, job->error);
}

static void end_sweep(km_sweeper *r, km_sweep_job *job) {
  if (job->s->arena.failed && job->status != KM_MEMORY) /* an array of the state could not grow */
    job->status = km_fail(job->error, KM_MEMORY, "out of memory for a pose of a sweep");
  km_free(r->rates);
  km_free(r->branch_first_row);
  if (job->status == KM_OK || job->status == KM_PARTIAL)
    job->status = job->observer->finish(job->observer->self, job);
}

void km_sweeps_run(km_sweep_job *jobs, int count) {
  km_sweeper sweepers[KM_BATCH_LANES];
  km_sweep_workspace workspaces[KM_BATCH_LANES];
  unsigned started = 0;
  for (int i = 0; i < count; ++i) {
    workspaces[i] = (km_sweep_workspace){0};
    if (jobs[i].status)
      continue;
    jobs[i].workspace = jobs[i].workspace ? jobs[i].workspace : &workspaces[i];
    jobs[i].status = begin_sweep(&sweepers[i], &jobs[i]);
    started |= 1u << i;
  }
  km_sweeps_by_driver(sweepers, jobs, count);
  for (int i = 0; i < count; ++i) {
    if (started >> i & 1)
      end_sweep(&sweepers[i], &jobs[i]);
    if (jobs[i].observer)
      jobs[i].observer->close(jobs[i].observer->self);
    km_sweep_workspace_free(&workspaces[i]);
  }
}

void km_sweep_free(km_sweep *sweep) {
  if (!sweep)
    return;
  km_table_free(sweep->table);
  km_table_free(sweep->between);
  km_free(sweep->branches);
  km_free(sweep->passive_coordinates);
  km_free(sweep->causes[0]);
  km_free(sweep->causes[1]);
  *sweep = (km_sweep){0};
}
