/* Selection of the states of dynamic programming: the best arrival of each neighbourhood (docs/theory.md 12.7). */
#include "arm/methods/dynamic_programming.h"

#include "arm/ik/ik_branches.h"

#include <stdlib.h>
#include <string.h>

/* Largest numbers of states: with one spare freedom the spacing grows above it; with several, only the best states
 * are kept. */
enum { MAX_STATES = 1000, MAX_STATES_SURFACE = 250 };
static bool by_mean(const km_dp_grid *g) {
  return km_objective_by_mean(&g->run->plan->objective);
}

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

/* True if two configurations are closer than the spacing, full turns of hinges without limits not counted. */
static bool is_near(const km_arm *a, const double *x, const double *y, double spacing) {
  double sum = 0.0;
  for (int k = 0; k < a->n && sum < spacing * spacing; ++k) {
    bool free_turns = a->low[k] == -(double)INFINITY && a->high[k] == (double)INFINITY;
    double difference = free_turns ? km_arm_difference(a, k, x[k], y[k]) : y[k] - x[k];
    sum += difference * difference;
  }
  return sum < spacing * spacing;
}

km_dp_state km_dp_make_state(km_dp_grid *g, int length) {
  km_dp_state s = {.q = KM_ARENA_NEW(&g->arena, double, (size_t)length *(size_t)g->run->arm->n)};
  km_path_node_create(g->run->arm, &g->arena, &s.node);
  return s;
}

static void copy_state(const km_dp_grid *g, km_dp_state *to, const km_dp_state *from, int length) {
  double *q = to->q;
  km_path_node node = to->node;
  memcpy(q, from->q, (size_t)length * (size_t)g->run->arm->n * sizeof *q);
  km_path_node_copy(g->run->arm, &node, &from->node);
  *to = *from;
  to->q = q;
  to->node = node;
}

/* Entry of the order of arrivals. */
typedef struct ranked {
  const km_dp_grid *grid;
  int index;
} ranked;

static int compare_ranked(const void *a, const void *b) {
  const ranked *x = a, *y = b;
  const km_dp_state *p = &x->grid->arrivals[x->index], *q = &y->grid->arrivals[y->index];
  if (km_dp_better(x->grid, p, q))
    return -1;
  return km_dp_better(x->grid, q, p) ? 1 : x->index - y->index;
}

/* Selects the arrivals that are the best of their neighbourhood, in the given order, into kept[most]: an arrival is
 * dropped if it is near one already kept. Returns their number, most + 1 if there are more. */
static int select_best(const km_dp_grid *g, const ranked *order, int arrived, double spacing, int most, int *kept) {
  const km_dp_stage *now = &g->stages[g->now];
  int full = now->first + now->length, count = 0;
  for (int i = 0; i < arrived; ++i) {
    const km_dp_state *one = &g->arrivals[order[i].index];
    bool taken = one->samples < full;
    for (int k = 0; k < count && !taken; ++k)
      taken = is_near(g->run->arm, g->arrivals[kept[k]].node.q, one->node.q, spacing);
    if (taken)
      continue;
    if (count == most)
      return most + 1;
    kept[count++] = order[i].index;
  }
  return count;
}

/* Keeps the best arrival of each neighbourhood. One spare freedom: the spacing is doubled until the number of states
 * is within its limit. Several: the best states up to the limit are kept. */
bool km_dp_keep_best(km_dp_grid *g, int arrived) {
  const bool spread = g->run->arm->freedom > 1;
  const int most = spread ? MAX_STATES_SURFACE : MAX_STATES;
  km_dp_stage *now = &g->stages[g->now];
  ranked *order = KM_NEW(ranked, (size_t)arrived + 1);
  int *kept = KM_NEW(int, (size_t)most + 1), count = 0;
  bool is_ok = order && kept;
  for (int i = 0; is_ok && i < arrived; ++i)
    order[i] = (ranked){g, i};
  if (is_ok) {
    qsort(order, (size_t)arrived, sizeof *order, compare_ranked);
    double spacing = g->spacing;
    while ((count = select_best(g, order, arrived, spacing, most, kept)) > most && !spread)
      spacing *= 2.0;
    g->bounded = g->bounded || spacing > g->spacing;
    g->bounded = g->bounded || count > most;
    count = count > most ? most : count;
    now->states = KM_ARENA_NEW(&g->arena, km_dp_state, (size_t)count + 1);
  }
  for (int i = 0; is_ok && !g->arena.failed && i < count; ++i) {
    now->states[i] = km_dp_make_state(g, now->length);
    if (!g->arena.failed)
      copy_state(g, &now->states[now->count++], &g->arrivals[kept[i]], now->length);
  }
  is_ok = is_ok && !g->arena.failed;
  km_free(order);
  km_free(kept);
  return is_ok;
}
