/* Dynamic programming over the self-motions: the reference for the other methods (docs/theory.md 12.7).
 *
 *   stage i -> i + 1: every state advances `length` samples with each tan_phi of a lattice, |tan_phi| <= tan(angle)
 *   arrivals closer than `spacing` form a neighbourhood; only the best of it becomes a state of the next stage
 *
 * Limits are checked at every sample. There is no global redundancy parameter: components of the self-motions merge
 * and split along the path. The run is repeated with half the spacing and half the stage length; a small change of
 * the value confirms the optimum to about that accuracy. */
#include "arm/methods/dynamic_programming.h"

#include "arm/methods/ball_lattice.h"

#include <stdlib.h>
#include <string.h>

/* Largest number of partial steps of a step. The number has no bound near singular configurations; such a step is
 * discarded. */
enum { MAX_PARTIAL_STEPS = 200 };
/* Largest number of Jacobians of a pass: per sample, plus a constant. Regular paths need far fewer. */
enum { WORK_PER_SAMPLE = 100000, BASE_WORK = 2000000 }; /* per sample; constant part */

/* Advances up to KM_STEP_BATCH pairs (state of the previous stage, action) over the samples of this stage, as a
 * batch. */
static void advance_states(km_dp_grid *g, int worker, int first, int count) {
  km_tracking_run *run = g->run;
  const size_t n = (size_t)run->arm->n;
  const km_dp_stage *last = &g->stages[g->now - 1], *now = &g->stages[g->now];
  km_path_node *here = &g->here[worker * KM_STEP_BATCH];
  bool alive[KM_STEP_BATCH];
  for (int l = 0; l < count; ++l) {
    const km_dp_state *from = &last->states[(first + l) / g->actions];
    km_dp_state *to = &g->arrivals[first + l];
    to->least = from->least;
    to->sum = from->sum;
    to->parent = (first + l) / g->actions;
    to->samples = from->samples;
    alive[l] = true;
    km_path_node_copy(run->arm, &here[l], &from->node);
  }
  for (int k = 0; k < now->length; ++k) {
    const km_path_node *from[KM_STEP_BATCH];
    km_path_node *at[KM_STEP_BATCH];
    km_step_choice choices[KM_STEP_BATCH];
    km_step_end ends[KM_STEP_BATCH];
    int lane[KM_STEP_BATCH], samples[KM_STEP_BATCH], batch = 0;
    for (int l = 0; l < count; ++l) {
      if (!alive[l])
        continue;
      lane[batch] = l;
      samples[batch] = now->first + k;
      from[batch] = &here[l];
      at[batch] = &g->arrivals[first + l].node;
      choices[batch++] = (km_step_choice){.tan_phi = g->tan_phis + (first + l) % g->actions * run->arm->freedom,
                                          .tries = MAX_PARTIAL_STEPS};
    }
    if (batch == 0)
      return;
    km_tracker_steps(&run->tracker, &g->spaces[worker], samples, batch, from, choices, at, ends);
    for (int i = 0; i < batch && g->eased; ++i)
      ends[i] = km_tracker_ease(&run->tracker, &g->spaces[worker], samples[i], from[i], &choices[i], ends[i], at[i]);
    for (int i = 0; i < batch; ++i) {
      km_dp_state *to = &g->arrivals[first + lane[i]];
      alive[lane[i]] = !ends[i].stop;
      if (ends[i].stop)
        continue;
      memcpy(to->q + (size_t)k * n, to->node.q, n * sizeof *to->q);
      to->least = fmin(to->least, to->node.value);
      to->sum += to->node.weight * to->node.value;
      to->samples++;
      km_path_node_copy(run->arm, &here[lane[i]], &to->node);
    }
  }
}

/* Part of a worker: batches of KM_STEP_BATCH pairs (state, action). */
static void advance_share(void *context, int worker) {
  km_dp_grid *g = context;
  int count = g->stages[g->now - 1].count * g->actions;
  for (int i = worker * KM_STEP_BATCH; i < count; i += g->workers * KM_STEP_BATCH)
    advance_states(g, worker, i, count - i < KM_STEP_BATCH ? count - i : KM_STEP_BATCH);
}

