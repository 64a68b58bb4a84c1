/* What all methods do alike: step, stop, count. */
#include "arm/ik/ik_branches.h"
#include "arm/methods/method.h"

#include <string.h>

bool km_run_create(const km_arm *a, const km_track_plan *plan, km_entry_range *run) {
  size_t n = (size_t)a->n;
  *run = (km_entry_range){
      .arm = a, .plan = plan, .walk = {a, plan->path, &plan->objective}, .column = -1, .converged = (double)NAN};
  run->start = KM_ARENA_NEW(&run->arena, double, n);
  run->last = KM_ARENA_NEW(&run->arena, double, n);
  run->q = KM_ARENA_NEW(&run->arena, double, n *(size_t)plan->path->samples);
  if (km_node_create(a, &run->arena, &run->node) && km_node_create(a, &run->arena, &run->next) &&
      km_tracker_space_create(a, &run->space)) {
    for (int k = 0; k < a->n; ++k)
      run->start[k] = km_arm_read(a, k, plan->start[k]);
    return true;
  }
  km_run_free(run);
  return false;
}

void km_run_free(km_entry_range *run) {
  km_team_free(run->team);
  km_tracker_space_free(&run->space);
  km_arena_free(&run->arena);
}

km_team *km_run_team(km_entry_range *run) {
  if (!run->team && run->plan->jobs > 1)
    run->team = km_team_create(run->plan->jobs);
  return run->team;
}

void km_run_take(km_entry_range *run, const km_entry_range *other) {
  size_t n = (size_t)run->arm->n;
  memcpy(run->q, other->q, (size_t)other->reached * n * sizeof *run->q);
  memcpy(run->last, other->last, n * sizeof *run->last);
  run->reached = other->reached;
  run->fraction = other->fraction;
  run->stop = other->stop;
  run->column = other->column;
}

bool km_run_goes_on(const km_entry_range *run, int sample) {
  return !run->plan->progress ||
         run->plan->progress(run->plan->context, (double)sample / (run->plan->path->samples - 1));
}

/* No pose at all reaches the path just after where the track ends? The next sample may lie where the path is back. */
static bool beyond_edge(km_entry_range *run) {
  static const double ahead = 1e-3; /* of the interval: far more than the end's own error */
  km_path_point just =
      km_path_at(run->plan->path, run->reached - 1, fmin(run->fraction + ahead, 0.5 * (1.0 + run->fraction)));
  double q[KM_ARM_MOST];
  return !km_arm_search(run->arm, &run->space.arm, &just.pose, 300, run->plan->seed, q);
}

/* The whole arm is far from singular at q: only what is held keeps it from going on. */
static bool regular(km_entry_range *run, const double *q) {
  static const double far = 1e-3; /* an end at a singular pose is located to the root of 1e-10 */
  double sigma[KM_ARM_ROWS];
  km_arm_update(run->arm, &run->space.arm, q);
  km_arm_singular_values(run->arm, &run->space.arm, sigma);
  return sigma[run->arm->rows - 1] > far;
}

/* Is the joint at its limit? Near singular poses joints move without bound: there the last digit of the path may lead
 * from well within a limit to beyond it, and it is the pose that stops the arm. */
static bool at_limit(const km_arm *a, const double *q, int column) {
  static const double near = 1e-9;
  return fmin(fabs(q[column] - a->low[column]), fabs(a->high[column] - q[column])) <= near * (1.0 + fabs(q[column]));
}

void km_run_stop(km_entry_range *run, const km_node *node, const km_step_choice *way, km_step_end end) {
  km_node at = {.q = run->last};
  km_arena arena = {0};
  int sample = run->reached - 1;
  run->stop = end.stop;
  run->column = end.column;
  run->fraction = 0.0;
  if (end.stop == KM_TRACK_COMPLETE)
    return;
  if (!km_node_create(run->arm, &arena, &at))
    return;
  km_node_copy(run->arm, &at, node);
  if (end.stop != KM_TRACK_RATE) { /* which a limit or a rate may end before a singular pose does */
    end = km_tracker_find_end(&run->walk, &run->space, sample, node, way, end, 1.0, &at);
    run->fraction = end.fraction;
  }
  if (run->fraction < 1e-9) { /* a step so short has no rates that stand out of rounding */
    run->fraction = 0.0;
    km_node_copy(run->arm, &at, node);
  }
  if (end.stop == KM_TRACK_LIMIT && !at_limit(run->arm, at.q, end.column))
    end = (km_step_end){.stop = KM_TRACK_SINGULAR, .column = -1, .fraction = end.fraction};
  run->stop = end.stop;
  run->column = end.column;
  memcpy(run->last, at.q, (size_t)run->arm->n * sizeof *at.q);
  if (end.stop == KM_TRACK_SINGULAR && beyond_edge(run))
    run->stop = KM_TRACK_EDGE;
  else if (end.stop == KM_TRACK_SINGULAR && way->held && regular(run, run->last))
    run->stop = KM_TRACK_HELD;
  km_arena_free(&arena);
}

