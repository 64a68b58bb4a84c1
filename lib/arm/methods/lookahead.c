/* Look-ahead: at every sample a tree of branches that turn the path-control column by kφ is grown over the horizon, the
 * first sample of the best leaf's branch is executed, and the horizon recedes (theory 6). Where that stops short under
 * rates, it is tried again with branches that turn back as far as the rates ask.
 *
 * A level is one batch of work: its nodes depend on the level above only, and each has a place of its own, so the
 * result is the same for any number of threads. The first level is too small to be shared. So several threads grow the next
 * tree's first level beside this tree's second one, from the root that is taken if the branch stays the same; where another
 * branch is taken it is grown again. */
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

/* The root of a tree, and what depends on nothing else. */
typedef struct beginning {
  km_node root;
  tree_node *nodes;   /* [branches] the first level */
  km_node *first;     /* [branches] one sample after the root */
  km_step_end middle; /* how the untilted branch ended, if on its first step */
  int sample;         /* of the root */
} beginning;

typedef struct tree {
  km_run *run;
  int branches, levels, stride, workers;
  tree_node *nodes; /* by level, behind the first one; the children of node i of a level are i · branches … */
  int *level_start; /* [levels + 1] from the second level on */
  double *tilts;    /* [branches × freedom] */
  km_team *team;
  km_tracker_space *spaces; /* [workers] */
  km_node *places;          /* [workers × KM_WALK_ABREAST × 2] */
  beginning *now, *next;    /* of this tree, and of that after it */
  int level, level_count;
  int sharing, share, group; /* of this level: workers, their nodes, and those that are grown abreast */
  bool eased;                /* branches turn back as far as the rates ask */
  int branch;                /* executed last */
  int guess;                 /* `next` is grown from the end of this branch's first step; -1: it isn't grown */
  bool grown;                /* the first level of `now` was `next` */
  int ahead;                 /* the worker that grows `next` beside this level; -1: none */
  unsigned long guessed;     /* Jacobians that this took */
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

static tree_node *node_at(const tree *t, const beginning *of, int level, int index) {
  return level == 0 ? &of->nodes[index] : &t->nodes[t->level_start[level] + index];
}

static int count_at(const tree *t, int level) {
  return level == 0 ? t->branches : t->level_start[level + 1] - t->level_start[level];
}

/* How many samples a tree reaches. */
static int depth_of(const tree *t, const beginning *of) {
  int left = t->run->plan->path->samples - 1 - of->sample;
  return left < t->levels * t->stride ? left : t->levels * t->stride;
}

/* A node of a level, at its parent's end. */
static tree_node begin_node(const tree *t, const beginning *of, int level, int index, km_node *here) {
  const tree_node *parent = level > 0 ? node_at(t, of, level - 1, index / t->branches) : NULL;
  tree_node node = {.end = node_at(t, of, level, index)->end, .least = (double)INFINITY, .alive = true};
  if (parent) {
    node.least = parent->least;
    node.sum = parent->sum;
    node.samples = parent->samples;
    node.alive = parent->alive;
  }
  if (node.alive)
    km_node_copy(t->run->arm, here, parent ? &parent->end : &of->root);
  return node;
}

/* A branch on its way over a level: what changes with every step is the worker's own until the level ends. */
typedef struct traveller {
  tree_node node;
  km_node *here, *there; /* where it is, and where its next step leads */
} traveller;

/* A step of sample k has led there, or has failed. */
static void take_step(const tree *t, beginning *of, int index, int k, traveller *w, km_step_end step) {
  tree_node *node = &w->node;
  km_node *end = w->there;
  if (k == 0 && index == (t->branches - 1) / 2)
    of->middle = step;
  if (step.stop) {
    node->alive = false;
    return;
  }
  if (k == 0)
    km_node_copy(t->run->arm, &of->first[index], end);
  node->least = end->value < node->least ? end->value : node->least;
  node->sum += end->value;
  node->samples++;
  w->there = w->here;
  w->here = end;
}

/* The next step of those that go on, side by side. How many these are. */
static int step_on(tree *t, beginning *of, int worker, int k, int first, int count, traveller *all) {
  km_run *run = t->run;
  km_tracker_space *space = &t->spaces[worker];
  const km_node *from[KM_WALK_ABREAST];
  km_node *to[KM_WALK_ABREAST];
  km_step_choice ways[KM_WALK_ABREAST];
  km_step_end ends[KM_WALK_ABREAST];
  int lane[KM_WALK_ABREAST], abreast = 0, sample = of->sample + k;
  for (int l = 0; l < count; ++l) {
    if (!all[l].node.alive)
      continue;
    lane[abreast] = l;
    from[abreast] = all[l].here;
    to[abreast] = all[l].there;
    ways[abreast++] = (km_step_choice){.tilt = t->tilts + (first + l) % t->branches * run->arm->freedom};
  }
  if (abreast > 0)
    km_tracker_steps(&run->walk, space, sample, abreast, from, ways, to, ends);
  for (int i = 0; i < abreast && t->eased; ++i)
    ends[i] = km_tracker_ease(&run->walk, space, sample, from[i], &ways[i], ends[i], to[i]);
  for (int i = 0; i < abreast; ++i)
    take_step(t, of, first + lane[i], k, &all[lane[i]], ends[i]);
  return abreast;
}

/* Follows up to KM_WALK_ABREAST branches over one level, side by side, each as far as it goes. */
static void grow(tree *t, beginning *of, int level, int worker, int first, int count) {
  traveller all[KM_WALK_ABREAST];
  km_node *places = &t->places[worker * 2 * KM_WALK_ABREAST];
  int done = level * t->stride, depth = depth_of(t, of), end = done + t->stride < depth ? done + t->stride : depth;
  for (int l = 0; l < count; ++l) {
    all[l] = (traveller){.here = &places[2 * l], .there = &places[2 * l + 1]};
    all[l].node = begin_node(t, of, level, first + l, all[l].here);
  }
  for (int k = done; k < end && step_on(t, of, worker, k, first, count, all) > 0; ++k)
    ;
  for (int l = 0; l < count; ++l) {
    tree_node *node = node_at(t, of, level, first + l);
    *node = all[l].node;
    if (node->alive)
      km_node_copy(t->run->arm, &node->end, all[l].here);
  }
}

/* The next tree's first level. What it takes counts if that tree is grown. */
static void grow_ahead(tree *t, int worker) {
  unsigned long *evaluations = &t->spaces[worker].arm.evaluations, before = *evaluations;
  for (int i = 0; i < t->branches; i += KM_WALK_ABREAST)
    grow(t, t->next, 0, worker, i, t->branches - i < KM_WALK_ABREAST ? t->branches - i : KM_WALK_ABREAST);
  t->guessed = *evaluations - before;
  *evaluations = before;
}

static void grow_some(void *context, int worker) {
  tree *t = context;
  int end = (worker + 1) * t->share < t->level_count ? (worker + 1) * t->share : t->level_count;
  for (int i = worker * t->share; i < end; i += t->group)
    grow(t, t->now, t->level, worker, i, end - i < t->group ? end - i : t->group);
  if (worker == t->ahead)
    grow_ahead(t, worker);
}

/* Neighbours for each worker, since their parents and children are its own mostly; abreast in groups of one size. `more` nodes
 * are the last worker's beside these. */
static void share_level(tree *t, int more) {
  t->level_count = count_at(t, t->level);
  int all = t->level_count + more, groups = (all + KM_WALK_ABREAST - 1) / KM_WALK_ABREAST;
  bool worth = groups * t->stride >= THREADS_PAY;
  t->sharing = !worth ? 1 : groups < t->workers ? groups : t->workers;
  t->share = (all + t->sharing - 1) / t->sharing;
  groups = (t->share + KM_WALK_ABREAST - 1) / KM_WALK_ABREAST;
  t->group = (t->share + groups - 1) / groups;
}

/* Beside the second level, which is a small one too, goes the next tree's first one, where several share it. */
static void plan_level(tree *t) {
  const beginning *now = t->now;
  bool guess = t->workers > 1 && t->level == 1 && now->nodes[t->branch].samples > 0;
  share_level(t, guess ? t->branches : 0);
  t->ahead = guess && t->sharing > 1 ? t->sharing - 1 : -1;
  if (t->ahead < 0)
    return;
  t->guess = t->branch;
  t->next->sample = now->sample + 1;
  km_node_copy(t->run->arm, &t->next->root, &now->first[t->guess]);
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
  const tree_node *x = node_at(t, t->now, a.level, a.index), *y = node_at(t, t->now, b.level, b.index);
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
    int count = count_at(t, level);
    for (int i = 0; i < count; ++i) {
      const tree_node *node = node_at(t, t->now, level, i);
      bool dead_end = !node->alive && node->samples > 0;
      choice one = {level, i};
      if ((level == levels - 1 && node->alive) || dead_end)
        best = best.level < 0 || better(t, one, best) ? one : best;
    }
  }
  return best;
}

