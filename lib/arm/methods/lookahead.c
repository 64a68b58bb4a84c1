/* Look-ahead: at every sample a tree of branches that turn the path-control column by kφ is grown over the horizon, the
 * first sample of the best leaf's branch is executed, and the horizon recedes (theory 6). Where that stops short under
 * rates, it is tried again with branches that turn back as far as the rates ask.
 *
 * A level is one batch of work: its nodes depend on the level above only, and each has a place of its own, so the
 * result is the same for any number of threads. */
#include "arm/methods/method.h"
#include "base/parallel.h"

#include <string.h>

enum { MOST_NODES = 2000000, THREADS_PAY = 16 }; /* fewer steps abreast are done before a thread has begun */

typedef struct tree_node {
  km_node end;       /* where its level ends */
  double least, sum; /* of the objective, from the root (excluded) */
  int samples;       /* reached since the root */
  bool alive;
} tree_node;

typedef struct tree {
  km_run *run;
  int branches, levels, stride, workers;
  tree_node *nodes; /* by level, level 1 first; the children of node i of a level are i · branches … */
  int *level_start; /* [levels + 1] */
  km_node *first;   /* [branches] one sample after the root */
  double *tilts;    /* [branches × freedom] */
  km_team *team;
  km_tracker_space *spaces; /* [workers] */
  km_node *here;            /* [workers × KM_WALK_ABREAST] */
  km_node root;
  km_step_end middle; /* how the untilted branch ended, if on its first step */
  int sample, level, level_count, depth;
  int sharing, group; /* of this level: workers, and nodes that are grown abreast */
  bool eased;         /* branches turn back as far as the rates ask */
} tree;

/* tan φ towards each pose-control column. One freedom: kφ from −(n−1)/2 to (n−1)/2. Two: the middle and a circle of
 * directions. More: the middle, then both ways along each column. */
static void set_tilts(tree *t) {
  const km_method *method = &t->run->plan->method;
  const int freedom = t->run->arm->freedom, n = t->branches;
  for (int b = 0; b < n && freedom > 0; ++b) {
    double *tilt = t->tilts + b * freedom;
    int k = b - (n - 1) / 2;
    if (freedom == 1) {
      tilt[0] = k == 0 ? 0.0 : tan(k * method->angle);
    } else if (k != 0) {
      int ring = b < (n - 1) / 2 ? b : b - 1; /* 0 … n − 2 */
      double around = 2.0 * M_PI * ring / (n - 1), size = tan(method->angle);
      if (freedom == 2) {
        tilt[0] = size * cos(around);
        tilt[1] = size * sin(around);
      } else {
        tilt[ring / 2 % freedom] = (ring % 2 ? -1.0 : 1.0) * size;
      }
    }
  }
}

static tree_node *node_at(const tree *t, int level, int index) {
  return &t->nodes[t->level_start[level] + index];
}

/* A node of the level being grown, at its parent's end. */
static tree_node *begin_node(tree *t, int index, km_node *here) {
  tree_node *node = node_at(t, t->level, index);
  const tree_node *parent = t->level > 0 ? node_at(t, t->level - 1, index / t->branches) : NULL;
  node->least = parent ? parent->least : (double)INFINITY;
  node->sum = parent ? parent->sum : 0.0;
  node->samples = parent ? parent->samples : 0;
  node->alive = !parent || parent->alive;
  if (node->alive)
    km_node_copy(t->run->arm, here, parent ? &parent->end : &t->root);
  return node;
}

/* A step of sample k has led to node->end, or has failed. */
static void take_step(tree *t, int index, int k, tree_node *node, km_step_end step, km_node *here) {
  if (k == 0 && index == (t->branches - 1) / 2)
    t->middle = step;
  if (step.stop) {
    node->alive = false;
    return;
  }
  if (k == 0)
    km_node_copy(t->run->arm, &t->first[index], &node->end);
  node->least = node->end.value < node->least ? node->end.value : node->least;
  node->sum += node->end.value;
  node->samples++;
  km_node_copy(t->run->arm, here, &node->end);
}