/* Chooses the actions: null-space steps tan φ on a lattice up to tan(angle), so fine that neighbouring actions
 * arrive within the spacing. If that takes too many actions, the lattice is coarser and the result is no reference. */
static bool choose_actions(km_dp_grid *g) {
  const km_dp_stage *last = &g->stages[g->now - 1], *now = &g->stages[g->now];
  const km_path_point *points = g->run->plan->path->points;
  double ds = points[now->first + now->length].s - points[now->first].s, reach = 0.0,
         most = tan(g->run->plan->method.angle);
  for (int i = 0; i < last->count; ++i)
    reach = fmax(reach, ds * most / fmax(last->states[i].node.z, 1e-3));
  km_lattice tan_phis;
  if (!km_lattice_create(g->run->arm->freedom, most, ceil(reach / g->spacing), &g->arena, &tan_phis))
    return false;
  g->actions = tan_phis.count;
  g->tan_phis = tan_phis.points;
  g->bounded = g->bounded || tan_phis.is_coarse;
  return true;
}

/* Computes all arrivals of a stage, in parallel, and keeps the best of each neighbourhood. */
static bool fill_stage(km_dp_grid *g) {
  if (!choose_actions(g))
    return false;
  size_t count = (size_t)g->stages[g->now - 1].count * (size_t)g->actions, had = g->arrival_capacity;
  if (count > had) {
    km_dp_state *is_grown = KM_ARENA_NEW(&g->arena, km_dp_state, count);
    if (!is_grown)
      return false;
    if (had)
      memcpy(is_grown, g->arrivals, had * sizeof *is_grown);
    g->arrivals = is_grown;
    g->arrival_capacity = count;
    for (size_t i = had; i < count; ++i)
      g->arrivals[i] = km_dp_make_state(g, g->length);
  }
  if (g->arena.failed)
    return false;
  km_team_run(km_run_team(g->run), g->workers, advance_share, g);
  return km_dp_keep_best(g, (int)count);
}

/* Writes the track that ends in a state, by following its parents backward. */
static void write_track(km_dp_grid *g, int stage_index, const km_dp_state *end) {
  km_tracking_run *run = g->run;
  const size_t n = (size_t)run->arm->n;
  run->reached = end->samples + 1;
  for (int k = stage_index; k > 0; --k) {
    const km_dp_stage *at = &g->stages[k];
    int count = end->samples - at->first < at->length ? end->samples - at->first : at->length;
    memcpy(run->q + (size_t)(at->first + 1) * n, end->q, (size_t)count * n * sizeof *run->q);
    if (k > 1)
      end = &g->stages[k - 1].states[end->parent];
  }
}

/* No state reached the end of the stage: writes the longest track and determines its stop. */
static km_status stop_early(km_dp_grid *g) {
  km_tracking_run *run = g->run;
  int count = g->stages[g->now - 1].count * g->actions, best = 0;
  for (int i = 1; i < count; ++i)
    if (km_dp_better(g, &g->arrivals[i], &g->arrivals[best]))
      best = i;
  write_track(g, g->now, &g->arrivals[best]);
  const km_step_choice choice = {.tan_phi = g->tan_phis + (best % g->actions) * run->arm->freedom};
  km_path_node node = g->here[0], next = run->space.here;
  static const km_step_choice greedy_choice = {0};
  int sample = run->reached - 1;
  km_tracker_compute_node(&run->tracker, &run->space, sample, run->q + (size_t)sample * (size_t)run->arm->n,
                          &greedy_choice, &node);
  km_arena arena = {0};
  if (km_path_node_create(run->arm, &arena, &next))
    km_run_stop(run, &node, &choice, km_tracker_step(&run->tracker, &run->space, sample, 1.0, &node, &choice, &next));
  km_arena_free(&arena);
  if (run->stop ==
      KM_TRACK_COMPLETE) /* the step needs more partial steps than dynamic programming tries, or its columns were
                          * oriented differently */
    run->stop = KM_TRACK_NOT_CONVERGED;
  return KM_PARTIAL;
}

