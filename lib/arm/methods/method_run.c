/* Common part of all methods: advance sample by sample, locate and classify the end of a track, evaluate the
 * objective. */
#include "arm/ik/ik_branches.h"
#include "arm/methods/method.h"

#include <string.h>

bool km_run_create(const km_arm *a, const km_track_plan *plan, km_tracking_run *run) {
  size_t n = (size_t)a->n;
  *run = (km_tracking_run){
      .arm = a, .plan = plan, .tracker = {a, plan->path, &plan->objective}, .column = -1, .converged = (double)NAN};
  run->start = KM_ARENA_NEW(&run->arena, double, n);
  run->last = KM_ARENA_NEW(&run->arena, double, n);
  run->q = KM_ARENA_NEW(&run->arena, double, n *(size_t)plan->path->samples);
  if (km_path_node_create(a, &run->arena, &run->node) && km_path_node_create(a, &run->arena, &run->next) &&
      km_tracker_space_create(a, &run->space)) {
    for (int k = 0; k < a->n; ++k)
      run->start[k] = km_arm_from_units(a, k, plan->start[k]);
    return true;
  }
  km_run_free(run);
  return false;
}

void km_run_free(km_tracking_run *run) {
  km_team_free(run->team);
  km_tracker_space_free(&run->space);
  km_arena_free(&run->arena);
}

km_team *km_run_team(km_tracking_run *run) {
  if (!run->team && run->plan->jobs > 1)
    run->team = km_team_create(run->plan->jobs);
  return run->team;
}

void km_run_copy_track(km_tracking_run *run, const km_tracking_run *other) {
  size_t n = (size_t)run->arm->n;
  memcpy(run->q, other->q, (size_t)other->reached * n * sizeof *run->q);
  memcpy(run->last, other->last, n * sizeof *run->last);
  run->reached = other->reached;
  run->fraction = other->fraction;
  run->stop = other->stop;
  run->column = other->column;
}

bool km_run_report_progress(const km_tracking_run *run, int sample) {
  return !run->plan->progress ||
         run->plan->progress(run->plan->context, (double)sample / (run->plan->path->samples - 1));
}

/* True if no configuration of the arm reaches the path just after the end of the track. A later sample can be
 * reachable again. */
static bool is_workspace_boundary(km_tracking_run *run) {
  static const double next_count = 1e-3; /* relative to the interval; far above the error of the located end */
  km_path_point just =
      km_path_at(run->plan->path, run->reached - 1, fmin(run->fraction + next_count, 0.5 * (1.0 + run->fraction)));
  double q[KM_ARM_MAX_JOINTS];
  return !km_arm_search(run->arm, &run->space.arm, &just.pose, 300, run->plan->seed, q);
}

/* True if the arm with all its joints is regular at q, so that only the fixed joints end the track. */
static bool is_regular(km_tracking_run *run, const double *q) {
  static const double far = 1e-3; /* the end at a singular configuration is located to about √1e-10 */
  double sigma[KM_ARM_ROWS];
  km_arm_update(run->arm, &run->space.arm, q);
  km_arm_singular_values(run->arm, &run->space.arm, sigma);
  return sigma[run->arm->rows - 1] > far;
}

/* True if the joint is at its limit. Near singular configurations joint rates are unbounded, so rounding of the path
 * can move a joint beyond its limit from well within it; then the singularity is the stop. */
static bool at_limit(const km_arm *a, const double *q, int column) {
  static const double is_near = 1e-9;
  return fmin(fabs(q[column] - a->low[column]), fabs(a->high[column] - q[column])) <= is_near * (1.0 + fabs(q[column]));
}

/* Locates the end by bisection and distinguishes limit, rate, singular configuration, workspace boundary and fixed
 * joints. */
void km_run_stop(km_tracking_run *run, const km_path_node *node, const km_step_choice *choice, km_step_end end) {
  km_path_node at = {.q = run->last};
  km_arena arena = {0};
  int sample = run->reached - 1;
  run->stop = end.stop;
  run->column = end.column;
  run->fraction = 0.0;
  if (end.stop == KM_TRACK_COMPLETE)
    return;
  if (!km_path_node_create(run->arm, &arena, &at))
    return;
  km_path_node_copy(run->arm, &at, node);
  if (end.stop != KM_TRACK_RATE) { /* a limit or a rate can end the track before the singular configuration */
    end = km_tracker_find_end(&run->tracker, &run->space, sample, node, choice, end, 1.0, &at);
    run->fraction = end.fraction;
  }
  if (run->fraction < 1e-9) { /* rates of a shorter step are rounding */
    run->fraction = 0.0;
    km_path_node_copy(run->arm, &at, node);
  }
  if (end.stop == KM_TRACK_LIMIT && !at_limit(run->arm, at.q, end.column))
    end = (km_step_end){.stop = KM_TRACK_SINGULAR, .column = -1, .fraction = end.fraction};
  run->stop = end.stop;
  run->column = end.column;
  memcpy(run->last, at.q, (size_t)run->arm->n * sizeof *at.q);
  if (end.stop == KM_TRACK_SINGULAR && is_workspace_boundary(run))
    run->stop = KM_TRACK_WORKSPACE_BOUNDARY;
  else if (end.stop == KM_TRACK_SINGULAR && choice->fixed && is_regular(run, run->last))
    run->stop = KM_TRACK_FIXED_JOINTS;
  km_arena_free(&arena);
}

