/* Look-ahead over a receding horizon: at every sample a tree of branches grows, which turn the path-control column
 * by kφ; the first sample of the best leaf's branch is executed (docs/theory.md 12.6). If joint rates end the track
 * early, the method runs again with easing (12.4). Greedy's track replaces the result if it is better. */
#include "arm/methods/lookahead_tree.h"

#include <string.h>

enum { MAX_NODES = 2000000 };

/* Branch index, at level `at_level`, of the ancestor of a node. */
static int branch_of(const km_look_tree *t, int level, int index, int at_level) {
  for (; level > at_level; --level)
    index /= t->branches;
  return index % t->branches;
}

/* Compares two values; a relative difference up to 1e-9 is equality, so rounding doesn't decide between symmetric
 * configurations. */
static int compare(double a, double b) {
  double slack = 1e-9 * fmax(fabs(a), fabs(b));
  return a > b + slack ? 1 : b > a + slack ? -1 : 0;
}

typedef struct leaf {
  int level, index;
} leaf;

/* True if leaf a is better: more samples, then the aggregate of the objective, then the other aggregate, then
 * smaller |φ|, then −φ, level by level. */
static bool is_better(const km_look_tree *t, leaf a, leaf b) {
  const km_look_node *x = km_look_node_at(t, t->now, a.level, a.index),
                     *y = km_look_node_at(t, t->now, b.level, b.index);
  if (x->samples != y->samples)
    return x->samples > y->samples;
  bool sum = t->run->plan->method.sum || km_objective_needs_forces(&t->run->plan->objective);
  int first = sum ? compare(x->sum, y->sum) : compare(x->least, y->least);
  int second = sum ? compare(x->least, y->least) : compare(x->sum, y->sum);
  if (first || second)
    return first ? first > 0 : second > 0;
  int middle = (t->branches - 1) / 2;
  for (int level = 0; level <= a.level && level <= b.level; ++level) {
    int i = branch_of(t, a.level, a.index, level) - middle, k = branch_of(t, b.level, b.index, level) - middle;
    if (abs(i) != abs(k))
      return abs(i) < abs(k);
    if (i != k)
      return i < k;
  }
  return false;
}

/* Returns the best leaf; if no branch survives, the longest one. Level −1: no branch has a step. */
static leaf choose(const km_look_tree *t, int levels) {
  leaf best = {-1, 0};
  for (int level = levels - 1; level >= 0; --level) { /* branches that ended early compete by the samples they
                                                       * reached */
    int count = km_look_count_at(t, level);
    for (int i = 0; i < count; ++i) {
      const km_look_node *node = km_look_node_at(t, t->now, level, i);
      bool is_dead_end = !node->alive && node->samples > 0;
      leaf one = {level, i};
      if ((level == levels - 1 && node->alive) || is_dead_end)
        best = best.level < 0 || is_better(t, one, best) ? one : best;
    }
  }
  return best;
}

/* Grows the tree from the last sample and returns the branch to execute; −1: none. */
static int best_branch(km_look_tree *t) {
  leaf best = choose(t, km_look_tree_grow(t));
  return best.level < 0 ? -1 : branch_of(t, best.level, best.index, 0);
}

/* Track of another method, for comparison. */
typedef struct alternative {
  km_track_plan plan;
  km_tracking_run run;
  km_status ended; /* status of the method; KM_MEMORY: no run was created */
  km_error error;
  bool is_made, has_run; /* has_run: the run must be freed */
} alternative;

static void make_alternative(alternative *r, const km_tracking_run *own, km_method_function method) {
  r->is_made = true;
  r->has_run = km_run_create(own->arm, &r->plan, &r->run);
  r->ended = r->has_run ? method(&r->run, &r->error) : km_fail(&r->error, KM_MEMORY, "out of memory for a track");
}

static void free_alternative(alternative *r) {
  if (r->has_run)
    km_run_free(&r->run);
}

/* Executes look-ahead steps up to a sample. */
static km_status advance_to(km_look_tree *t, int end_sample, bool reports_progress, km_error *error) {
  km_tracking_run *run = t->run;
  const size_t n = (size_t)run->arm->n;
  static const km_step_choice greedy_choice = {0};
  for (; run->reached < end_sample; ++run->reached) {
    int branch = best_branch(t);
    if (branch < 0) {
      km_run_stop(run, &t->now->root, &greedy_choice, t->now->middle);
      return KM_PARTIAL;
    }
    km_look_tree_recede(t, branch);
    memcpy(run->q + (size_t)run->reached * n, t->now->root.q, n * sizeof *run->q);
    if (reports_progress && !km_run_report_progress(run, run->reached))
      return km_fail(error, KM_CANCELLED, "cancelled");
  }
  return KM_OK;
}

/* The last part of the path, in which a tree has one level only. One thread computes it while another one computes
 * greedy's track. */