/* Follows up to KM_WALK_ABREAST branches over one level, side by side, each as far as it goes. */
static void grow(tree *t, int worker, int first, int count) {
  km_run *run = t->run;
  tree_node *node[KM_WALK_ABREAST];
  km_node *here = &t->here[worker * KM_WALK_ABREAST];
  int done = t->level * t->stride, end = done + t->stride < t->depth ? done + t->stride : t->depth;
  for (int l = 0; l < count; ++l)
    node[l] = begin_node(t, first + l, &here[l]);
  for (int k = done; k < end; ++k) {
    const km_node *from[KM_WALK_ABREAST];
    km_node *to[KM_WALK_ABREAST];
    km_step_choice ways[KM_WALK_ABREAST];
    km_step_end ends[KM_WALK_ABREAST];
    int lane[KM_WALK_ABREAST], abreast = 0;
    for (int l = 0; l < count; ++l) {
      if (!node[l]->alive)
        continue;
      lane[abreast] = l;
      from[abreast] = &here[l];
      to[abreast] = &node[l]->end;
      ways[abreast++] = (km_step_choice){.tilt = t->tilts + (first + l) % t->branches * run->arm->freedom};
    }
    if (abreast == 0)
      return;
    km_tracker_steps(&run->walk, &t->spaces[worker], t->sample + k, abreast, from, ways, to, ends);
    for (int i = 0; i < abreast && t->eased; ++i)
      ends[i] = km_tracker_ease(&run->walk, &t->spaces[worker], t->sample + k, from[i], &ways[i], ends[i], to[i]);
    for (int i = 0; i < abreast; ++i)
      take_step(t, first + lane[i], k, node[lane[i]], ends[i], &here[lane[i]]);
  }
}

static void grow_some(void *context, int worker) {
  tree *t = context;
  for (int i = worker * t->group; i < t->level_count; i += t->sharing * t->group)
    grow(t, worker, i, t->level_count - i < t->group ? t->level_count - i : t->group);
}

/* Groups of one size for each worker, as few as lanes allow. */
static void share_level(tree *t) {
  int groups = (t->level_count + KM_WALK_ABREAST - 1) / KM_WALK_ABREAST;
  bool worth = groups * t->stride >= THREADS_PAY;
  t->sharing = !worth ? 1 : groups < t->workers ? groups : t->workers;
  groups = (groups + t->sharing - 1) / t->sharing * t->sharing;
  t->group = (t->level_count + groups - 1) / groups;
}

