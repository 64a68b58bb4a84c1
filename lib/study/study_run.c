/* Runs a study's designs in order, batch by batch, with or without worker processes, and stops a sample when its
 * mean meets the stated accuracy (docs/theory.md 13.3). */
#include "base/arguments.h"
#include "base/clock.h"
#include "base/statistics/running_moments.h"
#include "base/statistics/student_t.h"
#include "study/design_evaluation.h"
#include "study/optimisation/optimisation.h"
#include "study/worker_processes.h"

#include <math.h>

enum { MIN_CAPACITY = 768, MAX_CAPACITY = 4096, MAX_JOBS = 1024, FIRST_CHECK = 64 };

/* Target duration of a batch (km_batch_next_size): it bounds the loss of a killed run and the delay of a
 * cancellation. */
static const double batch_seconds = 0.1;

typedef struct run {
  km_design_study *study;
  km_evaluation batch;
  int total, next, size; /* designs: total, first of the next batch, size of the next batch */
  int figure;            /* figure whose accuracy stops the run; −1: none */
  km_moments moments;
  bool compute;
  km_worker_processes *processes; /* worker processes; NULL: none */
  km_progress progress;
  void *context;
  double committed; /* time of the last commit */
} run;

/* Next count at which the accuracy is tested; the counts don't depend on batches or threads. */
static int next_check(int check) {
  int step = FIRST_CHECK;
  while (16 * step <= check)
    step *= 2;
  return check + step;
}

static bool is_accurate(const run *r) {
  double n = r->moments.count;
  return n > 1.0 &&
         km_student(n - 1.0) * (km_moments_deviation(&r->moments) / sqrt(n)) <= r->study->def->sample->accuracy;
}

/* Adds the figures of designs to the running moments. */
static km_status add_figures(run *r, int begin, int end, km_error *error) {
  km_status status = KM_OK;
  for (int i = begin; i < end && !status; ++i) {
    km_design_result result;
    status = km_design_study_result(r->study, i, &result, error);
    if (!status && isfinite(result.figures[r->figure]))
      km_moments_add(&r->moments, result.figures[r->figure]);
  }
  return status;
}

/* Runs one batch up to `end`; advances r->next. */
static km_status run_batch(run *r, int end, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_status status = KM_OK;
  end = r->next + r->size < end ? r->next + r->size : end;
  km_evaluation_clear(&r->batch);
  for (int i = r->next; i < end && !status; ++i) {
    km_design_values(r->study, i, values);
    status = km_evaluation_add(&r->batch, values, error);
  }
  if (!status && r->compute)
    status = km_batch_run(&r->batch, error);
  r->next = end;
  return status;
}

/* Commits the store from time to time and calls the progress callback. */
static km_status commit_and_report(run *r, km_error *error) {
  km_status status = KM_OK;
  if (km_clock() - r->committed > batch_seconds) {
    status = km_store_commit(r->study->store, error);
    r->committed = km_clock();
  }
  if (!status && r->progress && !r->progress(r->context, (double)r->next / r->total))
    status =
        km_fail(error, KM_CANCELLED, "stopped after %d of %d designs; what was answered is stored", r->next, r->total);
  return status;
}

/* Runs the designs from r->next up to `end`. */
static km_status run_part(run *r, int end, km_error *error) {
  km_status status = KM_OK;
  while (!status && r->next < end) {
    double begin = km_clock();
    if (r->processes)
      status = km_worker_processes_send(r->processes, &r->next, end, error);
    if (!status && r->next < end)
      status = run_batch(r, end, error);
    if (!status && r->processes)
      status = km_worker_processes_receive(r->processes, false, error);
    r->size = km_batch_next_size(r->size, km_clock() - begin, batch_seconds, r->batch.jobs, r->batch.capacity);
    if (!status)
      status = commit_and_report(r, error);
  }
  km_status taken = r->processes ? km_worker_processes_receive(r->processes, true, status ? NULL : error) : KM_OK;
  return status ? status : taken;
}

/* Runs all designs, part by part; after each part the accuracy of the mean is tested. */
static km_status run_parts(run *r, km_error *error) {
  km_status status = KM_OK;
  int end = r->figure >= 0 && FIRST_CHECK < r->total ? FIRST_CHECK : r->total;
  r->committed = km_clock();
  for (int begin = 0; !status && begin < r->total; begin = r->next) {
    status = run_part(r, end, error);
    if (!status && r->figure >= 0)
      status = add_figures(r, begin, end, error);
    if (!status && r->figure >= 0 && end < r->total && is_accurate(r)) {
      r->study->stopped_at = end;
      break;
    }
    end = r->figure >= 0 && next_check(end) < r->total ? next_check(end) : r->total;
  }
  km_status stored = km_store_sort(r->study->store, status ? NULL : error);
  return status ? status : stored;
}

