/* Links in a square, hinged to others near them. */
#include "support/random_graph.h"

#include "base/random.h"
#include "support/hinges.h"

#include <stdlib.h>

enum { MOST_JOINTS = 3 };

/* A link, and those that it is joined to. */
typedef struct member {
  int joints, others[MOST_JOINTS];
} member;

typedef struct graph {
  hinges h;
  member *links;
  int count, width, reach;
  uint64_t seed;
} graph;

/* Any of low … high. */
static int any(graph *g, int low, int high) {
  return low + (int)((high - low + 1) * (0.5 + 0.5 * km_uniform(&g->seed)));
}

static bool is_free(const graph *g, int link, int other) {
  bool free = g->links[link].joints < MOST_JOINTS && link != other;
  for (int i = 0; i < g->links[link].joints; ++i)
    free = free && g->links[link].others[i] != other;
  return free;
}

/* A link near another one that can be joined to it, among the first `count`; -1: a few tries have found none. */
static int find_near(graph *g, int link, int count) {
  for (int i = 0; i < 40; ++i) {
    int row = link / g->width + any(g, -g->reach, g->reach), column = link % g->width + any(g, -g->reach, g->reach);
    int found = row * g->width + column;
    if (row >= 0 && column >= 0 && column < g->width && found < count && is_free(g, found, link))
      return found;
  }
  return -1;
}

/* Between their places, and some way beside. */
static void join(graph *g, int a, int b) {
  double x = 0.5 * (a % g->width + b % g->width), y = 0.5 * (double)(a / g->width + b / g->width);
  double aside = km_uniform(&g->seed);
  hinges_pin(&g->h, 1 + a, 1 + b, x + 0.5 * aside, y + 0.5 * km_uniform(&g->seed));
  g->links[a].others[g->links[a].joints++] = b;
  g->links[b].others[g->links[b].joints++] = a;
}

/* Joins the link to a previous one, if possible a near one. */
static void plant(graph *g, int link) {
  int before = find_near(g, link, link);
  for (int i = link - 1; before < 0; --i)
    before = is_free(g, i, link) ? i : -1;
  join(g, before, link);
}

void write_random_graph(km_text *out, int n, int reach) {
  int count = n + n + n / 2;
  graph g = {.links = calloc((size_t)count, sizeof *g.links),
             .count = count,
             .width = (int)ceil(sqrt(count)),
             .reach = reach,
             .seed = 1};
  if (!g.links)
    abort();
  hinges_pin(&g.h, 0, 1, -0.3, -0.6);
  hinges_pin(&g.h, 0, 1, -0.3, -0.6);
  for (int link = 1; link < count; ++link)
    plant(&g, link);
  for (int i = 0; i < n;) {
    int first = any(&g, 0, count - 1), second = is_free(&g, first, -1) ? find_near(&g, first, count) : -1;
    if (second < 0)
      continue;
    join(&g, first, second);
    ++i;
  }
  free(g.links);
  hinges_write(&g.h, out, 0.0);
}