static beginning *create_beginning(tree *t) {
  const km_arm *a = t->run->arm;
  km_arena *arena = &t->run->arena;
  beginning *b = KM_ARENA_NEW(arena, beginning, 1);
  if (!b || !km_node_create(a, arena, &b->root))
    return NULL;
  b->nodes = KM_ARENA_NEW(arena, tree_node, (size_t)t->branches);
  b->first = KM_ARENA_NEW(arena, km_node, (size_t)t->branches);
  for (int i = 0; i < t->branches && !arena->failed; ++i)
    if (!km_node_create(a, arena, &b->nodes[i].end) || !km_node_create(a, arena, &b->first[i]))
      return NULL;
  return b;
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
  long long count = 0, level = t->branches;
  for (int l = 1; l < t->levels; ++l) {
    level *= t->branches;
    count += level;
    t->level_start[l + 1] = (int)count;
  }
  t->nodes = KM_ARENA_NEW(arena, tree_node, (size_t)count);
  t->branch = (t->branches - 1) / 2;
  t->tilts = KM_ARENA_NEW(arena, double, (size_t)t->branches *(size_t)(a->freedom > 0 ? a->freedom : 1));
  t->spaces = KM_ARENA_NEW(arena, km_tracker_space, (size_t)t->workers);
  const int places = t->workers * KM_WALK_ABREAST * 2;
  t->places = KM_ARENA_NEW(arena, km_node, (size_t)places);
  t->now = create_beginning(t);
  t->next = create_beginning(t);
  bool whole = t->now && t->next && !arena->failed;
  for (long long i = 0; i < count && whole; ++i)
    whole = km_node_create(a, arena, &t->nodes[i].end);
  for (int i = 0; i < t->workers && whole; ++i)
    whole = km_tracker_space_create(a, &t->spaces[i]);
  for (int i = 0; i < places && whole; ++i)
    whole = km_node_create(a, arena, &t->places[i]);
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
  int levels = (depth_of(t, t->now) + t->stride - 1) / t->stride;
  t->guess = -1;
  for (t->level = t->grown ? 1 : 0; t->level < levels; ++t->level) {
    plan_level(t);
    km_team_run(t->team, t->sharing, grow_some, t);
  }
  choice best = choose(t, levels);
  return best.level < 0 ? -1 : branch_of(t, best.level, best.index, 0);
}

/* The branch's first sample is the next tree's root. */
static void go_on(tree *t, int branch) {
  t->branch = branch;
  t->grown = t->guess == branch;
  if (t->grown) {
    beginning *before = t->now;
    t->now = t->next;
    t->next = before;
    t->run->evaluations += t->guessed;
    return;
  }
  km_node_copy(t->run->arm, &t->now->root, &t->now->first[branch]);
  t->now->sample++;
}

static km_status follow(tree *t, km_error *error) {
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
    go_on(t, branch);
    memcpy(run->q + (size_t)run->reached * n, t->now->root.q, n * sizeof *run->q);
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
