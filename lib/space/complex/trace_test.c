/* All solutions over a generic value of the errors, with the trace test (trace_test.h). */
#include "space/complex/trace_test.h"

#include <string.h>

/* Relative difference of the fingerprints of one mode. */
static const double same_mode_tolerance = 1e-7;

/* Second difference of a sum, relative to the sum of sizes, that rounding explains: 1e-15, beside poles up to 2e-10. */
static const double trace_tolerance = 5e-10;
/* Share of the least second difference of a known point. Values below ε occur at about c N ε² of N points, so that an
 * unknown one is below a tenth of their least one with the probability 0.01 / N. */
static const double largest_share = 0.1;
static const double trace_reach = 2.8; /* change of τ over the size of y: the larger, the more a missing point shows */
static const double largest_news = 0.04; /* share of new points in the last node for which a test is worthwhile */
static const double least_reach = 1.0;   /* least change, if paths are lost with more */
enum {
  TRIALS = 12,
  DIRECTIONS = 6,
  SECTIONS = 10,
  FEW_SOLUTIONS = 8,
  QUIET_NODES_OF_FEW = 4,
  SECTION_NODES = 3,
  CLOSINGS = 3,
  SAMPLES_PER_SOLUTION = 3,
  LEAST_SAMPLES = 30
};

typedef struct search_state {
  km_fibre_search *out;
  km_monodromy section;
  km_complex_closure *closure;
  const km_wide *centre;
  km_complex *known; /* [section parameters] of the section at τ = 0 whose points with s = s_0 are the known solutions:
                      * p + s_0 v and P are those of the search */
  km_wide *x;        /* [section length] workspace */
  km_complex *end;   /* [section parameters] workspace */
} search_state;

/* Point i of a fibre, copied to the workspace. */
static km_wide *point_of(const search_state *w, const km_monodromy *g, int i) {
  memcpy(w->x, g->node[0].points + (size_t)i * (size_t)g->h->length, (size_t)g->h->length * sizeof *w->x);
  return w->x;
}

/* Adds the known solutions to node 0 of the section. */
static void begin_section(search_state *w, int first) {
  km_monodromy *g = &w->out->graph, *section = &w->section;
  const km_complex *P = section->node[0].parameters;
  for (int i = first; i < g->node[0].count && !section->failed; ++i) {
    km_wide *x = point_of(w, g, i);
    x[g->h->length] = w->known[section->h->section_start];
    if (km_monodromy_track(section, w->known, P, x) == KM_PATH_ARRIVED)
      km_fibre_add(section, &section->node[0], x);
  }
}

/* Draws the parameters of node 0 of a section. */
static void place_section(search_state *w, uint64_t *random) {
  const km_homotopy *h = w->section.h;
  km_complex *P = w->section.node[0].parameters;
  size_t bytes = (size_t)h->parameter_count * sizeof *P;
  km_homotopy_draw(h, random, P);
  memcpy(P, w->out->graph.node[0].parameters, (size_t)h->section_start * sizeof *P);
  for (int i = 0; i < h->section_start; ++i)
    P[i] -= P[h->section_start] * h->direction[i];
  memcpy(w->known, P, bytes);
  w->known[h->section_start + 2] = 0.0;
}

/* (y, s) of point i of a node. */
static void point_traces(const search_state *w, const km_fibre *fibre, int i, km_complex trace[2]) {
  const km_homotopy *h = w->section.h;
  const km_wide *x = fibre->points + (size_t)i * (size_t)h->length;
  trace[0] = km_complex_trace(h->closure, x);
  trace[1] = (km_complex)x[h->closure->length];
}

/* Sums of y and s over all points of a node. */
static void add_traces(const search_state *w, const km_fibre *fibre, km_complex sum[2], double *size) {
  sum[0] = sum[1] = 0.0;
  for (int i = 0; i < fibre->count; ++i) {
    km_complex trace[2];
    point_traces(w, fibre, i, trace);
    for (int j = 0; j < 2; ++j) {
      sum[j] += trace[j];
      *size += cabs(trace[j]);
    }
  }
}

/* Largest second difference of y and s. */
static double second_difference(km_complex traces[3][2]) {
  double largest = 0.0;
  for (int j = 0; j < 2; ++j)
    largest = fmax(largest, cabs(traces[0][j] - 2.0 * traces[1][j] + traces[2][j]));
  return largest;
}

/* Least second difference of a point that has partners along the edges from node 0: what remains of a sum that lacks
 * it. */
static double least_difference(const search_state *w, const int node[3]) {
  const km_monodromy *g = &w->section;
  double least = HUGE_VAL;
  for (int i = 0; i < g->node[0].count; ++i) {
    const int at[3] = {i, km_monodromy_partner(g, i, node[1]), km_monodromy_partner(g, i, node[2])};
    km_complex traces[3][2];
    for (int k = 0; k < 3 && at[1] >= 0 && at[2] >= 0; ++k)
      point_traces(w, &g->node[node[k]], at[k], traces[k]);
    if (at[1] >= 0 && at[2] >= 0)
      least = fmin(least, second_difference(traces));
  }
  return least;
}