typedef struct ending {
  km_look_tree *tree;
  alternative *greedy;
  const void *caller; /* km_thread_mark of the calling thread, the only one that reports progress */
  km_status status;
  km_error *error;
} ending;

static void run_ending(void *context, int index) {
  ending *e = context;
  if (index == 1)
    make_alternative(e->greedy, e->tree->run, km_method_greedy);
  else
    e->status = advance_to(e->tree, e->tree->run->plan->path->samples, km_thread_mark() == e->caller, e->error);
}

/* Computes the track from the start to its end. If `greedy` isn't NULL, greedy's track can be computed in parallel
 * with the last part. */
static km_status run_tree(km_look_tree *t, alternative *greedy, km_error *error) {
  static const km_step_choice greedy_choice = {0};
  km_tracking_run *run = t->run;
  const int samples = run->plan->path->samples, last = samples - t->stride;
  const bool beside = greedy && t->branches <= KM_STEP_BATCH && last > 1;
  km_tracker_compute_node(&run->tracker, &run->space, 0, run->start, &greedy_choice, &t->now->root);
  memcpy(run->q, t->now->root.q, (size_t)run->arm->n * sizeof *run->q);
  run->reached = 1;
  km_status status = advance_to(t, beside ? last : samples, true, error);
  if (status || !beside)
    return status;
  ending e = {t, greedy, km_thread_mark(), KM_OK, error};
  km_team_run(km_run_team(run), 2, run_ending, &e);
  return e.status;
}

static km_status run_lookahead(km_tracking_run *run, bool eased, alternative *greedy, km_error *error) {
  km_look_tree t;
  bool is_ok = km_look_tree_create(&t, run);
  t.eased = eased;
  km_status status =
      is_ok ? run_tree(&t, greedy, error) : km_fail(error, KM_MEMORY, "out of memory for a look-ahead tree");
  km_look_tree_destroy(&t);
  return status;
}

static km_status run_eased(km_tracking_run *run, km_error *error) {
  return run_lookahead(run, true, NULL, error);
}

/* Two tracks of one plan and their values. */
typedef struct track_pair {
  km_tracking_run *run[2];
  km_run_value value[2];
} track_pair;

static void evaluate(void *context, int index) {
  track_pair *c = context;
  c->value[index] = km_run_evaluate(c->run[index]);
}

/* True if the other track is better: it is longer, or as long with a better objective. */
static bool is_better_track(km_tracking_run *other, km_tracking_run *own) {
  track_pair c = {.run = {own, other}};
  km_team_run(km_run_team(own), 2, evaluate, &c);
  if (other->reached != own->reached)
    return other->reached > own->reached;
  if (fabs(other->fraction - own->fraction) > 1e-6)
    return other->fraction > own->fraction;
  return compare(km_run_score(own, c.value[1]), km_run_score(own, c.value[0])) > 0;
}

/* Replaces the track by the other one if that is better; *taken is true then. */
static km_status adopt_if_better(km_tracking_run *run, km_status status, alternative *other, bool *taken,
                                 km_error *error) {
  bool tracked = other->ended == KM_OK || other->ended == KM_PARTIAL;
  *taken = tracked && is_better_track(&other->run, run);
  if (*taken)
    km_run_copy_track(run, &other->run);
  if (!tracked)
    return km_fail(error, other->ended, "%s", other->error.text);
  run->evaluations += other->run.evaluations + other->run.space.arm.evaluations;
  return *taken ? other->ended : status;
}

/* Repeats look-ahead with easing and takes the better track. */
static km_status try_eased(km_tracking_run *run, km_status status, km_error *error) {
  alternative eased = {.plan = *run->plan};
  bool taken;
  make_alternative(&eased, run, run_eased);
  status = adopt_if_better(run, status, &eased, &taken, error);
  free_alternative(&eased);
  return status;
}

/* Look-ahead; with easing if rates end it early; greedy's track if that is better. */
km_status km_method_lookahead(km_tracking_run *run, km_error *error) {
  const km_method *method = &run->plan->method;
  double nodes = 0.0;
  for (int l = 1; l <= method->levels; ++l)
    nodes += pow(method->branches, l);
  if (nodes > MAX_NODES)
    return km_fail(error, KM_USAGE, "%d branches over %d levels make %.3g nodes; expected at most %d", method->branches,
                   method->levels, nodes, MAX_NODES);
  const bool branches = run->arm->freedom > 0 && method->branches > 1;
  alternative greedy = {.plan = *run->plan};
  greedy.plan.progress = NULL;
  km_status status = run_lookahead(run, false, branches ? &greedy : NULL, error);
  if (status == KM_PARTIAL && branches && km_tracker_rated(run->arm))
    status = try_eased(run, status, error);
  if ((status == KM_OK || status == KM_PARTIAL) && branches) {
    if (!greedy.is_made)
      make_alternative(&greedy, run, km_method_greedy);
    status = adopt_if_better(run, status, &greedy, &run->greedy_instead, error);
  }
  free_alternative(&greedy);
  return status;
}
