/* Dynamic programming over the self-motions: the reference that the other methods are measured by.
 *
 * Stage by stage every state is led on with a range of tilts, along real tracks whose samples all keep the limits, and
 * of the states that arrive within `spacing` of each other on the self-motions only the best goes on. There is no
 * global redundancy parameter: components merge and split as they like. Where half the spacing on half the stage
 * changes the value by little, the result is the optimum to about that much. */
#include "arm/methods/dynamic_programming.h"

#include "arm/methods/ball_lattice.h"

#include <stdlib.h>
#include <string.h>

/* Parts of a step: where singular poses are near they can be without end, and such a step is none to plan with. */
enum { MOST_TRIES = 200 };
/* Jacobians a pass may take: far more than the states of any path need whose steps are ordinary. */
enum { MOST_WORK = 100000, WORK_ASIDE = 2000000 }; /* a sample, and beside them */

/* Lead up to KM_WALK_ABREAST states of the last stage on, side by side, each by an action of its own. */
static void lead(km_dp_grid *g, int worker, int first, int count) {
  km_entry_range *run = g->run;
  const size_t n = (size_t)run->arm->n;
  const km_dp_stage *last = &g->stages[g->now - 1], *now = &g->stages[g->now];
  km_node *here = &g->here[worker * KM_WALK_ABREAST];
  bool alive[KM_WALK_ABREAST];
  for (int l = 0; l < count; ++l) {
    const km_dp_state *from = &last->states[(first + l) / g->actions];
    km_dp_state *to = &g->arrivals[first + l];
    to->least = from->least;
    to->sum = from->sum;
    to->parent = (first + l) / g->actions;
    to->samples = from->samples;
    alive[l] = true;
    km_node_copy(run->arm, &here[l], &from->node);
  }
  for (int k = 0; k < now->length; ++k) {
    const km_node *from[KM_WALK_ABREAST];
    km_node *at[KM_WALK_ABREAST];
    km_step_choice ways[KM_WALK_ABREAST];
    km_step_end ends[KM_WALK_ABREAST];
    int lane[KM_WALK_ABREAST], samples[KM_WALK_ABREAST], abreast = 0;
    for (int l = 0; l < count; ++l) {
      if (!alive[l])
        continue;
      lane[abreast] = l;
      samples[abreast] = now->first + k;
      from[abreast] = &here[l];
      at[abreast] = &g->arrivals[first + l].node;
      ways[abreast++] =
          (km_step_choice){.tilt = g->tilts + (first + l) % g->actions * run->arm->freedom, .tries = MOST_TRIES};
    }
    if (abreast == 0)
      return;
    km_tracker_steps(&run->walk, &g->spaces[worker], samples, abreast, from, ways, at, ends);
    for (int i = 0; i < abreast && g->eased; ++i)
      ends[i] = km_tracker_ease(&run->walk, &g->spaces[worker], samples[i], from[i], &ways[i], ends[i], at[i]);
    for (int i = 0; i < abreast; ++i) {
      km_dp_state *to = &g->arrivals[first + lane[i]];
      alive[lane[i]] = !ends[i].stop;
      if (ends[i].stop)
        continue;
      memcpy(to->q + (size_t)k * n, to->node.q, n * sizeof *to->q);
      to->least = fmin(to->least, to->node.value);
      to->sum += to->node.value;
      to->samples++;
      km_node_copy(run->arm, &here[lane[i]], &to->node);
    }
  }
}

static void lead_some(void *context, int worker) {
  km_dp_grid *g = context;
  int count = g->stages[g->now - 1].count * g->actions;
  for (int i = worker * KM_WALK_ABREAST; i < count; i += g->workers * KM_WALK_ABREAST)
    lead(g, worker, i, count - i < KM_WALK_ABREAST ? count - i : KM_WALK_ABREAST);
}

/* Tilts up to the method's angle in every direction, which neighbours land no further apart by than the spacing; where that takes too
 * many they lie wider, and no reference comes of it. */
static bool choose_actions(km_dp_grid *g) {
  const km_dp_stage *last = &g->stages[g->now - 1], *now = &g->stages[g->now];
  const km_path_point *points = g->run->plan->path->points;
  double ds = points[now->first + now->length].s - points[now->first].s, way = 0.0,
         most = tan(g->run->plan->method.angle);
  for (int i = 0; i < last->count; ++i)
    way = fmax(way, ds * most / fmax(last->states[i].node.z, 1e-3));
  km_lattice tilts;
  if (!km_lattice_make(g->run->arm->freedom, most, ceil(way / g->spacing), &g->arena, &tilts))
    return false;
  g->actions = tilts.count;
  g->tilts = tilts.points;
  g->bounded = g->bounded || tilts.wider;
  return true;
}

