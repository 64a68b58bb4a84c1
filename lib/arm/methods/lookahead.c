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

static km_status follow(km_look_tree *t, km_error *error) {
  static const km_step_choice plain = {0};
  km_run *run = t->run;
  const size_t n = (size_t)run->arm->n;
  km_tracker_begin(&run->walk, &run->space, 0, run->start, &plain, &t->now->root);
  memcpy(run->q, t->now->root.q, n * sizeof *run->q);
  for (run->reached = 1; run->reached < run->plan->path->samples; ++run->reached) {
    int branch = look_ahead(t);
    if (branch < 0) {
      km_run_stop(run, &t->now->root, &plain, t->now->middle);
      return KM_PARTIAL;
    }
    km_look_tree_go_on(t, branch);
    memcpy(run->q + (size_t)run->reached * n, t->now->root.q, n * sizeof *run->q);
    if (!km_run_goes_on(run, run->reached))
      return km_fail(error, KM_CANCELLED, "cancelled");
  }
  return KM_OK;
}

static km_status look(km_run *run, bool eased, km_error *error) {
  km_look_tree t;
  bool whole = km_look_tree_create(&t, run);
  t.eased = eased;
  km_status status = whole ? follow(&t, error) : km_fail(error, KM_MEMORY, "out of memory for a look-ahead tree");
  km_look_tree_destroy(&t);
  return status;
}

static km_status look_eased(km_run *run, km_error *error) {
  return look(run, true, error);
}

/* Two tracks of one plan, and what they are worth. */
typedef struct comparison {
  km_run *run[2];
  km_run_value value[2];
} comparison;

static void evaluate(void *context, int index) {
  comparison *c = context;
  c->value[index] = km_run_evaluate(c->run[index]);
}

/* Of two tracks the one that goes further wins, whatever the objective; where they are as good, look-ahead's. */
static bool beats(km_run *other, km_run *own) {
  comparison c = {.run = {own, other}};
  km_team_run(km_run_team(own), 2, evaluate, &c);
  if (other->reached != own->reached)
    return other->reached > own->reached;
  if (fabs(other->fraction - own->fraction) > 1e-6)
    return other->fraction > own->fraction;
  return compare(km_run_score(own, c.value[1]), km_run_score(own, c.value[0])) > 0;
}

/* Another method's track where it is better; `taken` tells. */
static km_status prefer(km_run *run, km_status status, km_method_run method, bool *taken, km_error *error) {
  km_run other;
  *taken = false;
  if (!km_run_create(run->arm, run->plan, &other))
    return km_fail(error, KM_MEMORY, "out of memory for a track");
  km_status ended = method(&other, error);
  bool tracked = ended == KM_OK || ended == KM_PARTIAL;
  if (tracked && beats(&other, run)) {
    km_run_take(run, &other);
    *taken = true;
  }
  run->evaluations += other.evaluations + other.space.arm.evaluations;
  km_run_free(&other);
  return !tracked || *taken ? ended : status;
}

km_status km_method_lookahead(km_run *run, km_error *error) {
  const km_method *method = &run->plan->method;
  double nodes = 0.0;
  for (int l = 1; l <= method->levels; ++l)
    nodes += pow(method->branches, l);
  if (nodes > MOST_NODES)
    return km_fail(error, KM_USAGE, "%d branches over %d levels make %.3g nodes; expected at most %d", method->branches,
                   method->levels, nodes, MOST_NODES);
  km_status status = look(run, false, error);
  bool branches = run->arm->freedom > 0 && method->branches > 1, eased;
  if (status == KM_PARTIAL && branches && km_tracker_rated(run->arm))
    status = prefer(run, status, look_eased, &eased, error);
  if ((status == KM_OK || status == KM_PARTIAL) && branches)
    status = prefer(run, status, km_method_greedy, &run->greedy_instead, error);
  return status;
}