/* Adds a node of the section. Returns its index; −1: it hasn't all points. */
static int add_section_node(km_monodromy *g, const km_complex *parameters) {
  int node = km_monodromy_add(g, parameters);
  return node >= 0 && g->node[node].count == g->node[0].count ? node : -1;
}

/* Adds a node of the section with another τ. */
static int add_changed_node(search_state *w, km_complex change) {
  km_monodromy *g = &w->section;
  memcpy(w->end, g->node[0].parameters, (size_t)g->h->parameter_count * sizeof *w->end);
  w->end[g->h->section_start + 2] += change;
  return add_section_node(g, w->end);
}

/* Second difference of the sums of a trace test: `difference` over the sums' sizes, `share` over the least second
 * difference of a known point. */
typedef struct trace_result {
  double difference, share;
} trace_result;

/* The trace test with nodes at two changes of τ; NaN if they haven't all points. */
static trace_result compare_traces(search_state *w, double reach, uint64_t *random) {
  km_monodromy *g = &w->section;
  km_complex sum[3][2], change = reach * g->h->functional_size * km_complex_random(random);
  int first = add_changed_node(w, change), second = first < 0 ? -1 : add_changed_node(w, 2.0 * change);
  if (second < 0 || g->node[first].count != g->node[0].count)
    return (trace_result){nan(""), nan("")};
  const int node[3] = {0, first, second};
  double size = 0.0;
  for (int k = 0; k < 3; ++k)
    add_traces(w, &g->node[node[k]], sum[k], &size);
  double difference = second_difference(sum);
  return (trace_result){difference / size, difference / least_difference(w, node)};
}

/* Moves the section to τ = 0, where its points have s = s_0 or y = c: the latter with another c where a point is lost.
 * Returns the node; −1: points were lost each time. */
static int close_section(search_state *w, uint64_t *random) {
  km_monodromy *g = &w->section;
  int node = add_section_node(g, w->known);
  for (int i = 1; node < 0 && i < CLOSINGS; ++i) {
    w->known[g->h->section_start + 1] = g->h->functional_size * km_complex_random(random);
    node = add_section_node(g, w->known);
  }
  return node;
}

/* Adds the section's points with s = s_0 to the solutions. False if points were lost. */
static bool collect_fibre(search_state *w, uint64_t *random) {
  km_monodromy *g = &w->section;
  int node = close_section(w, random), length = g->h->length;
  km_complex s0 = w->known[g->h->section_start], c = w->known[g->h->section_start + 1];
  for (int i = 0; node >= 0 && i < g->node[node].count; ++i) {
    const km_wide *x = g->node[node].points + (size_t)i * (size_t)length;
    if (cabs((km_complex)x[length - 1] - s0) < cabs(km_complex_trace(g->h->closure, x) - c))
      km_fibre_add(&w->out->graph, &w->out->graph.node[0], x);
  }
  return node >= 0;
}

static bool goes_on(const search_state *w) {
  return !w->out->graph.failed && !w->section.failed && !w->out->graph.cancelled && !w->section.cancelled &&
         !w->out->graph.is_exhausted && !w->section.is_exhausted;
}

/* Root mean square of y over the solutions. */
static double functional_size(const km_monodromy *g) {
  double sum = 0.0;
  for (int i = 0; i < g->node[0].count; ++i) {
    double size = cabs(km_complex_trace(g->h->closure, g->node[0].points + (size_t)i * (size_t)g->h->length));
    sum += size * size;
  }
  return sqrt(sum / g->node[0].count);
}

/* The trace test in two directions that show each known point; with less reach where points are lost. Returns the
 * larger difference, or the first one that doesn't pass. */
static double test_traces(search_state *w, uint64_t *random) {
  double largest = 0.0, reach = trace_reach;
  for (int i = 0, passed = 0; i < DIRECTIONS; ++i) {
    trace_result result = compare_traces(w, reach, random);
    if (result.difference > trace_tolerance)
      return result.difference;
    if (isnan(result.difference))
      reach = fmax(0.7 * reach, least_reach);
    else if (result.share <= largest_share) {
      largest = fmax(largest, result.difference);
      if (++passed == 2)
        return largest;
    }
  }
  return nan("");
}

/* Extends both graphs until the trace test passes on one section; false: it did not, or paths were lost. */
static bool test_section(search_state *w, uint64_t *random) {
  km_fibre_search *out = w->out;
  int tested = 0; /* points of the last test: another one with as many has the same result */
  for (int trial = 0; trial < TRIALS && goes_on(w); ++trial) {
    int known = w->section.node[0].count;
    if (!km_monodromy_extend(&w->section, trial == 0 ? SECTION_NODES : 1))
      return false;
    km_monodromy_choose_first(&w->section);
    out->section_points = w->section.node[0].count;
    int before = out->graph.node[0].count;
    if (out->section_points - known > largest_news * out->section_points)
      continue; /* surely more points are missing */
    if (out->section_points > tested) {
      out->trace_difference = test_traces(w, random);
      if (out->trace_difference <= trace_tolerance && out->section_points > before)
        return collect_fibre(w, random);
      if (isnan(out->trace_difference))
        return false;
      tested = out->section_points;
    }
    if (!km_monodromy_extend(&out->graph, 1))
      return false;
    begin_section(w, before);
  }
  return false;
}