/* Opens the batch evaluation and runs the designs of the study. */
static km_status run_designs(run *r, int jobs, km_error *error) {
  km_design_study *s = r->study;
  r->total = km_designs_planned(s);
  r->figure = -1;
  if (s->def->sample && s->def->sample->accuracy_figure)
    r->figure = km_design_find_figure(s->def, s->def->sample->accuracy_figure);
  s->stopped_at = 0;
  int capacity =
      jobs * MIN_CAPACITY < MAX_CAPACITY ? jobs * MIN_CAPACITY : MAX_CAPACITY; /* at least one design per thread */
  km_status status = km_evaluation_open(&r->batch, s, r->compute ? jobs : 0, capacity, error);
  r->size = r->compute ? jobs : capacity;
  if (!status)
    status = km_store_is_empty(s->store, &r->batch.is_new, error);
  if (r->compute && r->figure < 0) /* otherwise the figures are looked up during the run */
    km_store_append(s->store);
  if (!status)
    status = run_parts(r, error);
  km_evaluation_close(&r->batch);
  return status;
}

static km_status start(km_design_study *s, km_error *error) {
  km_status status = km_check_given(s != NULL, "study", error);
  if (status)
    return status;
  s->computed = s->found = 0;
  s->ended_early = false;
  km_design_free_statistics(s);
  return KM_OK;
}

static km_status check_jobs(int jobs, km_error *error) {
  return jobs >= 1 && jobs <= MAX_JOBS ? KM_OK
                                       : km_fail(error, KM_USAGE, "found %d threads; expected 1 to %d", jobs, MAX_JOBS);
}

km_status km_design_study_run(km_design_study *s, int jobs, km_progress progress, void *context, km_error *error) {
  km_status status = start(s, error);
  if (!status)
    status = check_jobs(jobs, error);
  if (status)
    return status;
  if (s->def->optimise)
    return km_optimise_run(s, jobs, true, progress, context, error);
  run r = {.study = s, .compute = true, .progress = progress, .context = context};
  return run_designs(&r, jobs, error);
}

km_status km_design_study_run_leader(km_design_study *s, int jobs, const km_design_workers *members,
                                     km_progress progress, void *context, km_error *error) {
  km_status status = km_worker_processes_check(members, error);
  if (!status && s && s->def->optimise)
    return km_design_study_run(s, jobs, progress, context, error);
  if (!status)
    status = start(s, error);
  if (!status)
    status = check_jobs(jobs, error);
  if (status)
    return status;
  run r = {.study = s, .compute = true, .progress = progress, .context = context};
  status = km_worker_processes_open(s, members, &r.processes, error);
  if (!status)
    status = run_designs(&r, jobs, error);
  km_worker_processes_close(r.processes);
  return status;
}

km_status km_design_study_lookup(km_design_study *s, km_error *error) {
  km_status status = start(s, error);
  if (status)
    return status;
  if (s->def->optimise)
    return km_optimise_run(s, 1, false, NULL, NULL, error);
  run r = {.study = s};
  return s->def->sample && s->def->sample->accuracy_figure ? run_designs(&r, 1, error) : KM_OK;
}

int km_design_study_computed(const km_design_study *s) {
  return s ? s->computed : 0;
}

int km_design_study_found(const km_design_study *s) {
  return s ? s->found : 0;
}

km_status km_design_study_result(const km_design_study *s, int design, km_design_result *out, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_status status = km_check_given(out != NULL, "place for the result", error);
  if (!status)
    status = km_design_study_values(s, design, values, error);
  if (status)
    return status;
  double figures[KM_MAX_DESIGN_FIGURES];
  km_design_answer answers[KM_MAX_DESIGN_QUESTIONS]; /* answers without bands */
  for (int q = 0; q < s->def->question_count && !status; ++q) {
    bool found;
    answers[q] = (km_design_answer){.outcome = KM_DESIGN_MISSING, .figures = figures + s->first_figure[q]};
    status = km_design_look_up(s, q, values, &answers[q], &found, error);
  }
  if (!status)
    km_design_collect(s, answers, out);
  return status;
}