/* Allocates the grid; its first stage has one state, the start. */
static bool begin(km_dp_grid *g) {
  static const km_step_choice greedy_choice = {0};
  km_tracking_run *run = g->run;
  int intervals = run->plan->path->samples - 1;
  g->stage_count = (intervals + g->length - 1) / g->length;
  g->workers = run->plan->jobs > 1 ? run->plan->jobs : 1;
  g->stages = KM_ARENA_NEW(&g->arena, km_dp_stage, (size_t)g->stage_count + 1);
  g->spaces = KM_ARENA_NEW(&g->arena, km_tracker_space, (size_t)g->workers);
  g->here = KM_ARENA_NEW(&g->arena, km_path_node, (size_t)g->workers * KM_STEP_BATCH);
  bool is_ok = !g->arena.failed;
  for (int i = 0; i < g->workers && is_ok; ++i)
    is_ok = km_tracker_space_create(run->arm, &g->spaces[i]);
  for (int i = 0; i < g->workers * KM_STEP_BATCH && is_ok; ++i)
    is_ok = km_path_node_create(run->arm, &g->arena, &g->here[i]);
  if (is_ok)
    g->stages[0].states = KM_ARENA_NEW(&g->arena, km_dp_state, 1);
  is_ok = is_ok && !g->arena.failed;
  if (!is_ok)
    return false;
  km_dp_state *start = &g->stages[0].states[0];
  *start = km_dp_make_state(g, 1);
  if (g->arena.failed)
    return false;
  g->stages[0].count = 1;
  km_tracker_compute_node(&run->tracker, &run->space, 0, run->start, &greedy_choice, &start->node);
  start->least = start->node.value;
  start->sum = start->node.weight * start->node.value;
  memcpy(run->q, run->start, (size_t)run->arm->n * sizeof *run->q);
  run->reached = 1;
  return true;
}

static bool report_progress(const km_dp_grid *g, int sample) {
  const km_track_plan *plan = g->run->plan;
  double done = (g->pass + (double)sample / (plan->path->samples - 1)) / g->passes;
  return !plan->progress || plan->progress(plan->context, fmin(done, 1.0));
}

/* True if the run exceeded the largest number of Jacobians. */
static bool exceeds_work_limit(const km_dp_grid *g) {
  double work = 0.0;
  for (int i = 0; i < g->workers; ++i)
    work += (double)g->spaces[i].arm.evaluations;
  return work > BASE_WORK + (double)WORK_PER_SAMPLE * g->run->plan->path->samples;
}

/* Solves stage by stage and writes the track of the best final state. */
static km_status solve(km_dp_grid *g, km_error *error) {
  km_tracking_run *run = g->run;
  if (!begin(g))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  int intervals = run->plan->path->samples - 1;
  for (g->now = 1; g->now <= g->stage_count; ++g->now) {
    km_dp_stage *now = &g->stages[g->now];
    now->first = (g->now - 1) * g->length;
    now->length = intervals - now->first < g->length ? intervals - now->first : g->length;
    if (!fill_stage(g))
      return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
    if (now->count == 0)
      return stop_early(g);
    if (!report_progress(g, now->first + now->length))
      return km_fail(error, KM_CANCELLED, "cancelled");
    if (g->now < g->stage_count && exceeds_work_limit(g)) {
      write_track(g, g->now, &now->states[0]);
      run->stop = KM_TRACK_NOT_CONVERGED;
      return KM_PARTIAL;
    }
  }
  write_track(g, g->stage_count, &g->stages[g->stage_count].states[0]);
  run->stop = KM_TRACK_COMPLETE;
  run->column = -1;
  return KM_OK;
}

/* Index of a pass over the path, for the progress, and its use of easing. */
typedef struct pass {
  int index, count;
  bool eased;
} pass;

