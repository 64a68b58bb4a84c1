/* Dynamic programming over the self-motions: the reference that the other methods are measured by.
 *
 * Stage by stage every state is led on with a range of tilts, along real tracks whose samples all keep the limits, and
 * of the states that arrive within `spacing` of each other on the self-motions only the best goes on. There is no
 * global redundancy parameter: components merge and split as they like. Where half the spacing on half the stage
 * changes the value by little, the result is the optimum to about that much. */
#include "base/parallel.h"
#include "redundancy/branches.h"
#include "redundancy/method.h"

#include <stdlib.h>
#include <string.h>

/* States on curves, which lie wider where there would be more; on surfaces and more, where there is no end of them. */
enum { MOST_STATES = 1000, MOST_SPREAD = 250 };
/* Parts of a step: where singular poses are near they can be without end, and such a step is none to plan with. */
enum { MOST_TRIES = 200 };
/* Jacobians a pass may take: far more than the states of any path need whose steps are ordinary. */
enum { MOST_WORK = 100000, WORK_ASIDE = 2000000 }; /* a sample, and beside them */

typedef struct state {
  double least, sum;
  int parent;  /* in the stage before */
  int samples; /* reached since the start */
  double *q;   /* [stage length × n] of the stage that ends here */
  km_node node;
} state;

typedef struct stage {
  state *states;
  int count, first, length; /* samples first + 1 … first + length */
} stage;

typedef struct grid {
  km_run *run;
  km_arena arena;
  double spacing;
  bool eased; /* tilts turn back as far as the rates ask */
  bool bounded;
  int pass, passes; /* for the progress */
  int length, stage_count, actions, workers;
  stage *stages;
  int now;         /* the stage being filled */
  double *tilts;   /* [actions × freedom] */
  state *arrivals; /* [states · actions] */
  size_t arrival_capacity;
  km_team *team;
  km_walk_space *spaces;
  km_node *here;
} grid;

static bool by_mean(const grid *g) {
  return km_objective_by_mean(&g->run->plan->objective);
}

