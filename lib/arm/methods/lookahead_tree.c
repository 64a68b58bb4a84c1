/* Growing the trees of look-ahead.
 *
 * Nodes depend on the level above only, and each has a place of its own, so the result is the same for any number of threads.
 * Workers wait for each other before a level, unless each of them can go on with the children of its own nodes in the same
 * time. The first level is too small to be shared, or to fill the lanes. So the next tree's first level is grown beside this
 * tree's second one: once for the case that the same branch is taken again and, where lanes are left, once for the last
 * different one. If a third one is taken, the level is grown anew. */
#include "arm/methods/lookahead_tree.h"

#include <math.h>

/* Fewer steps abreast are done before a thread has begun. */
enum { THREADS_PAY = 16 };

/* tan φ towards each pose-control column. One freedom: kφ from −(n−1)/2 to (n−1)/2. Two: the middle and a circle of
 * directions. More: the middle, then both ways along each column. */
static void set_tilts(km_look_tree *t) {
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

/* How many samples a tree reaches. */
static int depth_of(const km_look_tree *t, const km_look_beginning *of) {
  int left = t->run->plan->path->samples - 1 - of->sample;
  return left < t->levels * t->stride ? left : t->levels * t->stride;
}

/* A branch on its way over a level: what changes with every step is the worker's own until the level ends. */
typedef struct traveller {
  km_look_beginning *of; /* its tree: this one, or the next */
  int level, index;
  int begins, steps; /* samples from the root to where its level begins, and samples of the level */
  km_look_node node;
  km_node *here, *there; /* where it is, and where its next step leads */
} traveller;

/* At its parent's end. */
static void begin_node(const km_look_tree *t, traveller *w) {
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
    km_node_copy(t->run->arm, w->here, parent ? &parent->end : &w->of->root);
}

/* A node of the level, or, behind its last one, of the next trees' first levels. */
static traveller set_out(const km_look_tree *t, int level, int item, km_node *places) {
  int behind = item - t->shares[level].count;
  bool own = behind < 0;
  traveller w = {.of = own ? t->now : t->next[behind / t->branches],
                 .level = own ? level : 0,
                 .index = own ? item : behind % t->branches,
                 .here = &places[0],
                 .there = &places[1]};
  w.begins = w.level * t->stride;
  int left = depth_of(t, w.of) - w.begins;
  w.steps = left < t->stride ? left : t->stride;
  begin_node(t, &w);
  return w;
}

/* Its k-th step has led there, or has failed. */
static void take_step(const km_look_tree *t, traveller *w, int k, km_step_end step) {
  km_look_node *node = &w->node;
  km_node *end = w->there;
  bool first = w->begins + k == 0;
  node->evaluations += step.evaluations;
  if (first && w->index == (t->branches - 1) / 2)
    w->of->middle = step;
  if (step.stop) {
    node->alive = false;
    return;
  }
  if (first)
    km_node_copy(t->run->arm, &w->of->first[w->index], end);
  node->least = end->value < node->least ? end->value : node->least;
  node->sum += end->value;
  node->samples++;
  w->there = w->here;
  w->here = end;
}

/* The k-th step of those that go on, side by side. How many these are. */
static int step_on(km_look_tree *t, int worker, int k, int count, traveller *all) {
  km_entry_range *run = t->run;
  km_tracker_space *space = &t->spaces[worker];
  const km_node *from[KM_WALK_ABREAST];
  km_node *to[KM_WALK_ABREAST];
  km_step_choice ways[KM_WALK_ABREAST];
  km_step_end ends[KM_WALK_ABREAST];
  int lane[KM_WALK_ABREAST], samples[KM_WALK_ABREAST], abreast = 0;
  for (int l = 0; l < count; ++l) {
    const traveller *w = &all[l];
    if (!w->node.alive || k >= w->steps)
      continue;
    lane[abreast] = l;
    samples[abreast] = w->of->sample + w->begins + k;
    from[abreast] = w->here;
    to[abreast] = w->there;
    ways[abreast++] = (km_step_choice){.tilt = t->tilts + w->index % t->branches * run->arm->freedom};
  }
  if (abreast > 0)
    km_tracker_steps(&run->walk, space, samples, abreast, from, ways, to, ends);
  for (int i = 0; i < abreast && t->eased; ++i) {
    unsigned long before = space->arm.evaluations, taken = ends[i].evaluations;
    ends[i] = km_tracker_ease(&run->walk, space, samples[i], from[i], &ways[i], ends[i], to[i]);
    ends[i].evaluations = taken + space->arm.evaluations - before;
  }
  for (int i = 0; i < abreast; ++i)
    take_step(t, &all[lane[i]], k, ends[i]);
  return abreast;
}

/* What the next tree's nodes take counts if that tree is grown. */
static void arrive(const km_look_tree *t, int worker, const traveller *w) {
  km_look_node *node = km_look_node_at(t, w->of, w->level, w->index);
  *node = w->node;
  if (node->alive)
    km_node_copy(t->run->arm, &node->end, w->here);
  if (w->of != t->now)
    t->spaces[worker].arm.evaluations -= node->evaluations;
}

/* Of `count` items, dealt out in pieces of `each`: how many the worker has. */
static int piece_of(int count, int each, int worker) {
  int left = count - worker * each;
  return left < 0 ? 0 : left < each ? left : each;
}

/* The k-th item of a worker: its nodes of the level first, then those of the next trees. */
static int item_of(const km_look_share *s, int worker, int k) {
  int own = piece_of(s->count, s->nodes_each, worker);
  return k < own ? worker * s->nodes_each + k : s->count + worker * s->ahead_each + k - own;
}

/* Follows up to KM_WALK_ABREAST branches over a level, side by side, each as far as it goes. */
static void grow(km_look_tree *t, int level, int worker, int first, int count) {
  traveller all[KM_WALK_ABREAST];
  km_node *places = &t->places[worker * 2 * KM_WALK_ABREAST];
  for (int l = 0; l < count; ++l)
    all[l] = set_out(t, level, item_of(&t->shares[level], worker, first + l), &places[2 * l]);
  for (int k = 0; k < t->stride && step_on(t, worker, k, count, all) > 0; ++k)
    ;
  for (int l = 0; l < count; ++l)
    arrive(t, worker, &all[l]);
}

static void grow_some(void *context, int worker) {
  km_look_tree *t = context;
  for (int level = t->first; level < t->end; ++level) {
    const km_look_share *s = &t->shares[level];
    int count = piece_of(s->count, s->nodes_each, worker) + piece_of(s->ahead, s->ahead_each, worker);
    for (int i = 0; i < count; i += s->group)
      grow(t, level, worker, i, count - i < s->group ? count - i : s->group);
  }
}

/* Rounded up. */
static int divided(int count, int by) {
  return (count + by - 1) / by;
}

/* How many groups side by side so many nodes make. */
static int groups_of(int nodes) {
  return divided(nodes, KM_WALK_ABREAST);
}

/* Of a level, so many nodes for each worker. How many groups a worker grows one after the other. */
static int deal(km_look_share *s, int nodes_each) {
  s->nodes_each = nodes_each;
  s->ahead_each = divided(s->ahead, s->sharing);
  int most = s->nodes_each + s->ahead_each;
  s->group = divided(most, groups_of(most));
  return groups_of(most);
}

/* Neighbours for each worker, since their parents and children are its own mostly; abreast in groups of one size; and so many of the
 * next trees' first levels beside them. Returns how many groups a worker grows one after the other. */
static int share_level(km_look_tree *t, int level, int guesses) {
  km_look_share *s = &t->shares[level];
  *s = (km_look_share){.count = km_look_count_at(t, level), .ahead = guesses * t->branches};
  int groups = groups_of(s->count + s->ahead);
  bool worth = groups * t->stride >= THREADS_PAY;
  s->sharing = !worth ? 1 : groups < t->workers ? groups : t->workers;
  return deal(s, divided(s->count, s->sharing));
}

/* Can workers go on from the level before with the children of their own nodes, in as many groups as if they waited for the others? */
static bool share_children(km_look_tree *t, int level) {
  const km_look_share *parents = &t->shares[level - 1];
  int groups = share_level(t, level, 0);
  return parents->sharing == t->shares[level].sharing &&
         deal(&t->shares[level], parents->nodes_each * t->branches) == groups;
}

/* The next tree begins with this branch, if that has a first step. Returns how many guesses there are now. */
static int guess(km_look_tree *t, int count, int branch) {
  const km_look_beginning *now = t->now;
  km_look_beginning *next = t->next[count];
  if (now->nodes[branch].samples == 0)
    return count;
  next->guess = branch;
  next->sample = now->sample + 1;
  km_node_copy(t->run->arm, &next->root, &now->first[branch]);
  return count + 1;
}

/* Beside the second level goes the next tree's first one, where lanes are free for it or several threads share the level; and a
 * second guess where no worker has more groups to grow then. */
static void plan_second(km_look_tree *t) {
  const int alone = share_level(t, 1, 0), beside = share_level(t, 1, 1);
  int most = t->shares[1].sharing == 1 && beside > alone         ? 0
             : t->branches > 1 && share_level(t, 1, 2) == beside ? 2
                                                                 : 1;
  t->guesses = most > 0 ? guess(t, 0, t->branch) : 0;
  t->guesses = most > t->guesses ? guess(t, t->guesses, t->other) : t->guesses;
  share_level(t, 1, t->guesses);
}

/* The levels from t->first on that are grown without waiting: the guesses need the whole first one. */
static void plan_round(km_look_tree *t, int levels) {
  if (t->first == 1)
    plan_second(t);
  else
    share_level(t, t->first, 0);
  t->end = t->first + 1;
  while (t->end > 1 && t->end < levels && share_children(t, t->end))
    t->end++;
}

static km_look_beginning *create_beginning(km_look_tree *t) {
  const km_arm *a = t->run->arm;
  km_arena *arena = &t->run->arena;
  km_look_beginning *b = KM_ARENA_NEW(arena, km_look_beginning, 1);
  if (!b || !km_node_create(a, arena, &b->root))
    return NULL;
  b->nodes = KM_ARENA_NEW(arena, km_look_node, (size_t)t->branches);
  b->first = KM_ARENA_NEW(arena, km_node, (size_t)t->branches);
  for (int i = 0; i < t->branches && !arena->failed; ++i)
    if (!km_node_create(a, arena, &b->nodes[i].end) || !km_node_create(a, arena, &b->first[i]))
      return NULL;
  return b;
}

bool km_look_tree_create(km_look_tree *t, km_entry_range *run) {
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
  t->tilts = KM_ARENA_NEW(arena, double, (size_t)t->branches *(size_t)(a->freedom > 0 ? a->freedom : 1));
  t->spaces = KM_ARENA_NEW(arena, km_tracker_space, (size_t)t->workers);
  const int places = t->workers * KM_WALK_ABREAST * 2;
  t->places = KM_ARENA_NEW(arena, km_node, (size_t)places);
  t->now = create_beginning(t);
  bool whole = t->now && t->shares;
  for (int i = 0; i < KM_LOOK_GUESSES && whole; ++i)
    whole = (t->next[i] = create_beginning(t)) != NULL;
  for (long long i = 0; i < count && whole; ++i)
    whole = km_node_create(a, arena, &t->nodes[i].end);
  for (int i = 0; i < t->workers && whole; ++i)
    whole = km_tracker_space_create(a, &t->spaces[i]);
  for (int i = 0; i < places && whole; ++i)
    whole = km_node_create(a, arena, &t->places[i]);
  if (whole)
    set_tilts(t);
  return whole;
}

void km_look_tree_destroy(km_look_tree *t) {
  for (int i = 0; i < t->workers && t->spaces; ++i) {
    t->run->evaluations += t->spaces[i].arm.evaluations;
    km_tracker_space_free(&t->spaces[i]);
  }
}

int km_look_tree_grow(km_look_tree *t) {
  int levels = (depth_of(t, t->now) + t->stride - 1) / t->stride;
  t->guesses = 0;
  for (t->first = t->grown ? 1 : 0; t->first < levels; t->first = t->end) {
    plan_round(t, levels);
    km_team_run(km_run_team(t->run), t->shares[t->first].sharing, grow_some, t);
  }
  return levels;
}

/* The tree that was begun with this branch becomes this one. False where there is none. */
static bool take_guess(km_look_tree *t, int branch) {
  for (int g = 0; g < t->guesses; ++g) {
    if (t->next[g]->guess != branch)
      continue;
    km_look_beginning *before = t->now;
    t->now = t->next[g];
    t->next[g] = before;
    for (int i = 0; i < t->branches; ++i)
      t->run->evaluations += t->now->nodes[i].evaluations;
    return true;
  }
  return false;
}

void km_look_tree_go_on(km_look_tree *t, int branch) {
  t->other = branch == t->branch ? t->other : t->branch;
  t->branch = branch;
  t->grown = take_guess(t, branch);
  if (t->grown)
    return;
  km_node_copy(t->run->arm, &t->now->root, &t->now->first[branch]);
  t->now->sample++;
}
