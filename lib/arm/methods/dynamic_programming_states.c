/* Which of dynamic programming's states go on: the best of each neighbourhood. */
#include "arm/methods/dynamic_programming.h"

#include "arm/ik/ik_branches.h"

#include <stdlib.h>
#include <string.h>

/* States on curves, which lie wider where there would be more; on surfaces and more, where there is no end of them. */
enum { MOST_STATES = 1000, MOST_SPREAD = 250 };
static bool by_mean(const km_dp_grid *g) {
  return km_objective_by_mean(&g->run->plan->objective);
}

/* Better first: further, then the value, then the other aggregate; else the order of the work. */
bool km_dp_better(const km_dp_grid *g, const km_dp_state *a, const km_dp_state *b) {
  if (a->samples != b->samples)
    return a->samples > b->samples;
  const double x[2] = {km_run_rounded(a->least), km_run_rounded(a->sum)};
  const double y[2] = {km_run_rounded(b->least), km_run_rounded(b->sum)};
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

km_dp_state km_dp_make_state(km_dp_grid *g, int length) {
  km_dp_state s = {.q = KM_ARENA_NEW(&g->arena, double, (size_t)length *(size_t)g->run->arm->n)};
  km_node_create(g->run->arm, &g->arena, &s.node);
  return s;
}

static void copy_state(const km_dp_grid *g, km_dp_state *to, const km_dp_state *from, int length) {
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
  const km_dp_grid *grid;
  int index;
} ranked;

static int by_rank(const void *a, const void *b) {
  const ranked *x = a, *y = b;
  const km_dp_state *p = &x->grid->arrivals[x->index], *q = &y->grid->arrivals[y->index];
  if (km_dp_better(x->grid, p, q))
    return -1;
  return km_dp_better(x->grid, q, p) ? 1 : x->index - y->index;
}

/* Of the arrivals in order, those that are the best of their neighbourhood, into kept[most]. Their number; one more
 * than `most` if there are more. */
static int choose_best(const km_dp_grid *g, const ranked *order, int arrived, double spacing, int most, int *kept) {
  const km_dp_stage *now = &g->stages[g->now];
  int full = now->first + now->length, count = 0;
  for (int i = 0; i < arrived; ++i) {
    const km_dp_state *one = &g->arrivals[order[i].index];
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
bool km_dp_keep_best(km_dp_grid *g, int arrived) {
  const bool spread = g->run->arm->freedom > 1;
  const int most = spread ? MOST_SPREAD : MOST_STATES;
  km_dp_stage *now = &g->stages[g->now];
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
    g->bounded = g->bounded || count > most;
    count = count > most ? most : count;
    now->states = KM_ARENA_NEW(&g->arena, km_dp_state, (size_t)count + 1);
  }
  for (int i = 0; whole && !g->arena.failed && i < count; ++i) {
    now->states[i] = km_dp_make_state(g, now->length);
    if (!g->arena.failed)
      copy_state(g, &now->states[now->count++], &g->arrivals[kept[i]], now->length);
  }
  whole = whole && !g->arena.failed;
  km_free(order);
  km_free(kept);
  return whole;
}
