/* Breadth-first growth of a look-ahead tree, in batches and on several threads (docs/theory.md 12.6).
 *
 * A node depends on its parent only, and results are stored by node, so the number of threads cannot change them. A
 * level begins after a barrier, unless each worker can continue with the children of its own nodes in the same
 * number of batches. The first level is too small to share or to fill a batch. Therefore the first level of the
 * next tree grows together with the second level of this one: speculatively for the branch executed last and, if
 * lanes are free, for the last different one. If another branch is executed, that level is grown again. */
#include "arm/methods/lookahead_tree.h"

#include <math.h>

/* Fewest batched steps of a level for which threads pay off. */
enum { THREADS_PAY = 16 };

/* Sets tan φ of each branch towards each pose-control column. One freedom: kφ, k = −(n−1)/2 … (n−1)/2. Two: 0 and a
 * circle of directions. More: 0, then ± along each column. */
static void set_branch_angles(km_look_tree *t) {
  const km_method *method = &t->run->plan->method;
  const int freedom = t->run->arm->freedom, n = t->branches;
  for (int b = 0; b < n && freedom > 0; ++b) {
    double *tan_phi = t->tan_phis + b * freedom;
    int k = b - (n - 1) / 2;
    if (freedom == 1) {
      tan_phi[0] = k == 0 ? 0.0 : tan(k * method->angle);
    } else if (k != 0) {
      int ring = b < (n - 1) / 2 ? b : b - 1; /* 0 … n − 2 */
      double around = 2.0 * M_PI * ring / (n - 1), size = tan(method->angle);
      if (freedom == 2) {
        tan_phi[0] = size * cos(around);
        tan_phi[1] = size * sin(around);
      } else {
        tan_phi[ring / 2 % freedom] = (ring % 2 ? -1.0 : 1.0) * size;
      }
    }
  }
}

/* Number of samples that a tree covers. */
static int depth_of(const km_look_tree *t, const km_look_root_level *of) {
  int left = t->run->plan->path->samples - 1 - of->sample;
  return left < t->levels * t->stride ? left : t->levels * t->stride;
}

/* State of a branch while it advances over a level; owned by one worker until the level ends. */
typedef struct branch_state {
  km_look_root_level *of; /* tree of the branch: the current or a speculative one */
  int level, index;
  int first_sample, steps; /* samples from the root to the start of the level; samples of the level */
  km_look_node node;
  km_path_node *here, *there; /* current node, and end of its next step */
} branch_state;

/* Initialises a branch with the end and the aggregates of its parent. */
static void inherit_parent(const km_look_tree *t, branch_state *w) {
  const km_look_node *parent = w->level > 0 ? km_look_node_at(t, w->of, w->level - 1, w->index / t->branches) : NULL;
  w->node = (km_look_node){
      .end = km_look_node_at(t, w->of, w->level, w->index)->end, .least = (double)INFINITY, .alive = true};
  if (parent) {
    w->node.least = parent->least;
    w->node.sum = parent->sum;
    w->node.samples = parent->samples;
    w->node.alive = parent->alive;
  }
  if (w->node.alive)
    km_path_node_copy(t->run->arm, w->here, parent ? &parent->end : &w->of->root);
}

/* Creates the branch state of item `item`: nodes of the level, followed by nodes of the first levels of the next
 * trees. */
static branch_state begin_branch(const km_look_tree *t, int level, int item, km_path_node *branch_nodes) {
  int behind = item - t->shares[level].count;
  bool own = behind < 0;
  branch_state w = {.of = own ? t->now : t->next[behind / t->branches],
                    .level = own ? level : 0,
                    .index = own ? item : behind % t->branches,
                    .here = &branch_nodes[0],
                    .there = &branch_nodes[1]};
  w.first_sample = w.level * t->stride;
  int left = depth_of(t, w.of) - w.first_sample;
  w.steps = left < t->stride ? left : t->stride;
  inherit_parent(t, &w);
  return w;
}

