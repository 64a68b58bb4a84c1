/* Look-ahead: at every sample a tree of branches that turn the path-control column by kφ is grown over the horizon, the
 * first sample of the best leaf's branch is executed, and the horizon recedes (theory 6). Where that stops short under
 * rates, it is tried again with branches that turn back as far as the rates ask. */
#include "arm/methods/lookahead_tree.h"

#include <string.h>

enum { MOST_NODES = 2000000 };

/* The branch of level 1 that a node descends from, and φ of any level on the way, counted from the middle. */
static int branch_of(const km_look_tree *t, int level, int index, int at_level) {
  for (; level > at_level; --level)
    index /= t->branches;
  return index % t->branches;
}

/* Equal but for rounding: symmetric postures must not be told apart by their last digits. */
static int compare(double a, double b) {
  double slack = 1e-9 * fmax(fabs(a), fabs(b));
  return a > b + slack ? 1 : b > a + slack ? -1 : 0;
}

typedef struct choice {
  int level, index;
} choice;

/* Is a the better leaf? Value, then the other aggregate, then smaller |φ|, then −φ, level by level. */
static bool better(const km_look_tree *t, choice a, choice b) {
  const km_look_node *x = km_look_node_at(t, t->now, a.level, a.index),
                     *y = km_look_node_at(t, t->now, b.level, b.index);
  if (x->samples != y->samples)
    return x->samples > y->samples;
  bool sum = t->run->plan->method.sum;
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

/* The best leaf; where none survives, the branch that lasts longest. Level −1: nothing moves. */
static choice choose(const km_look_tree *t, int levels) {
  choice best = {-1, 0};
  for (int level = levels - 1; level >= 0; --level) { /* what died on the way competes by the samples it reached */
    int count = km_look_count_at(t, level);
    for (int i = 0; i < count; ++i) {
      const km_look_node *node = km_look_node_at(t, t->now, level, i);
      bool dead_end = !node->alive && node->samples > 0;
      choice one = {level, i};
      if ((level == levels - 1 && node->alive) || dead_end)
        best = best.level < 0 || better(t, one, best) ? one : best;
    }
  }
  return best;
}

/* Grows the tree at the run's last sample, and returns the branch to execute, -1: none. */
static int look_ahead(km_look_tree *t) {
  choice best = choose(t, km_look_tree_grow(t));
  return best.level < 0 ? -1 : branch_of(t, best.level, best.index, 0);
}

/* A track by another method, which look-ahead's is compared with. */
typedef struct alternative {
  km_track_plan plan;
  km_entry_range run;
  km_status ended; /* as the method does; KM_MEMORY also: there is no run */
  km_error error;
  bool made, holds; /* holds: a run that is to be freed */
} alternative;

static void make_alternative(alternative *r, const km_entry_range *own, km_method_run method) {
  r->made = true;
  r->holds = km_run_create(own->arm, &r->plan, &r->run);
  r->ended = r->holds ? method(&r->run, &r->error) : km_fail(&r->error, KM_MEMORY, "out of memory for a track");
}

static void free_alternative(alternative *r) {
  if (r->holds)
    km_run_free(&r->run);
}

/* Goes on up to a sample. */
static km_status go_on(km_look_tree *t, int until, bool tells, km_error *error) {
  km_entry_range *run = t->run;
  const size_t n = (size_t)run->arm->n;
  static const km_step_choice plain = {0};
  for (; run->reached < until; ++run->reached) {
    int branch = look_ahead(t);
    if (branch < 0) {
      km_run_stop(run, &t->now->root, &plain, t->now->middle);
      return KM_PARTIAL;
    }
    km_look_tree_go_on(t, branch);
    memcpy(run->q + (size_t)run->reached * n, t->now->root.q, n * sizeof *run->q);
    if (tells && !km_run_goes_on(run, run->reached))
      return km_fail(error, KM_CANCELLED, "cancelled");
  }
  return KM_OK;
}

/* The end of the way, where a tree has one level, too small to be shared; and greedy's track on a thread that is free. */
typedef struct ending {
  km_look_tree *tree;
  alternative *greedy;
  const void *caller; /* km_thread_mark: who called the library is told of the progress, and nobody else */
  km_status status;
  km_error *error;
} ending;

static void end_beside_greedy(void *context, int index) {
  ending *e = context;
  if (index == 1)
    make_alternative(e->greedy, e->tree->run, km_method_greedy);
  else
    e->status = go_on(e->tree, e->tree->run->plan->path->samples, km_thread_mark() == e->caller, e->error);
}

/* From the start to the end, or as far as it goes; `greedy` is made beside, unless it is NULL. */
static km_status follow(km_look_tree *t, alternative *greedy, km_error *error) {
  static const km_step_choice plain = {0};
  km_entry_range *run = t->run;
  const int samples = run->plan->path->samples, last = samples - t->stride;
  const bool beside = greedy && t->branches <= KM_WALK_ABREAST && last > 1;
  km_tracker_begin(&run->walk, &run->space, 0, run->start, &plain, &t->now->root);
  memcpy(run->q, t->now->root.q, (size_t)run->arm->n * sizeof *run->q);
  run->reached = 1;
  km_status status = go_on(t, beside ? last : samples, true, error);
  if (status || !beside)
    return status;
  ending e = {t, greedy, km_thread_mark(), KM_OK, error};
  km_team_run(km_run_team(run), 2, end_beside_greedy, &e);
  return e.status;
}

static km_status look(km_entry_range *run, bool eased, alternative *greedy, km_error *error) {
  km_look_tree t;
  bool whole = km_look_tree_create(&t, run);
  t.eased = eased;
  km_status status =
      whole ? follow(&t, greedy, error) : km_fail(error, KM_MEMORY, "out of memory for a look-ahead tree");
  km_look_tree_destroy(&t);
  return status;
}

static km_status look_eased(km_entry_range *run, km_error *error) {
  return look(run, true, NULL, error);
}

/* Two tracks of one plan, and what they are worth. */
typedef struct comparison {
  km_entry_range *run[2];
  km_run_value value[2];
} comparison;

static void evaluate(void *context, int index) {
  comparison *c = context;
  c->value[index] = km_run_evaluate(c->run[index]);
}

/* Of two tracks the one that goes further wins, whatever the objective; where they are as good, look-ahead's. */
static bool beats(km_entry_range *other, km_entry_range *own) {
  comparison c = {.run = {own, other}};
  km_team_run(km_run_team(own), 2, evaluate, &c);
  if (other->reached != own->reached)
    return other->reached > own->reached;
  if (fabs(other->fraction - own->fraction) > 1e-6)
    return other->fraction > own->fraction;
  return compare(km_run_score(own, c.value[1]), km_run_score(own, c.value[0])) > 0;
}

/* The other track where it is better; `taken` tells. */
static km_status prefer(km_entry_range *run, km_status status, alternative *other, bool *taken, km_error *error) {
  bool tracked = other->ended == KM_OK || other->ended == KM_PARTIAL;
  *taken = tracked && beats(&other->run, run);
  if (*taken)
    km_run_take(run, &other->run);
  if (!tracked)
    return km_fail(error, other->ended, "%s", other->error.text);
  run->evaluations += other->run.evaluations + other->run.space.arm.evaluations;
  return *taken ? other->ended : status;
}

/* Tried again with branches that turn back as far as the rates ask. */
static km_status prefer_eased(km_entry_range *run, km_status status, km_error *error) {
  alternative eased = {.plan = *run->plan};
  bool taken;
  make_alternative(&eased, run, look_eased);
  status = prefer(run, status, &eased, &taken, error);
  free_alternative(&eased);
  return status;
}

km_status km_method_lookahead(km_entry_range *run, km_error *error) {
  const km_method *method = &run->plan->method;
  double nodes = 0.0;
  for (int l = 1; l <= method->levels; ++l)
    nodes += pow(method->branches, l);
  if (nodes > MOST_NODES)
    return km_fail(error, KM_USAGE, "%d branches over %d levels make %.3g nodes; expected at most %d", method->branches,
                   method->levels, nodes, MOST_NODES);
  const bool branches = run->arm->freedom > 0 && method->branches > 1;
  alternative greedy = {.plan = *run->plan};
  greedy.plan.progress = NULL;
  km_status status = look(run, false, branches ? &greedy : NULL, error);
  if (status == KM_PARTIAL && branches && km_tracker_rated(run->arm))
    status = prefer_eased(run, status, error);
  if ((status == KM_OK || status == KM_PARTIAL) && branches) {
    if (!greedy.made)
      make_alternative(&greedy, run, km_method_greedy);
    status = prefer(run, status, &greedy, &run->greedy_instead, error);
  }
  free_alternative(&greedy);
  return status;
}