/* Solves once with a spacing and a stage length. */
static km_status solve_grid(km_tracking_run *run, double spacing, int length, pass p, km_error *error) {
  km_dp_grid g = {.run = run,
                  .spacing = spacing,
                  .length = length < 1 ? 1 : length,
                  .eased = p.eased,
                  .pass = p.index,
                  .passes = p.count};
  km_status status = solve(&g, error);
  run->bounded = g.bounded;
  for (int i = 0; i < g.workers && g.spaces; ++i) {
    run->evaluations += g.spaces[i].arm.evaluations;
    km_tracker_space_free(&g.spaces[i]);
  }
  km_arena_free(&g.arena);
  return status;
}

/* Default spacing: the self-motion that the null-space steps reach over the path, divided into 40 states; 0.005 to
 * 0.1 rad. */
static double choose_spacing(const km_tracking_run *run) {
  const km_path *path = run->plan->path;
  double reach = tan(run->plan->method.angle) * path->points[path->samples - 1].s / 0.5; /* a typical path entry is
                                                                                          * 0.5 */
  return fmin(fmax(reach / 40.0, 0.005), 0.1);
}

static bool is_further(const km_tracking_run *a, const km_tracking_run *b) {
  return a->reached != b->reached ? a->reached > b->reached : a->fraction > b->fraction + 1e-6;
}

/* Solves with the full spacing and stage length into `coarse`, then with half of both into `run`. The second spacing
 * of integrals over the time is a quarter: in each stage the best of a neighbourhood lies up to the spacing off,
 * towards what was cheap so far, and only with a quarter the sum of these shifts over the stages halves. The relative
 * difference of both values is run->converged. The coarse track is used if it is longer. */
static km_status solve_refined(km_tracking_run *run, km_tracking_run *coarse, pass p, km_error *error) {
  const km_method *method = &run->plan->method;
  int length = method->stride > 0 ? method->stride : run->plan->path->samples / 24;
  double spacing = method->spacing > 0.0 ? method->spacing : choose_spacing(run);
  km_status first = solve_grid(coarse, spacing, length, p, error);
  if (first != KM_OK && first != KM_PARTIAL)
    return first;
  ++p.index;
  const double finer = km_objective_needs_forces(&run->plan->objective) ? 0.25 : 0.5;
  km_status status = solve_grid(run, finer * spacing, length / 2, p, error);
  run->converged = (double)NAN;
  if (first == KM_OK && status == KM_OK && !run->bounded) {
    double fine = km_run_score(run, km_run_evaluate(run)), value = km_run_score(coarse, km_run_evaluate(coarse));
    run->converged = fabs(fine - value) / fmax(fabs(fine), 1e-300);
  }
  if (status != KM_PARTIAL || !is_further(coarse, run))
    return status;
  km_run_copy_track(run, coarse);
  return first;
}

/* Solves with two spacings, in a temporary run for the coarse one. */
static km_status solve_twice(km_tracking_run *run, pass p, km_error *error) {
  km_tracking_run coarse;
  if (!km_run_create(run->arm, run->plan, &coarse))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  km_status status = solve_refined(run, &coarse, p, error);
  run->evaluations += coarse.evaluations + coarse.space.arm.evaluations;
  km_run_free(&coarse);
  return status;
}

/* If joint rates end the track early, solves again with easing and takes the longer track. */
km_status km_method_dp(km_tracking_run *run, km_error *error) {
  const int passes = km_tracker_rated(run->arm) ? 4 : 2;
  km_tracking_run eased;
  km_status status = solve_twice(run, (pass){0, passes, false}, error);
  if (status != KM_PARTIAL || passes == 2)
    return status;
  if (!km_run_create(run->arm, run->plan, &eased))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  km_status again = solve_twice(&eased, (pass){2, passes, true}, error);
  if (again == KM_OK || (again == KM_PARTIAL && !is_further(run, &eased))) {
    km_run_copy_track(run, &eased);
    run->converged = eased.converged;
    run->bounded = eased.bounded;
  }
  run->evaluations += eased.evaluations + eased.space.arm.evaluations;
  km_run_free(&eased);
  return again == KM_PARTIAL ? status : again;
}