/* Records the outcome of step k of a branch. */
static void record_step(const km_look_tree *t, branch_state *w, int k, km_step_end step) {
  km_look_node *node = &w->node;
  km_path_node *end = w->there;
  bool first = w->first_sample + k == 0;
  node->evaluations += step.evaluations;
  if (first && w->index == (t->branches - 1) / 2)
    w->of->middle = step;
  if (step.stop) {
    node->alive = false;
    return;
  }
  if (first)
    km_path_node_copy(t->run->arm, &w->of->first[w->index], end);
  node->least = end->value < node->least ? end->value : node->least;
  node->sum += end->weight * end->value;
  node->samples++;
  w->there = w->here;
  w->here = end;
}

/* Advances all surviving branches by step k, as a batch. Returns their number. */
static int advance_branches(km_look_tree *t, int worker, int k, int count, branch_state *all) {
  km_tracking_run *run = t->run;
  km_tracker_space *space = &t->spaces[worker];
  const km_path_node *from[KM_STEP_BATCH];
  km_path_node *to[KM_STEP_BATCH];
  km_step_choice choices[KM_STEP_BATCH];
  km_step_end ends[KM_STEP_BATCH];
  int lane[KM_STEP_BATCH], samples[KM_STEP_BATCH], batch = 0;
  for (int l = 0; l < count; ++l) {
    const branch_state *w = &all[l];
    if (!w->node.alive || k >= w->steps)
      continue;
    lane[batch] = l;
    samples[batch] = w->of->sample + w->first_sample + k;
    from[batch] = w->here;
    to[batch] = w->there;
    choices[batch++] = (km_step_choice){.tan_phi = t->tan_phis + w->index % t->branches * run->arm->freedom};
  }
  if (batch > 0)
    km_tracker_steps(&run->tracker, space, samples, batch, from, choices, to, ends);
  for (int i = 0; i < batch && t->eased; ++i) {
    unsigned long before = space->arm.evaluations, taken = ends[i].evaluations;
    ends[i] = km_tracker_ease(&run->tracker, space, samples[i], from[i], &choices[i], ends[i], to[i]);
    ends[i].evaluations = taken + space->arm.evaluations - before;
  }
  for (int i = 0; i < batch; ++i)
    record_step(t, &all[lane[i]], k, ends[i]);
  return batch;
}

/* Stores a branch as a node. Jacobians of a speculative tree are counted only if that tree is used. */
static void store_branch(const km_look_tree *t, int worker, const branch_state *w) {
  km_look_node *node = km_look_node_at(t, w->of, w->level, w->index);
  *node = w->node;
  if (node->alive)
    km_path_node_copy(t->run->arm, &node->end, w->here);
  if (w->of != t->now)
    t->spaces[worker].arm.evaluations -= node->evaluations;
}

/* Number of items of a worker, if `count` items are distributed in shares of `each`. */
static int share_size(int count, int steps_per_radius, int worker) {
  int left = count - worker * steps_per_radius;
  return left < 0 ? 0 : left < steps_per_radius ? left : steps_per_radius;
}

/* Index of item k of a worker: its nodes of the level first, then those of the next trees. */
static int item_at(const km_look_share *s, int worker, int k) {
  int own = share_size(s->count, s->nodes_per_worker, worker);
  return k < own ? worker * s->nodes_per_worker + k : s->count + worker * s->next_each + k - own;
}

/* Advances up to KM_STEP_BATCH branches over a level, as a batch. */
static void grow_group(km_look_tree *t, int level, int worker, int first, int count) {
  branch_state all[KM_STEP_BATCH];
  km_path_node *branch_nodes = &t->branch_nodes[worker * 2 * KM_STEP_BATCH];
  for (int l = 0; l < count; ++l)
    all[l] = begin_branch(t, level, item_at(&t->shares[level], worker, first + l), &branch_nodes[2 * l]);
  for (int k = 0; k < t->stride && advance_branches(t, worker, k, count, all) > 0; ++k)
    ;
  for (int l = 0; l < count; ++l)
    store_branch(t, worker, &all[l]);
}