static void keep(km_entry_range *run, const km_node *node) {
  memcpy(run->q + (size_t)run->reached * (size_t)run->arm->n, node->q, (size_t)run->arm->n * sizeof *node->q);
  run->reached++;
}

/* From the last sample to the next one. */
static km_step_end advance(km_entry_range *run, const km_step_choice *first, km_run_choose choose, void *context,
                           km_step_choice *way) {
  *way = *first;
  if (choose)
    choose(context, run, run->reached - 1, &run->node, way);
  km_step_end end = km_tracker_step(&run->walk, &run->space, run->reached - 1, 1.0, &run->node, way, &run->next);
  if (!end.stop) {
    km_node_copy(run->arm, &run->node, &run->next);
    keep(run, &run->node);
  }
  return end;
}

static void begin(km_entry_range *run, const km_step_choice *first) {
  km_tracker_begin(&run->walk, &run->space, 0, run->start, first, &run->node);
  run->reached = 0;
  run->fraction = 0.0;
  run->stop = KM_TRACK_COMPLETE;
  run->column = -1;
  keep(run, &run->node);
}

km_status km_run_try(km_entry_range *run, const km_step_choice *first, km_run_choose choose, void *context) {
  km_step_choice way;
  for (begin(run, first); run->reached < run->plan->path->samples;)
    if (advance(run, first, choose, context, &way).stop)
      return KM_PARTIAL;
  return KM_OK;
}

km_status km_run_steps(km_entry_range *run, const km_step_choice *first, km_run_choose choose, void *context,
                       km_error *error) {
  km_step_choice way;
  for (begin(run, first); run->reached < run->plan->path->samples;) {
    km_step_end end = advance(run, first, choose, context, &way);
    if (end.stop) {
      km_run_stop(run, &run->node, &way, end);
      return KM_PARTIAL;
    }
    if (!km_run_goes_on(run, run->reached))
      return km_fail(error, KM_CANCELLED, "cancelled");
  }
  return KM_OK;
}

/* What the rate margin of the track's own rates adds to the value of run->next, the node at a sample, where the margin
 * of the least rates counts. */
static double own_margin(km_entry_range *run, int sample) {
  static const km_objective only = {.weight[KM_RATE_MARGIN] = 1.0};
  const km_arm *a = run->arm;
  const km_path_point *points = run->plan->path->points;
  double weight = run->plan->objective.weight[KM_RATE_MARGIN], values[KM_OBJECTIVES], mean[KM_ARM_MOST],
         rates[KM_ARM_MOST];
  if (weight == 0.0 || run->reached < 2)
    return 0.0;
  int first = sample > 0 ? sample - 1 : 0;
  const double *q = run->q + (size_t)first * (size_t)a->n;
  for (int k = 0; k < a->n; ++k)
    mean[k] = (q[a->n + k] - q[k]) / (points[first + 1].t - points[first].t);
  km_node_rates(a, run->next.path, run->next.self, points[sample].speed, mean, rates);
  km_objective_values(a, &run->space.arm, run->next.q, run->next.path, points[sample].speed, &only, values);
  return weight * (km_objective_rate_margin(a, rates) - values[KM_RATE_MARGIN]);
}

km_run_value km_run_evaluate(km_entry_range *run) {
  km_run_value value = {(double)INFINITY, 0.0, run->reached};
  static const km_step_choice plain = {0};
  for (int i = 0; i < run->reached; ++i) {
    km_tracker_begin(&run->walk, &run->space, i, run->q + (size_t)i * (size_t)run->arm->n, &plain, &run->next);
    double here = run->next.value + own_margin(run, i);
    value.least = fmin(value.least, here);
    value.sum += here;
  }
  return value;
}

double km_run_score(const km_entry_range *run, km_run_value value) {
  if (value.samples == 0)
    return -(double)INFINITY;
  return km_objective_by_mean(&run->plan->objective) ? value.sum / value.samples : value.least;
}