static bool fill_stage(km_dp_grid *g) {
  if (!choose_actions(g))
    return false;
  size_t count = (size_t)g->stages[g->now - 1].count * (size_t)g->actions, had = g->arrival_capacity;
  if (count > had) {
    km_dp_state *grown = KM_ARENA_NEW(&g->arena, km_dp_state, count);
    if (!grown)
      return false;
    if (had)
      memcpy(grown, g->arrivals, had * sizeof *grown);
    g->arrivals = grown;
    g->arrival_capacity = count;
    for (size_t i = had; i < count; ++i)
      g->arrivals[i] = km_dp_make_state(g, g->length);
  }
  if (g->arena.failed)
    return false;
  km_team_run(km_run_team(g->run), g->workers, lead_some, g);
  return km_dp_keep_best(g, (int)count);
}

/* The track that leads to a state; q of its own stage up to what it reached. */
static void trace(km_dp_grid *g, int stage_index, const km_dp_state *end) {
  km_entry_range *run = g->run;
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

/* Nothing comes to the end of the stage: the track that goes furthest, and why it ends there. */
static km_status stop_short(km_dp_grid *g) {
  km_entry_range *run = g->run;
  int count = g->stages[g->now - 1].count * g->actions, best = 0;
  for (int i = 1; i < count; ++i)
    if (km_dp_better(g, &g->arrivals[i], &g->arrivals[best]))
      best = i;
  trace(g, g->now, &g->arrivals[best]);
  const km_step_choice way = {.tilt = g->tilts + (best % g->actions) * run->arm->freedom};
  km_node node = g->here[0], next = run->space.here;
  static const km_step_choice plain = {0};
  int sample = run->reached - 1;
  km_tracker_begin(&run->walk, &run->space, sample, run->q + (size_t)sample * (size_t)run->arm->n, &plain, &node);
  km_arena arena = {0};
  if (km_node_create(run->arm, &arena, &next))
    km_run_stop(run, &node, &way, km_tracker_step(&run->walk, &run->space, sample, 1.0, &node, &way, &next));
  km_arena_free(&arena);
  if (run->stop ==
      KM_TRACK_COMPLETE) /* a step of more parts than are tried here, or the sense of its columns was another */
    run->stop = KM_TRACK_NOT_CONVERGED;
  return KM_PARTIAL;
}

static bool begin(km_dp_grid *g) {
  static const km_step_choice plain = {0};
  km_entry_range *run = g->run;
  int intervals = run->plan->path->samples - 1;
  g->stage_count = (intervals + g->length - 1) / g->length;
  g->workers = run->plan->jobs > 1 ? run->plan->jobs : 1;
  g->stages = KM_ARENA_NEW(&g->arena, km_dp_stage, (size_t)g->stage_count + 1);
  g->spaces = KM_ARENA_NEW(&g->arena, km_tracker_space, (size_t)g->workers);
  g->here = KM_ARENA_NEW(&g->arena, km_node, (size_t)g->workers * KM_WALK_ABREAST);
  bool whole = !g->arena.failed;
  for (int i = 0; i < g->workers && whole; ++i)
    whole = km_tracker_space_create(run->arm, &g->spaces[i]);
  for (int i = 0; i < g->workers * KM_WALK_ABREAST && whole; ++i)
    whole = km_node_create(run->arm, &g->arena, &g->here[i]);
  if (whole)
    g->stages[0].states = KM_ARENA_NEW(&g->arena, km_dp_state, 1);
  whole = whole && !g->arena.failed;
  if (!whole)
    return false;
  km_dp_state *start = &g->stages[0].states[0];
  *start = km_dp_make_state(g, 1);
  if (g->arena.failed)
    return false;
  g->stages[0].count = 1;
  km_tracker_begin(&run->walk, &run->space, 0, run->start, &plain, &start->node);
  start->least = start->sum = start->node.value;
  memcpy(run->q, run->start, (size_t)run->arm->n * sizeof *run->q);
  run->reached = 1;
  return true;
}

static bool goes_on(const km_dp_grid *g, int sample) {
  const km_track_plan *plan = g->run->plan;
  double done = (g->pass + (double)sample / (plan->path->samples - 1)) / g->passes;
  return !plan->progress || plan->progress(plan->context, fmin(done, 1.0));
}

/* More work than any path with ordinary steps needs? */
static bool gives_out(const km_dp_grid *g) {
  double work = 0.0;
  for (int i = 0; i < g->workers; ++i)
    work += (double)g->spaces[i].arm.evaluations;
  return work > WORK_ASIDE + (double)MOST_WORK * g->run->plan->path->samples;
}

static km_status solve(km_dp_grid *g, km_error *error) {
  km_entry_range *run = g->run;
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
      return stop_short(g);
    if (!goes_on(g, now->first + now->length))
      return km_fail(error, KM_CANCELLED, "cancelled");
    if (g->now < g->stage_count && gives_out(g)) {
      trace(g, g->now, &now->states[0]);
      run->stop = KM_TRACK_NOT_CONVERGED;
      return KM_PARTIAL;
    }
  }
  trace(g, g->stage_count, &g->stages[g->stage_count].states[0]);
  run->stop = KM_TRACK_COMPLETE;
  run->column = -1;
  return KM_OK;
}