/* Part of a worker: its groups of every level of the present round. */
static void grow_share(void *context, int worker) {
  km_look_tree *t = context;
  for (int level = t->first; level < t->end; ++level) {
    const km_look_share *s = &t->shares[level];
    int count = share_size(s->count, s->nodes_per_worker, worker) + share_size(s->next_count, s->next_each, worker);
    for (int i = 0; i < count; i += s->group)
      grow_group(t, level, worker, i, count - i < s->group ? count - i : s->group);
  }
}

/* Quotient, rounded up. */
static int divide_up(int count, int by) {
  return (count + by - 1) / by;
}

/* Number of batches that hold `nodes` nodes. */
static int batch_count(int nodes) {
  return divide_up(nodes, KM_STEP_BATCH);
}

/* Assigns that many nodes of a level to each worker, in groups of equal size. Returns the number of batches of a
 * worker. */
static int assign_nodes(km_look_share *s, int nodes_per_worker) {
  s->nodes_per_worker = nodes_per_worker;
  s->next_each = divide_up(s->next_count, s->workers_used);
  int most = s->nodes_per_worker + s->next_each;
  s->group = divide_up(most, batch_count(most));
  return batch_count(most);
}

/* Distributes a level over the workers, together with the first levels of `guesses` speculative trees. A worker gets
 * neighbouring nodes, whose parents and children are mostly its own. Returns the number of batches of a worker. */
static int plan_level(km_look_tree *t, int level, int guesses) {
  km_look_share *s = &t->shares[level];
  *s = (km_look_share){.count = km_look_count_at(t, level), .next_count = guesses * t->branches};
  int groups = batch_count(s->count + s->next_count);
  bool worth = groups * t->stride >= THREADS_PAY;
  s->workers_used = !worth ? 1 : groups < t->workers ? groups : t->workers;
  return assign_nodes(s, divide_up(s->count, s->workers_used));
}

/* True if the workers can continue with the children of their own nodes without a barrier, in the same number of
 * batches. */
static bool try_plan_children(km_look_tree *t, int level) {
  const km_look_share *parents = &t->shares[level - 1];
  int groups = plan_level(t, level, 0);
  return parents->workers_used == t->shares[level].workers_used &&
         assign_nodes(&t->shares[level], parents->nodes_per_worker * t->branches) == groups;
}

/* Adds a speculative next tree whose root is the first sample of a branch, if that step succeeded. Returns the
 * number of speculative trees. */
static int add_guess(km_look_tree *t, int count, int branch) {
  const km_look_root_level *now = t->now;
  km_look_root_level *next = t->next[count];
  if (now->nodes[branch].samples == 0)
    return count;
  next->branch_guess = branch;
  next->sample = now->sample + 1;
  km_path_node_copy(t->run->arm, &next->root, &now->first[branch]);
  return count + 1;
}

/* Plans the second level: a speculative first level of the next tree is added if that takes no further batch or if
 * threads share the level, and a second one if no worker then has more batches. */
static void plan_second(km_look_tree *t) {
  const int alone = plan_level(t, 1, 0), beside = plan_level(t, 1, 1);
  int most = t->shares[1].workers_used == 1 && beside > alone   ? 0
             : t->branches > 1 && plan_level(t, 1, 2) == beside ? 2
                                                                : 1;
  t->guesses = most > 0 ? add_guess(t, 0, t->branch) : 0;
  t->guesses = most > t->guesses ? add_guess(t, t->guesses, t->other) : t->guesses;
  plan_level(t, 1, t->guesses);
}

/* Plans the levels from t->first on that grow without a barrier. Speculative trees need the complete first level. */
static void plan_round(km_look_tree *t, int levels) {
  if (t->first == 1)
    plan_second(t);
  else
    plan_level(t, t->first, 0);
  t->end = t->first + 1;
  while (t->end > 1 && t->end < levels && try_plan_children(t, t->end))
    t->end++;
}