/* The trace test on several sections: one may have a point beside a pole, from which no path leads on. */
static void test_completeness(search_state *w, uint64_t *random) {
  km_fibre_search *out = w->out;
  for (int i = 0; i < SECTIONS && goes_on(w) && !out->is_complete; ++i) {
    km_monodromy_free(&w->section);
    w->section.node[0] = (km_fibre){.parameters = KM_NEW(km_complex, (size_t)out->section.parameter_count)};
    w->section.failed = !w->section.node[0].parameters;
    if (w->section.failed)
      return;
    w->section.node_count = 0;
    km_complex_choose_trace(w->closure, out->graph.node[0].points, out->graph.node[0].count, random);
    out->section.functional_size = functional_size(&out->graph);
    km_homotopy_redirect(&out->section, random);
    place_section(w, random);
    begin_section(w, 0);
    out->is_complete = test_section(w, random);
  }
}

/* Recapture: tracks random solutions to node 0 and counts the finds of each. */
static bool sample_fibre(search_state *w, uint64_t *random) {
  km_monodromy *g = &w->out->graph;
  int wanted = SAMPLES_PER_SOLUTION * g->node[0].count + LEAST_SAMPLES;
  int *finds = KM_NEW(int, (size_t)(g->node[0].count + wanted));
  if (!finds)
    return false;
  for (int i = 0; i < wanted && goes_on(w); ++i) {
    km_homotopy_begin(g->h, w->centre, random, w->x, w->end);
    if (km_monodromy_track(g, w->end, g->node[0].parameters, w->x) != KM_PATH_ARRIVED)
      continue;
    int found = km_fibre_add(g, &g->node[0], w->x);
    if (found >= 0) {
      ++finds[found];
      ++w->out->samples;
    }
  }
  for (int i = 0; i < g->node[0].count; ++i)
    w->out->found_once += finds[i] == 1;
  km_free(finds);
  return true;
}

static bool create(search_state *w, uint64_t *random, km_arena *arena) {
  const km_complex_closure *closure = w->closure;
  km_fibre_search *out = w->out;
  if (!km_homotopy_create(closure, false, random, arena, &out->homotopy) ||
      !km_homotopy_create(closure, true, random, arena, &out->section))
    return false;
  w->x = KM_ARENA_NEW(arena, km_wide, (size_t)out->section.length);
  w->known = KM_ARENA_NEW(arena, km_complex, (size_t)out->section.parameter_count);
  w->end = KM_ARENA_NEW(arena, km_complex, (size_t)out->section.parameter_count);
  out->graph.h = &out->homotopy;
  w->section.h = &out->section;
  out->graph.node[0].parameters = KM_NEW(km_complex, (size_t)out->homotopy.parameter_count);
  return !arena->failed && out->graph.node[0].parameters;
}

km_status km_fibre_search_run(km_complex_closure *closure, const km_wide *centre, int limit, uint64_t *random,
                              km_arena *arena, km_progress progress, void *context, km_fibre_search *out,
                              km_error *error) {
  *out = (km_fibre_search){.trace_difference = nan("")};
  out->graph = (km_monodromy){.random = random, .limit = limit, .progress = progress, .context = context};
  search_state w = {.out = out, .section = out->graph, .closure = closure, .centre = centre};
  out->graph.failed = !create(&w, random, arena);
  if (!out->graph.failed) {
    km_homotopy_begin(&out->homotopy, centre, random, w.x, out->graph.node[0].parameters);
    km_fibre_add(&out->graph, &out->graph.node[0], w.x);
    /* Bodies that cannot move have one mode: a generic configuration has the poses of the closed one. */
    out->is_complete = km_complex_is_same_mode(closure, centre, w.x, same_mode_tolerance);
    if (out->is_complete)
      out->trace_difference = 0.0;
    else if (km_monodromy_search(&out->graph, 1) &&
             km_monodromy_search(&out->graph, out->graph.node[0].count < FEW_SOLUTIONS ? QUIET_NODES_OF_FEW : 0)) {
      km_monodromy_choose_first(&out->graph);
      test_completeness(&w, random);
    }
    if (!out->is_complete && goes_on(&w))
      out->graph.failed = !sample_fibre(&w, random);
  }
  bool failed = out->graph.failed || w.section.failed, cancelled = out->graph.cancelled || w.section.cancelled;
  out->is_exhausted = out->graph.is_exhausted || w.section.is_exhausted;
  km_monodromy_free(&w.section);
  if (failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  return cancelled ? km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled") : KM_OK;
}

void km_fibre_search_free(km_fibre_search *search) {
  km_monodromy_free(&search->graph);
}