/* The branch of level 1 that a node descends from, and φ of any level on the way, counted from the middle. */
static int branch_of(const tree *t, int level, int index, int at_level) {
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
static bool better(const tree *t, choice a, choice b) {
  const tree_node *x = node_at(t, a.level, a.index), *y = node_at(t, b.level, b.index);
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
static choice choose(const tree *t, int levels) {
  choice best = {-1, 0};
  for (int level = levels - 1; level >= 0; --level) { /* what died on the way competes by the samples it reached */
    int count = t->level_start[level + 1] - t->level_start[level];
    for (int i = 0; i < count; ++i) {
      const tree_node *node = node_at(t, level, i);
      bool dead_end = !node->alive && node->samples > 0;
      choice one = {level, i};
      if ((level == levels - 1 && node->alive) || dead_end)
        best = best.level < 0 || better(t, one, best) ? one : best;
    }
  }
  return best;
}

static bool create(tree *t, km_run *run) {
  const km_method *method = &run->plan->method;
  const km_arm *a = run->arm;
  *t = (tree){.run = run, .levels = method->levels, .workers = run->plan->jobs > 1 ? run->plan->jobs : 1};
  t->branches = a->freedom > 0 ? method->branches : 1;
  int samples = run->plan->path->samples;
  t->stride = method->stride > 0 ? method->stride : samples / 12 > 1 ? samples / 12 : 1;
  km_arena *arena = &run->arena;
  t->level_start = KM_ARENA_NEW(arena, int, (size_t)t->levels + 1);
  if (!t->level_start)
    return false;
  long long count = 0, level = 1;
  for (int l = 0; l < t->levels; ++l) {
    level *= t->branches;
    count += level;
    t->level_start[l + 1] = (int)count;
  }
  t->nodes = KM_ARENA_NEW(arena, tree_node, (size_t)count);
  t->first = KM_ARENA_NEW(arena, km_node, (size_t)t->branches);
  t->tilts = KM_ARENA_NEW(arena, double, (size_t)t->branches *(size_t)(a->freedom > 0 ? a->freedom : 1));
  t->spaces = KM_ARENA_NEW(arena, km_tracker_space, (size_t)t->workers);
  t->here = KM_ARENA_NEW(arena, km_node, (size_t)t->workers * KM_WALK_ABREAST);
  bool whole = !arena->failed && km_node_create(a, arena, &t->root);
  for (long long i = 0; i < count && whole; ++i)
    whole = km_node_create(a, arena, &t->nodes[i].end);
  for (int i = 0; i < t->branches && whole; ++i)
    whole = km_node_create(a, arena, &t->first[i]);
  for (int i = 0; i < t->workers && whole; ++i)
    whole = km_tracker_space_create(a, &t->spaces[i]);
  for (int i = 0; i < t->workers * KM_WALK_ABREAST && whole; ++i)
    whole = km_node_create(a, arena, &t->here[i]);
  if (whole)
    set_tilts(t);
  t->team = t->workers > 1 ? km_team_create(t->workers) : NULL;
  return whole;
}

static void destroy(tree *t) {
  km_team_free(t->team);
  for (int i = 0; i < t->workers && t->spaces; ++i) {
    t->run->evaluations += t->spaces[i].arm.evaluations;
    km_tracker_space_free(&t->spaces[i]);
  }
}

/* Grows the tree at the run's last sample, and returns the branch to execute, -1: none. */
static int look_ahead(tree *t) {
  km_run *run = t->run;
  t->sample = run->reached - 1;
  int left = run->plan->path->samples - run->reached;
  t->depth = left < t->levels * t->stride ? left : t->levels * t->stride;
  int levels = (t->depth + t->stride - 1) / t->stride;
  t->middle = (km_step_end){KM_TRACK_COMPLETE, -1, 0.0};
  for (t->level = 0; t->level < levels; ++t->level) {
    t->level_count = t->level_start[t->level + 1] - t->level_start[t->level];
    share_level(t);
    km_team_run(t->team, t->sharing, grow_some, t);
  }
  choice best = choose(t, levels);
  return best.level < 0 ? -1 : branch_of(t, best.level, best.index, 0);
}

static km_status follow(tree *t, km_error *error) {
  static const km_step_choice plain = {0};
  km_run *run = t->run;
  const size_t n = (size_t)run->arm->n;
  km_tracker_begin(&run->walk, &run->space, 0, run->start, &plain, &t->root);
  memcpy(run->q, t->root.q, n * sizeof *run->q);
  for (run->reached = 1; run->reached < run->plan->path->samples; ++run->reached) {
    int branch = look_ahead(t);
    if (branch < 0) {
      km_run_stop(run, &t->root, &plain, t->middle);
      return KM_PARTIAL;
    }
    km_node_copy(run->arm, &t->root, &t->first[branch]);
    memcpy(run->q + (size_t)run->reached * n, t->root.q, n * sizeof *run->q);
    if (!km_run_goes_on(run, run->reached))
      return km_fail(error, KM_CANCELLED, "cancelled");
  }
  return KM_OK;
}

static km_status look(km_run *run, bool eased, km_error *error) {
  tree t;
  bool whole = create(&t, run);
  t.eased = eased;
  km_status status = whole ? follow(&t, error) : km_fail(error, KM_MEMORY, "out of memory for a look-ahead tree");
  destroy(&t);
  return status;
}

static km_status look_eased(km_run *run, km_error *error) {
  return look(run, true, error);
}

/* Of two tracks the one that goes further wins, whatever the objective; where they are as good, look-ahead's. */
static bool beats(const km_run *other, km_run_value theirs, const km_run *own, km_run_value ours) {
  if (other->reached != own->reached)
    return other->reached > own->reached;
  if (fabs(other->fraction - own->fraction) > 1e-6)
    return other->fraction > own->fraction;
  return compare(km_run_score(own, theirs), km_run_score(own, ours)) > 0;
}

/* Another method's track where it is better; `taken` tells. */
static km_status prefer(km_run *run, km_status status, km_method_run method, bool *taken, km_error *error) {
  km_run other;
  *taken = false;
  if (!km_run_create(run->arm, run->plan, &other))
    return km_fail(error, KM_MEMORY, "out of memory for a track");
  km_status ended = method(&other, error);
  bool tracked = ended == KM_OK || ended == KM_PARTIAL;
  if (tracked && beats(&other, km_run_evaluate(&other), run, km_run_evaluate(run))) {
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
