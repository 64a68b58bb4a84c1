/* All solutions over one value of the parameters, by monodromy on a graph (monodromy.h). */
#include "space/complex/monodromy.h"

#include <string.h>

/* Functionals of one solution differ by less than this between two ways to it, relative to 1 + |y|. */
static const double same_solution = 1e-7;
static const long max_evaluations = 4000000; /* work of one search; the largest published case takes a tenth of it */
enum { MOST_OWN_EDGES = 3 }; /* edges of a node with given parameters; solutions that these miss are beside a pole */
static const double retry_factor = 0.1; /* lost paths: factor of the corrections that a step may have */

int km_fibre_find(const km_monodromy *g, const km_fibre *fibre, const km_wide *x) {
  km_complex mark[KM_FINGERPRINT];
  km_complex_fingerprint(g->h->closure, x, mark);
  for (int i = 0; i < fibre->count; ++i) {
    const km_complex *known = fibre->marks + (size_t)i * KM_FINGERPRINT;
    bool is_same = true;
    for (int k = 0; k < KM_FINGERPRINT && is_same; ++k)
      is_same = cabs(known[k] - mark[k]) <= same_solution * (1.0 + cabs(mark[k]));
    if (is_same && g->h->has_section) {
      km_wide s = x[g->h->closure->length];
      is_same = cabsl(fibre->points[(size_t)i * (size_t)g->h->length + (size_t)g->h->closure->length] - s) <=
                same_solution * (1.0L + cabsl(s));
    }
    if (is_same)
      return i;
  }
  return -1;
}

int km_fibre_add(km_monodromy *g, km_fibre *fibre, const km_wide *x) {
  int found = km_fibre_find(g, fibre, x), length = g->h->length;
  if (found >= 0)
    return found;
  void *points = fibre->points, *marks = fibre->marks;
  size_t count = (size_t)fibre->count;
  bool is_ok = km_reserve(&points, &fibre->point_capacity, (count + 1) * (size_t)length, sizeof(km_wide));
  fibre->points = points;
  is_ok = is_ok && km_reserve(&marks, &fibre->mark_capacity, (count + 1) * KM_FINGERPRINT, sizeof(km_complex));
  fibre->marks = marks;
  if (!is_ok) {
    g->failed = true;
    return -1;
  }
  memcpy(fibre->points + count * (size_t)length, x, (size_t)length * sizeof *x);
  km_complex_fingerprint(g->h->closure, x, fibre->marks + count * KM_FINGERPRINT);
  return fibre->count++;
}

/* Extends the partners of an edge to the solutions of its nodes. */
static bool extend_edge(km_monodromy *g, km_fibre_edge *edge) {
  for (int end = 0; end < 2; ++end) {
    int count = g->node[edge->node[end]].count;
    void *partner = edge->partner[end];
    g->failed = g->failed || !km_reserve(&partner, &edge->capacity[end], (size_t)count, sizeof(int));
    edge->partner[end] = partner;
    while (!g->failed && edge->length[end] < count)
      edge->partner[end][edge->length[end]++] = KM_UNTRACKED;
  }
  return !g->failed;
}

km_path_outcome km_monodromy_track(km_monodromy *g, const km_complex *from, const km_complex *to, km_wide *x) {
  size_t bytes = (size_t)g->h->length * sizeof(km_wide);
  km_wide *start = KM_NEW(km_wide, (size_t)g->h->length);
  g->failed = g->failed || !start;
  if (!start)
    return KM_PATH_SINGULAR;
  memcpy(start, x, bytes);
  ++g->paths;
  km_path_outcome outcome = km_homotopy_track(g->h, from, to, x);
  if (outcome == KM_PATH_SINGULAR) {
    memcpy(x, start, bytes);
    g->h->step_factor = retry_factor;
    outcome = km_homotopy_track(g->h, from, to, x);
    g->h->step_factor = 1.0;
  }
  km_free(start);
  return outcome;
}

/* Tracks solution i of one end of an edge. An arrival that has another partner already shows that one of both paths
 * changed to a neighbouring one; then both stay without a partner. */
static void track(km_monodromy *g, km_fibre_edge *edge, int end, int i) {
  km_fibre *from = &g->node[edge->node[end]], *to = &g->node[edge->node[1 - end]];
  size_t bytes = (size_t)g->h->length * sizeof(km_wide);
  km_wide *x = KM_NEW(km_wide, (size_t)g->h->length);
  g->failed = g->failed || !x;
  if (!x)
    return;
  memcpy(x, from->points + (size_t)i * (size_t)g->h->length, bytes);
  km_path_outcome outcome = km_monodromy_track(g, from->parameters, to->parameters, x);
  edge->partner[end][i] = KM_UNTRACKABLE;
  if (outcome == KM_PATH_ARRIVED) {
    int found = km_fibre_add(g, to, x);
    if (found >= 0 && extend_edge(g, edge)) {
      int *back = &edge->partner[1 - end][found];
      if (*back >= 0) {
        edge->partner[end][*back] = KM_UNTRACKABLE;
        *back = KM_UNTRACKABLE;
      } else {
        edge->partner[end][i] = found;
        *back = i;
      }
    }
  }
  km_free(x);
}