/* Which of the passes over the path this is: for the progress, and whether it is eased. */
typedef struct pass {
  int index, count;
  bool eased;
} pass;

static km_status solve_at(km_entry_range *run, double spacing, int length, pass p, km_error *error) {
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

/* What the tilts can reach over the whole path is cut into some forty states, none further than a tenth of a radian. */
static double choose_spacing(const km_entry_range *run) {
  const km_path *path = run->plan->path;
  double reach = tan(run->plan->method.angle) * path->points[path->samples - 1].s / 0.5; /* path entries about 0.5 */
  return fmin(fmax(reach / 40.0, 0.005), 0.1);
}

static bool is_further(const km_entry_range *a, const km_entry_range *b) {
  return a->reached != b->reached ? a->reached > b->reached : a->fraction > b->fraction + 1e-6;
}

/* At half the spacing and stage, in `run`, after the whole of them in `coarse`; the coarse track where it goes further.
 */
static km_status refine(km_entry_range *run, km_entry_range *coarse, pass p, km_error *error) {
  const km_method *method = &run->plan->method;
  int length = method->stride > 0 ? method->stride : run->plan->path->samples / 24;
  double spacing = method->spacing > 0.0 ? method->spacing : choose_spacing(run);
  km_status first = solve_at(coarse, spacing, length, p, error);
  if (first != KM_OK && first != KM_PARTIAL)
    return first;
  ++p.index;
  km_status status = solve_at(run, 0.5 * spacing, length / 2, p, error);
  run->converged = (double)NAN;
  if (first == KM_OK && status == KM_OK && !run->bounded) {
    double fine = km_run_score(run, km_run_evaluate(run)), value = km_run_score(coarse, km_run_evaluate(coarse));
    run->converged = fabs(fine - value) / fmax(fabs(fine), 1e-300);
  }
  if (status != KM_PARTIAL || !is_further(coarse, run))
    return status;
  km_run_take(run, coarse);
  return first;
}

/* At two spacings and stages. */
static km_status solve_twice(km_entry_range *run, pass p, km_error *error) {
  km_entry_range coarse;
  if (!km_run_create(run->arm, run->plan, &coarse))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  km_status status = refine(run, &coarse, p, error);
  run->evaluations += coarse.evaluations + coarse.space.arm.evaluations;
  km_run_free(&coarse);
  return status;
}

/* Where it stops short under rates, again with tilts that keep them; the track that goes further. */
km_status km_method_dp(km_entry_range *run, km_error *error) {
  const int passes = km_tracker_rated(run->arm) ? 4 : 2;
  km_entry_range eased;
  km_status status = solve_twice(run, (pass){0, passes, false}, error);
  if (status != KM_PARTIAL || passes == 2)
    return status;
  if (!km_run_create(run->arm, run->plan, &eased))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  km_status again = solve_twice(&eased, (pass){2, passes, true}, error);
  if (again == KM_OK || (again == KM_PARTIAL && !is_further(run, &eased))) {
    km_run_take(run, &eased);
    run->converged = eased.converged;
    run->bounded = eased.bounded;
  }
  run->evaluations += eased.evaluations + eased.space.arm.evaluations;
  km_run_free(&eased);
  return again == KM_PARTIAL ? status : again;
}