static void append_sample(km_tracking_run *run, const km_path_node *node) {
  memcpy(run->q + (size_t)run->reached * (size_t)run->arm->n, node->q, (size_t)run->arm->n * sizeof *node->q);
  run->reached++;
}

/* Advances from the last sample to the next one. */
static km_step_end advance(km_tracking_run *run, const km_step_choice *first, km_run_choose choose, void *context,
                           km_step_choice *choice) {
  *choice = *first;
  if (choose)
    choose(context, run, run->reached - 1, &run->node, choice);
  km_step_end end = km_tracker_step(&run->tracker, &run->space, run->reached - 1, 1.0, &run->node, choice, &run->next);
  if (!end.stop) {
    km_path_node_copy(run->arm, &run->node, &run->next);
    append_sample(run, &run->node);
  }
  return end;
}

static void begin(km_tracking_run *run, const km_step_choice *first) {
  km_tracker_compute_node(&run->tracker, &run->space, 0, run->start, first, &run->node);
  run->reached = 0;
  run->fraction = 0.0;
  run->stop = KM_TRACK_COMPLETE;
  run->column = -1;
  append_sample(run, &run->node);
}

km_status km_run_try(km_tracking_run *run, const km_step_choice *first, km_run_choose choose, void *context) {
  km_step_choice choice;
  for (begin(run, first); run->reached < run->plan->path->samples;)
    if (advance(run, first, choose, context, &choice).stop)
      return KM_PARTIAL;
  return KM_OK;
}

km_status km_run_steps(km_tracking_run *run, const km_step_choice *first, km_run_choose choose, void *context,
                       km_error *error) {
  km_step_choice choice;
  for (begin(run, first); run->reached < run->plan->path->samples;) {
    km_step_end end = advance(run, first, choose, context, &choice);
    if (end.stop) {
      km_run_stop(run, &run->node, &choice, end);
      return KM_PARTIAL;
    }
    if (!km_run_report_progress(run, run->reached))
      return km_fail(error, KM_CANCELLED, "cancelled");
  }
  return KM_OK;
}

/* Difference that the rate margin of the track's own rates makes to the objective of run->next, which contains the
 * margin of the minimum-norm rates. */
static double rate_margin_correction(km_tracking_run *run, int sample) {
  static const km_objective only = {.weight[KM_RATE_MARGIN] = 1.0};
  const km_arm *a = run->arm;
  const km_path_point *points = run->plan->path->points;
  double weight = run->plan->objective.weight[KM_RATE_MARGIN], values[KM_OBJECTIVES], mean[KM_ARM_MAX_JOINTS],
         rates[KM_ARM_MAX_JOINTS];
  if (weight == 0.0 || run->reached < 2)
    return 0.0;
  int first = sample > 0 ? sample - 1 : 0;
  const double *q = run->q + (size_t)first * (size_t)a->n;
  for (int k = 0; k < a->n; ++k)
    mean[k] = (q[a->n + k] - q[k]) / (points[first + 1].t - points[first].t);
  km_path_node_rates(a, run->next.path, run->next.self, points[sample].speed, mean, rates);
  km_objective_values(a, &run->space.arm, run->next.q, run->next.path, points[sample].speed, &only, values);
  return weight * (km_objective_rate_margin(a, rates) - values[KM_RATE_MARGIN]);
}

/* Evaluates the objective at every sample of the track. */
km_run_value km_run_evaluate(km_tracking_run *run) {
  km_run_value value = {(double)INFINITY, 0.0, run->reached};
  for (int i = 0; i < run->reached; ++i) {
    km_tracker_compute_arrival(&run->tracker, &run->space, i, run->q + (size_t)i * (size_t)run->arm->n,
                               i > 0 ? &run->node : NULL, &run->next);
    double here = run->next.value + rate_margin_correction(run, i);
    value.least = fmin(value.least, here);
    value.sum += run->next.weight * here;
    km_path_node_copy(run->arm, &run->node, &run->next);
  }
  return value;
}

double km_run_score(const km_tracking_run *run, km_run_value value) {
  if (value.samples == 0)
    return -(double)INFINITY;
  return km_objective_by_mean(&run->plan->objective) ? value.sum / value.samples : value.least;
}