/* Lead up to four states of the last stage on, side by side, each by an action of its own. */
static void lead(grid *g, int worker, int first, int count) {
  km_run *run = g->run;
  const size_t n = (size_t)run->arm->n;
  const stage *last = &g->stages[g->now - 1], *now = &g->stages[g->now];
  km_node *here = &g->here[worker * KM_WALK_ABREAST];
  bool alive[KM_WALK_ABREAST];
  for (int l = 0; l < count; ++l) {
    const state *from = &last->states[(first + l) / g->actions];
    state *to = &g->arrivals[first + l];
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
    km_way ways[KM_WALK_ABREAST];
    km_step_end ends[KM_WALK_ABREAST];
    int lane[KM_WALK_ABREAST], abreast = 0;
    for (int l = 0; l < count; ++l) {
      if (!alive[l])
        continue;
      lane[abreast] = l;
      from[abreast] = &here[l];
      at[abreast] = &g->arrivals[first + l].node;
      ways[abreast++] = (km_way){.tilt = g->tilts + (first + l) % g->actions * run->arm->freedom, .tries = MOST_TRIES};
    }
    if (abreast == 0)
      return;
    km_walk_steps(&run->walk, &g->spaces[worker], now->first + k, abreast, from, ways, at, ends);
    for (int i = 0; i < abreast && g->eased; ++i)
      ends[i] = km_walk_ease(&run->walk, &g->spaces[worker], now->first + k, from[i], &ways[i], ends[i], at[i]);
    for (int i = 0; i < abreast; ++i) {
      state *to = &g->arrivals[first + lane[i]];
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
  grid *g = context;
  int count = g->stages[g->now - 1].count * g->actions;
  for (int i = worker * KM_WALK_ABREAST; i < count; i += g->workers * KM_WALK_ABREAST)
    lead(g, worker, i, count - i < KM_WALK_ABREAST ? count - i : KM_WALK_ABREAST);
}

/* Better first: further, then the value, then the other aggregate; else the order of the work. */
static bool better(const grid *g, const state *a, const state *b) {
  if (a->samples != b->samples)
    return a->samples > b->samples;
  double x[2] = {km_run_rounded(a->least), km_run_rounded(a->sum)};
  double y[2] = {km_run_rounded(b->least), km_run_rounded(b->sum)};
  int first = by_mean(g);
  if (x[first] != y[first])
    return x[first] > y[first];
  return x[!first] > y[!first];
}

/* Full turns of a hinge without limits make no difference to what follows. */
static bool near(const km_arm *a, const double *x, const double *y, double spacing) {
  double sum = 0.0;
  for (int k = 0; k < a->n && sum < spacing * spacing; ++k) {
    bool free_turns = a->low[k] == -(double)INFINITY && a->high[k] == (double)INFINITY;
    double way = free_turns ? km_arm_difference(a, k, x[k], y[k]) : y[k] - x[k];
    sum += way * way;
  }
  return sum < spacing * spacing;
}

static state make_state(grid *g, int length) {
  state s = {.q = KM_ARENA_NEW(&g->arena, double, (size_t)length *(size_t)g->run->arm->n)};
  km_node_create(g->run->arm, &g->arena, &s.node);
  return s;
}

static void copy_state(const grid *g, state *to, const state *from, int length) {
  double *q = to->q;
  km_node node = to->node;
  memcpy(q, from->q, (size_t)length * (size_t)g->run->arm->n * sizeof *q);
  km_node_copy(g->run->arm, &node, &from->node);
  *to = *from;
  to->q = q;
  to->node = node;
}

/* The order of arrivals from the best, without moving them. */
typedef struct ranked {
  const grid *grid;
  int index;
} ranked;

static int by_rank(const void *a, const void *b) {
  const ranked *x = a, *y = b;
  const state *p = &x->grid->arrivals[x->index], *q = &y->grid->arrivals[y->index];
  if (better(x->grid, p, q))
    return -1;
  return better(x->grid, q, p) ? 1 : x->index - y->index;
}

/* Of the arrivals in order, those that are the best of their neighbourhood, into kept[most]. Their number; one more
 * than `most` if there are more. */
static int choose_best(const grid *g, const ranked *order, int arrived, double spacing, int most, int *kept) {
  const stage *now = &g->stages[g->now];
  int full = now->first + now->length, count = 0;
  for (int i = 0; i < arrived; ++i) {
    const state *one = &g->arrivals[order[i].index];
    bool taken = one->samples < full;
    for (int k = 0; k < count && !taken; ++k)
      taken = near(g->run->arm, g->arrivals[kept[k]].node.q, one->node.q, spacing);
    if (taken)
      continue;
    if (count == most)
      return most + 1;
    kept[count++] = order[i].index;
  }
  return count;
}

/* The best of each neighbourhood go on. On curves neighbourhoods widen until there are no more than so many; on
 * surfaces the best of them count. */
static bool keep_best(grid *g, int arrived) {
  const bool spread = g->run->arm->freedom > 1;
  const int most = spread ? MOST_SPREAD : MOST_STATES;
  stage *now = &g->stages[g->now];
  ranked *order = KM_NEW(ranked, (size_t)arrived + 1);
  int *kept = KM_NEW(int, (size_t)most + 1), count = 0;
  bool whole = order && kept;
  for (int i = 0; whole && i < arrived; ++i)
    order[i] = (ranked){g, i};
  if (whole) {
    qsort(order, (size_t)arrived, sizeof *order, by_rank);
    double spacing = g->spacing;
    while ((count = choose_best(g, order, arrived, spacing, most, kept)) > most && !spread)
      spacing *= 2.0;
    g->bounded = g->bounded || spacing > g->spacing;
    count = count > most ? most : count;
    now->states = KM_ARENA_NEW(&g->arena, state, (size_t)count + 1);
  }
  for (int i = 0; whole && !g->arena.failed && i < count; ++i) {
    now->states[i] = make_state(g, now->length);
    if (!g->arena.failed)
      copy_state(g, &now->states[now->count++], &g->arrivals[kept[i]], now->length);
  }
  whole = whole && !g->arena.failed;
  km_free(order);
  km_free(kept);
  return whole;
}

/* So many tilts that neighbours land no further apart than the spacing. */
static bool choose_actions(grid *g) {
  const km_arm *a = g->run->arm;
  const stage *last = &g->stages[g->now - 1], *now = &g->stages[g->now];
  const km_path_point *points = g->run->plan->path->points;
  double ds = points[now->first + now->length].s - points[now->first].s, way = 0.0,
         most = tan(g->run->plan->method.angle);
  for (int i = 0; i < last->count; ++i)
    way = fmax(way, ds * most / fmax(last->states[i].node.z, 1e-3));
  int each = (int)ceil(way / g->spacing);
  each = a->freedom == 0 ? 0 : each < 1 ? 1 : each > 8 ? 8 : each;
  g->actions = a->freedom <= 1 ? 2 * each + 1 : 1 + 8 * (each > 2 ? 2 : each);
  g->tilts = KM_ARENA_NEW(&g->arena, double, (size_t)g->actions *(size_t)(a->freedom + 1));
  if (!g->tilts)
    return false;
  for (int k = 1; k < g->actions; ++k) {
    double *tilt = g->tilts + k * a->freedom;
    if (a->freedom == 1) {
      tilt[0] = (k % 2 ? -1.0 : 1.0) * most * ((k + 1) / 2) / each;
    } else {
      double around = M_PI * 0.25 * ((k - 1) % 8), size = most * (k > 8 ? 0.5 : 1.0);
      tilt[(k - 1) / 4 % a->freedom] += size * cos(around);
      tilt[((k - 1) / 4 + 1) % a->freedom] += size * sin(around);
    }
  }
  return true;
}

static bool fill_stage(grid *g) {
  if (!choose_actions(g))
    return false;
  size_t count = (size_t)g->stages[g->now - 1].count * (size_t)g->actions, had = g->arrival_capacity;
  if (count > had) {
    state *grown = KM_ARENA_NEW(&g->arena, state, count);
    if (!grown)
      return false;
    if (had)
      memcpy(grown, g->arrivals, had * sizeof *grown);
    g->arrivals = grown;
    g->arrival_capacity = count;
    for (size_t i = had; i < count; ++i)
      g->arrivals[i] = make_state(g, g->length);
  }
  if (g->arena.failed)
    return false;
  km_team_run(g->team, g->workers, lead_some, g);
  return keep_best(g, (int)count);
}

/* The track that leads to a state; q of its own stage up to what it reached. */
static void trace(grid *g, int stage_index, const state *end) {
  km_run *run = g->run;
  const size_t n = (size_t)run->arm->n;
  run->reached = end->samples + 1;
  for (int k = stage_index; k > 0; --k) {
    const stage *at = &g->stages[k];
    int count = end->samples - at->first < at->length ? end->samples - at->first : at->length;
    memcpy(run->q + (size_t)(at->first + 1) * n, end->q, (size_t)count * n * sizeof *run->q);
    if (k > 1)
      end = &g->stages[k - 1].states[end->parent];
  }
}

/* Nothing comes to the end of the stage: the track that goes furthest, and why it ends there. */
static km_status stop_short(grid *g) {
  km_run *run = g->run;
  int count = g->stages[g->now - 1].count * g->actions, best = 0;
  for (int i = 1; i < count; ++i)
    if (better(g, &g->arrivals[i], &g->arrivals[best]))
      best = i;
  trace(g, g->now, &g->arrivals[best]);
  const km_way way = {.tilt = g->tilts + (best % g->actions) * run->arm->freedom};
  km_node node = g->here[0], next = run->space.here;
  static const km_way plain = {0};
  int sample = run->reached - 1;
  km_walk_begin(&run->walk, &run->space, sample, run->q + (size_t)sample * (size_t)run->arm->n, &plain, &node);
  km_arena arena = {0};
  if (km_node_create(run->arm, &arena, &next))
    km_run_stop(run, &node, &way, km_walk_step(&run->walk, &run->space, sample, 1.0, &node, &way, &next));
  km_arena_free(&arena);
  if (run->stop ==
      KM_TRACK_COMPLETE) /* a step of more parts than are tried here, or the sense of its columns was another */
    run->stop = KM_TRACK_GAVE_OUT;
  return KM_PARTIAL;
}

static bool begin(grid *g) {
  static const km_way plain = {0};
  km_run *run = g->run;
  int intervals = run->plan->path->samples - 1;
  g->stage_count = (intervals + g->length - 1) / g->length;
  g->workers = run->plan->jobs > 1 ? run->plan->jobs : 1;
  g->stages = KM_ARENA_NEW(&g->arena, stage, (size_t)g->stage_count + 1);
  g->spaces = KM_ARENA_NEW(&g->arena, km_walk_space, (size_t)g->workers);
  g->here = KM_ARENA_NEW(&g->arena, km_node, (size_t)g->workers * KM_WALK_ABREAST);
  bool whole = !g->arena.failed;
  for (int i = 0; i < g->workers && whole; ++i)
    whole = km_walk_space_create(run->arm, &g->spaces[i]);
  for (int i = 0; i < g->workers * KM_WALK_ABREAST && whole; ++i)
    whole = km_node_create(run->arm, &g->arena, &g->here[i]);
  if (whole)
    g->stages[0].states = KM_ARENA_NEW(&g->arena, state, 1);
  whole = whole && !g->arena.failed;
  if (!whole)
    return false;
  state *start = &g->stages[0].states[0];
  *start = make_state(g, 1);
  if (g->arena.failed)
    return false;
  g->stages[0].count = 1;
  km_walk_begin(&run->walk, &run->space, 0, run->start, &plain, &start->node);
  start->least = start->sum = start->node.value;
  memcpy(run->q, run->start, (size_t)run->arm->n * sizeof *run->q);
  run->reached = 1;
  return true;
}

static bool goes_on(const grid *g, int sample) {
  const km_track_plan *plan = g->run->plan;
  double done = (g->pass + (double)sample / (plan->path->samples - 1)) / g->passes;
  return !plan->progress || plan->progress(plan->context, fmin(done, 1.0));
}

/* More work than any path with ordinary steps needs? */
static bool gives_out(const grid *g) {
  double work = 0.0;
  for (int i = 0; i < g->workers; ++i)
    work += (double)g->spaces[i].arm.evaluations;
  return work > WORK_ASIDE + (double)MOST_WORK * g->run->plan->path->samples;
}

static km_status solve(grid *g, km_error *error) {
  km_run *run = g->run;
  if (!begin(g))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  int intervals = run->plan->path->samples - 1;
  for (g->now = 1; g->now <= g->stage_count; ++g->now) {
    stage *now = &g->stages[g->now];
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
      run->stop = KM_TRACK_GAVE_OUT;
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

static km_status solve_at(km_run *run, double spacing, int length, pass p, km_error *error) {
  grid g = {.run = run,
            .spacing = spacing,
            .length = length < 1 ? 1 : length,
            .eased = p.eased,
            .pass = p.index,
            .passes = p.count};
  g.team = run->plan->jobs > 1 ? km_team_create(run->plan->jobs) : NULL;
  km_status status = solve(&g, error);
  run->bounded = g.bounded;
  km_team_free(g.team);
  for (int i = 0; i < g.workers && g.spaces; ++i) {
    run->evaluations += g.spaces[i].arm.evaluations;
    km_walk_space_free(&g.spaces[i]);
  }
  km_arena_free(&g.arena);
  return status;
}

/* What the tilts can reach over the whole path is cut into some forty states, none further than a tenth of a radian. */
static double choose_spacing(const km_run *run) {
  const km_path *path = run->plan->path;
  double reach = tan(run->plan->method.angle) * path->points[path->samples - 1].s / 0.5; /* path entries about 0.5 */
  return fmin(fmax(reach / 40.0, 0.005), 0.1);
}

static bool is_further(const km_run *a, const km_run *b) {
  return a->reached != b->reached ? a->reached > b->reached : a->fraction > b->fraction + 1e-6;
}

/* At half the spacing and stage, in `run`, after the whole of them in `coarse`; the coarse track where it goes further.
 */
static km_status refine(km_run *run, km_run *coarse, pass p, km_error *error) {
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
static km_status solve_twice(km_run *run, pass p, km_error *error) {
  km_run coarse;
  if (!km_run_create(run->arm, run->plan, &coarse))
    return km_fail(error, KM_MEMORY, "out of memory for dynamic programming");
  km_status status = refine(run, &coarse, p, error);
  run->evaluations += coarse.evaluations + coarse.space.arm.evaluations;
  km_run_free(&coarse);
  return status;
}

/* Where it stops short under rates, again with tilts that keep them; the track that goes further. */
km_status km_method_dp(km_run *run, km_error *error) {
  const int passes = km_walk_rated(run->arm) ? 4 : 2;
  km_run eased;
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
