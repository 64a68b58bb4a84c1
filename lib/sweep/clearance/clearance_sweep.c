/* A sweep with clearances alone. */
#include "base/arguments.h"
#include "sweep/clearance/clearance_search.h"
#include "sweep/sweep_observer.h"

typedef struct sweep_clearances {
  km_observer observer;
  km_clearance_search search;
} sweep_clearances;

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  return km_clearance_search_columns(&((sweep_clearances *)self)->search, r, table);
}

static double *write_cells(void *self, km_sweeper *r, double *cell) {
  return km_clearance_search_cells(&((sweep_clearances *)self)->search, r, cell);
}

static km_status handle_sample(void *self, km_sweeper *r, double s, km_error *error) {
  return km_clearance_search_sample(&((sweep_clearances *)self)->search, r, s, error);
}

static void handle_branch_switch(void *self) {
  km_clearance_search_restart(&((sweep_clearances *)self)->search);
}

static km_status finish(void *self, const km_sweep_job *job) {
  km_status status = km_clearance_search_finish(&((sweep_clearances *)self)->search, job->plan, job->error);
  return status ? status : job->status;
}

static void close_observer(void *self) {
  sweep_clearances *w = self;
  km_clearance_search_free(&w->search);
  km_free(w);
}

void km_clearance_sweep_open(km_sweep_job *job, km_clearance_sweep *out) {
  *out = (km_clearance_sweep){.motion = {.substructure = -1}};
  job->out = &out->motion;
  job->status = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (!job->status)
    job->status = km_check_given(job->plan->clearance != NULL, "clearance in the plan", job->error);
  if (job->status)
    return;
  sweep_clearances *w = KM_NEW(sweep_clearances, 1);
  if (!w) {
    job->status = km_fail(job->error, KM_MEMORY, "out of memory for clearances");
    return;
  }
  w->observer = (km_observer){.self = w,
                              .columns = add_columns,
                              .cells = write_cells,
                              .row_written = handle_sample,
                              .sampled_between = handle_sample,
                              .corner = handle_branch_switch,
                              .finish = finish,
                              .close = close_observer,
                              .reads_jacobian = true};
  job->observer = &w->observer;
  job->status = km_clearance_search_create(job->plan, &out->course, job->table_only, &w->search, job->error);
}

km_status km_clearance_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_clearance_sweep *out,
                                 km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  km_sweep_job job = {.m = m, .s = s, .plan = plan, .error = error};
  km_clearance_sweep_open(&job, out);
  km_sweeps_run(&job, 1);
  return job.status;
}

void km_clearance_sweep_free(km_clearance_sweep *sweep) {
  if (!sweep)
    return;
  km_sweep_free(&sweep->motion);
  km_clearance_course_free(&sweep->course);
}
