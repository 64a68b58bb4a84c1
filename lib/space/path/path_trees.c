/* Two trees of configurations (space/path/path_trees.h). */
#include "space/path/path_trees.h"

#include "base/random.h"

#include <string.h>

enum { SHORTENINGS = 200 };
static const double least_progress = 0.3; /* part of a step: less ends a chain of steps */
static const double slide_room = 1.0;     /* half range of random slides without limits, beyond both ends: sizes */

void km_path_trees_free(km_path_trees *g) {
  for (int side = 0; side < 2; ++side) {
    km_free(g->tree[side].saved);
    km_free(g->tree[side].parent);
  }
}

int km_path_trees_add(km_path_trees *g, km_path_tree *t, int parent) {
  void *saved = t->saved, *parents = t->parent;
  size_t wanted = (size_t)t->count + 1;
  double *place = KM_ARENA_NEW(g->arena, double, g->steps->f.saved_size);
  bool is_ok = place && km_reserve(&saved, &t->saved_capacity, wanted, sizeof *t->saved);
  t->saved = saved;
  is_ok = is_ok && km_reserve(&parents, &t->parent_capacity, wanted, sizeof *t->parent);
  t->parent = parents;
  if (!is_ok) {
    g->arena->failed = true;
    return -1;
  }
  km_driver_surface_save(&g->steps->f, place);
  t->saved[t->count] = place;
  t->parent[t->count] = parent;
  return t->count++;
}

/* Moves the state to the node of a tree that is nearest to a saved configuration. Returns its index. */
static int move_to_nearest(km_path_trees *g, const km_path_tree *t, const double *saved) {
  int nearest = 0;
  double least = HUGE_VAL;
  km_driver_surface_restore(&g->steps->f, saved);
  for (int i = 0; i < t->count; ++i) {
    double distance = km_path_steps_difference(g->steps, t->saved[i]);
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  km_path_steps_move_to(g->steps, t->saved[nearest]);
  return nearest;
}

int km_path_trees_chain(km_path_trees *g, km_path_tree *t, int from, const double *saved, int most, bool *is_there) {
  *is_there = false;
  for (int i = 0; i < most; ++i) {
    double before = km_path_steps_difference(g->steps, saved);
    *is_there = before <= KM_EQUAL_PATH_CONFIGURATIONS;
    if (*is_there || !km_path_steps_towards(g->steps, before))
      return from;
    double after = km_path_steps_difference(g->steps, saved);
    *is_there = after <= KM_EQUAL_PATH_CONFIGURATIONS;
    if (!*is_there && before - after < least_progress * fmin(KM_LONGEST_PATH_STEP, before))
      return from;
    from = km_path_trees_add(g, t, from);
    if (from < 0 || *is_there)
      return from;
  }
  return from;
}

void km_path_trees_sample(km_path_trees *g) {
  km_driver_surface *f = &g->steps->f;
  double *towards = g->steps->towards;
  km_driver_surface_restore(f, g->tree[0].saved[0]);
  if (g->tree[1].count > 0)
    km_path_steps_difference(g->steps, g->tree[1].saved[0]);
  else
    memset(towards, 0, (size_t)f->columns * sizeof *towards);
  for (int k = 0; k < f->columns; ++k) {
    int c = km_driver_surface_coordinate(f, k);
    double u = km_uniform(&g->random), low, high, unit = f->m->factor[c] / f->m->unit[c];
    bool is_limited = km_model_coordinate_limits(f->m->model, c, &low, &high) && isfinite(low) && isfinite(high);
    double here = f->s->q[c] / f->m->unit[c];
    if (is_limited && !g->steps->def->ignore_limits)
      f->step[k] = unit * (0.5 * (low + high) + 0.5 * u * (high - low)) - here;
    else if (km_coordinate_turns(f->m, c) || f->m->ball_of[c] >= 0)
      f->step[k] = M_PI * u;
    else
      f->step[k] = 0.5 * towards[k] + u * (slide_room + 0.5 * fabs(towards[k]));
  }
  km_driver_surface_move(f, f->step);
  km_driver_surface_save(f, g->sample);
}

bool km_path_trees_grow(km_path_trees *g, km_progress progress, void *context, bool *is_cancelled, int node[2]) {
  int most = g->steps->def->most > 0 ? g->steps->def->most : KM_DEFAULT_PATH_CONFIGURATIONS;
  node[0] = node[1] = -1;
  for (int side = 0, tries = 0; g->tree[0].count + g->tree[1].count < most && tries < most; side = 1 - side, ++tries) {
    bool is_there;
    km_path_tree *a = &g->tree[side], *b = &g->tree[1 - side];
    km_path_trees_sample(g);
    int reached = km_path_trees_chain(g, a, move_to_nearest(g, a, g->sample), g->sample, KM_MOST_PATH_CHAIN, &is_there);
    if (reached < 0)
      return false;
    const double *target = a->saved[reached];
    int met = km_path_trees_chain(g, b, move_to_nearest(g, b, target), target, KM_MOST_PATH_CHAIN, &is_there);
    if (met < 0)
      return false;
    if (is_there) {
      node[side] = reached;
      node[1 - side] = met;
      return true;
    }
    *is_cancelled = progress && !progress(context, fmax(a->count + b->count, tries) / most);
    if (*is_cancelled)
      return true;
  }
  return true;
}

double **km_path_trees_join(km_path_trees *g, const int node[2], int *count) {
  int lengths[2] = {0, 0};
  for (int side = 0; side < 2; ++side)
    for (int i = node[side]; i >= 0; i = g->tree[side].parent[i])
      ++lengths[side];
  *count = lengths[0] + lengths[1];
  double **path = KM_ARENA_NEW(g->arena, double *, (size_t)*count);
  if (!path)
    return NULL;
  int at = lengths[0];
  for (int i = node[0]; i >= 0; i = g->tree[0].parent[i])
    path[--at] = g->tree[0].saved[i];
  at = lengths[0];
  for (int i = node[1]; i >= 0; i = g->tree[1].parent[i])
    path[at++] = g->tree[1].saved[i];
  return path;
}

/* Replaces the part from path[i] to path[j] by the steps straight from one to the other, if they are fewer. Returns the
 * new count; −1 when out of memory. */
static int shorten(km_path_trees *g, double **path, int count, int i, int j) {
  km_path_tree part = {0};
  bool is_there;
  km_path_steps_move_to(g->steps, path[i]);
  int last = km_path_trees_chain(g, &part, -1, path[j], j - i - 1, &is_there);
  int added = part.count - 1; /* the last one is path[j] */
  bool is_shorter = is_there && last >= 0 && added < j - i - 1;
  if (is_shorter) {
    for (int k = 0; k < added; ++k)
      path[i + 1 + k] = part.saved[k];
    memmove(path + i + 1 + added, path + j, (size_t)(count - j) * sizeof *path);
  }
  km_free(part.saved);
  km_free(part.parent);
  return g->arena->failed ? -1 : is_shorter ? count - (j - i - 1 - added) : count;
}

int km_path_trees_shorten(km_path_trees *g, double **path, int count) {
  for (int k = 0; k < SHORTENINGS && count > 2; ++k) {
    int i = (int)((0.5 + 0.5 * km_uniform(&g->random)) * (count - 1)),
        j = (int)((0.5 + 0.5 * km_uniform(&g->random)) * count);
    int low = i < j ? i : j, high = i < j ? j : i;
    if (high - low > 1)
      count = shorten(g, path, count, low, high);
    if (count < 0)
      return -1;
  }
  return count;
}