/* Allocates root, first level and first samples of a tree. */
static km_look_root_level *create_root_level(km_look_tree *t) {
  const km_arm *a = t->run->arm;
  km_arena *arena = &t->run->arena;
  km_look_root_level *b = KM_ARENA_NEW(arena, km_look_root_level, 1);
  if (!b || !km_path_node_create(a, arena, &b->root))
    return NULL;
  b->nodes = KM_ARENA_NEW(arena, km_look_node, (size_t)t->branches);
  b->first = KM_ARENA_NEW(arena, km_path_node, (size_t)t->branches);
  for (int i = 0; i < t->branches && !arena->failed; ++i)
    if (!km_path_node_create(a, arena, &b->nodes[i].end) || !km_path_node_create(a, arena, &b->first[i]))
      return NULL;
  return b;
}

bool km_look_tree_create(km_look_tree *t, km_tracking_run *run) {
  const km_method *method = &run->plan->method;
  const km_arm *a = run->arm;
  *t = (km_look_tree){.run = run, .levels = method->levels, .workers = run->plan->jobs > 1 ? run->plan->jobs : 1};
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
  t->nodes = KM_ARENA_NEW(arena, km_look_node, (size_t)count);
  t->shares = KM_ARENA_NEW(arena, km_look_share, (size_t)t->levels);
  t->branch = (t->branches - 1) / 2;
  t->other = t->branches - 1;
  t->tan_phis = KM_ARENA_NEW(arena, double, (size_t)t->branches *(size_t)(a->freedom > 0 ? a->freedom : 1));
  t->spaces = KM_ARENA_NEW(arena, km_tracker_space, (size_t)t->workers);
  const int branch_nodes = t->workers * KM_STEP_BATCH * 2;
  t->branch_nodes = KM_ARENA_NEW(arena, km_path_node, (size_t)branch_nodes);
  t->now = create_root_level(t);
  bool is_ok = t->now && t->shares;
  for (int i = 0; i < KM_LOOK_GUESSES && is_ok; ++i)
    is_ok = (t->next[i] = create_root_level(t)) != NULL;
  for (long long i = 0; i < count && is_ok; ++i)
    is_ok = km_path_node_create(a, arena, &t->nodes[i].end);
  for (int i = 0; i < t->workers && is_ok; ++i)
    is_ok = km_tracker_space_create(a, &t->spaces[i]);
  for (int i = 0; i < branch_nodes && is_ok; ++i)
    is_ok = km_path_node_create(a, arena, &t->branch_nodes[i]);
  if (is_ok)
    set_branch_angles(t);
  return is_ok;
}

void km_look_tree_destroy(km_look_tree *t) {
  for (int i = 0; i < t->workers && t->spaces; ++i) {
    t->run->evaluations += t->spaces[i].arm.evaluations;
    km_tracker_space_free(&t->spaces[i]);
  }
}

/* Grows the tree round by round; a round contains the levels without a barrier between them. */
int km_look_tree_grow(km_look_tree *t) {
  int levels = (depth_of(t, t->now) + t->stride - 1) / t->stride;
  t->guesses = 0;
  for (t->first = t->is_grown ? 1 : 0; t->first < levels; t->first = t->end) {
    plan_round(t, levels);
    km_team_run(km_run_team(t->run), t->shares[t->first].workers_used, grow_share, t);
  }
  return levels;
}

/* Makes the speculative tree of a branch the current one; false if there is none. */
static bool adopt_guess(km_look_tree *t, int branch) {
  for (int g = 0; g < t->guesses; ++g) {
    if (t->next[g]->branch_guess != branch)
      continue;
    km_look_root_level *before = t->now;
    t->now = t->next[g];
    t->next[g] = before;
    for (int i = 0; i < t->branches; ++i)
      t->run->evaluations += t->now->nodes[i].evaluations;
    return true;
  }
  return false;
}

/* Moves the root by one sample along the executed branch, to a speculative tree if there is one. */
void km_look_tree_recede(km_look_tree *t, int branch) {
  t->other = branch == t->branch ? t->other : t->branch;
  t->branch = branch;
  t->is_grown = adopt_guess(t, branch);
  if (t->is_grown)
    return;
  km_path_node_copy(t->run->arm, &t->now->root, &t->now->first[branch]);
  t->now->sample++;
}