/* Reports the work as a share of its limit. */
static bool continues(km_monodromy *g) {
  double done = (double)g->h->evaluations / (double)max_evaluations;
  g->cancelled = g->cancelled || (g->progress && !g->progress(g->context, done));
  g->is_exhausted = g->is_exhausted || g->h->evaluations > max_evaluations || g->node[0].count > g->limit;
  return !g->failed && !g->cancelled && !g->is_exhausted;
}

/* Tracks all solutions along all edges until none is left. */
static bool saturate(km_monodromy *g) {
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (int e = 0; e < g->edge_count; ++e) {
      km_fibre_edge *edge = &g->edge[e];
      if (!extend_edge(g, edge))
        return false;
      for (int end = 0; end < 2; ++end)
        for (int i = 0; i < edge->length[end]; ++i)
          if (edge->partner[end][i] == KM_UNTRACKED) {
            is_new = true;
            track(g, edge, end, i);
            if (!continues(g))
              return false;
          }
    }
  }
  return true;
}

/* Adds a node and its edges. */
static bool add_node(km_monodromy *g) {
  int k = g->node_count++;
  km_fibre *node = &g->node[k];
  if (!node->parameters)
    node->parameters = KM_NEW(km_complex, (size_t)g->h->parameter_count);
  g->failed = g->failed || !node->parameters;
  if (!g->failed && k > 0)
    km_homotopy_draw(g->h, g->random, node->parameters);
  for (int back = 1; back <= KM_NODE_EDGES && back <= k; ++back)
    g->edge[g->edge_count++] = (km_fibre_edge){.node = {k - back, k}};
  return !g->failed;
}

bool km_monodromy_extend(km_monodromy *g, int nodes) {
  for (int i = 0; i < nodes; ++i)
    if (g->node_count >= KM_MAX_NODES || !add_node(g))
      return false;
  return saturate(g);
}

int km_monodromy_add(km_monodromy *g, const km_complex *parameters) {
  int k = g->node_count, before = k - 1;
  size_t bytes = (size_t)g->h->parameter_count * sizeof *parameters;
  if (k >= KM_MAX_NODES)
    return -1;
  km_fibre *node = &g->node[k];
  node->parameters = KM_NEW(km_complex, (size_t)g->h->parameter_count);
  g->failed = g->failed || !node->parameters;
  if (g->failed)
    return -1;
  ++g->node_count;
  memcpy(node->parameters, parameters, bytes);
  g->edge[g->edge_count++] = (km_fibre_edge){.node = {0, k}};
  bool is_ok = saturate(g);
  for (int i = 1; is_ok && i < MOST_OWN_EDGES && before > 0 && node->count < g->node[0].count; ++i, --before) {
    g->edge[g->edge_count++] = (km_fibre_edge){.node = {before, k}};
    is_ok = saturate(g);
  }
  return is_ok ? k : -1;
}

int km_monodromy_partner(const km_monodromy *g, int i, int node) {
  for (int e = 0; e < g->edge_count; ++e) {
    const km_fibre_edge *edge = &g->edge[e];
    for (int end = 0; end < 2; ++end)
      if (edge->node[end] == 0 && edge->node[1 - end] == node && i < edge->length[end])
        return edge->partner[end][i];
  }
  return -1;
}

void km_monodromy_choose_first(km_monodromy *g) {
  int best = 0;
  for (int k = 1; k < g->node_count; ++k)
    if (g->node[k].count > g->node[best].count)
      best = k;
  km_fibre first = g->node[0];
  g->node[0] = g->node[best];
  g->node[best] = first;
  for (int e = 0; e < g->edge_count && best > 0; ++e)
    for (int end = 0; end < 2; ++end) {
      int *node = &g->edge[e].node[end];
      *node = *node == 0 ? best : *node == best ? 0 : *node;
    }
}

bool km_monodromy_search(km_monodromy *g, int quiet) {
  for (int without_news = 0; without_news < quiet;) {
    int before = g->node[0].count;
    if (!km_monodromy_extend(g, g->node_count == 0 ? 3 : 1))
      return false;
    without_news = g->node[0].count > before ? 0 : without_news + 1;
  }
  return true;
}

void km_monodromy_free(km_monodromy *g) {
  for (int i = 0; i < KM_MAX_NODES; ++i) {
    km_free(g->node[i].parameters);
    km_free(g->node[i].points);
    km_free(g->node[i].marks);
    g->node[i] = (km_fibre){0};
  }
  for (int e = 0; e < g->edge_count; ++e) {
    km_free(g->edge[e].partner[0]);
    km_free(g->edge[e].partner[1]);
  }
  g->node_count = g->edge_count = 0;
}
