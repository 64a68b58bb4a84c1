/* All solutions over a generic value of the errors, with the trace test (trace_test.h). */
#include "space/complex/trace_test.h"

#include <string.h>

/* Relative difference of the fingerprints of one mode. */
static const double same_mode_tolerance = 1e-7;

/* Second difference of a sum, relative to the sum of sizes, that rounding explains: 1e-15, beside poles up to 2e-10.
 * One of 350 points, left out, leaves less than this in 14 of 23335 cases (10 of 23681 at a change of 4), 3e-11 at
 * least: if that point alone is missing, this direction does not show it. */
static const double trace_tolerance = 5e-10;
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
  SAMPLES_PER_SOLUTION = 3,
  LEAST_SAMPLES = 30
};

typedef struct search_state {
  km_fibre_search *out;
  km_monodromy section;
  km_complex_closure *closure;
  const km_complex *centre;
  km_complex *x, *end; /* [section length], [section parameters] workspace */
} search_state;

/* Point i of a fibre, copied to the workspace. */
static km_complex *point_of(const search_state *w, const km_monodromy *g, int i) {
  memcpy(w->x, g->node[0].points + (size_t)i * (size_t)g->h->length, (size_t)g->h->length * sizeof *w->x);
  return w->x;
}

/* Adds the known solutions to the section: from s = s_0, τ = 0 to node 0. */
static void begin_section(search_state *w, int first) {
  km_monodromy *g = &w->out->graph, *section = &w->section;
  const km_complex *P = section->node[0].parameters;
  int start = section->h->section_start;
  memcpy(w->end, P, (size_t)section->h->parameter_count * sizeof *w->end);
  w->end[start + 2] = 0.0;
  for (int i = first; i < g->node[0].count && !section->failed; ++i) {
    km_complex *x = point_of(w, g, i);
    x[g->h->length] = P[start];
    if (km_monodromy_track(section, w->end, P, x) == KM_PATH_ARRIVED)
      km_fibre_add(section, &section->node[0], x);
  }
}

/* Parameters of the section's node 0: p + s_0 v and P are those of the search. */
static void place_section(search_state *w, uint64_t *random) {
  const km_homotopy *h = w->section.h;
  km_complex *P = w->section.node[0].parameters;
  const km_complex *known = w->out->graph.node[0].parameters;
  km_homotopy_draw(h, random, P);
  memcpy(P, known, (size_t)h->section_start * sizeof *P);
  for (int i = 0; i < h->section_start; ++i)
    P[i] -= P[h->section_start] * h->direction[i];
}

/* Sums of y and s over all points of a node. */
static void add_traces(const search_state *w, const km_fibre *fibre, km_complex sum[2], double *size) {
  const km_homotopy *h = w->section.h;
  sum[0] = sum[1] = 0.0;
  for (int i = 0; i < fibre->count; ++i) {
    const km_complex *x = fibre->points + (size_t)i * (size_t)h->length;
    km_complex y = km_complex_trace(h->closure, x), s = x[h->closure->length];
    sum[0] += y;
    sum[1] += s;
    *size += cabs(y) + cabs(s);
  }
}

/* Adds a node of the section with another τ. Returns its index; −1: it hasn't all points. */
static int add_section_node(search_state *w, km_complex change) {
  km_monodromy *g = &w->section;
  memcpy(w->end, g->node[0].parameters, (size_t)g->h->parameter_count * sizeof *w->end);
  w->end[g->h->section_start + 2] += change;
  int node = km_monodromy_add(g, w->end);
  return node >= 0 && g->node[node].count == g->node[0].count ? node : -1;
}

/* The trace test with nodes at two changes of τ; NaN if they haven't all points. */
static double trace_difference(search_state *w, double reach, uint64_t *random) {
  km_monodromy *g = &w->section;
  km_complex sum[3][2], change = reach * g->h->functional_size * km_complex_random(random);
  int first = add_section_node(w, change), second = first < 0 ? -1 : add_section_node(w, 2.0 * change);
  if (second < 0 || g->node[first].count != g->node[0].count)
    return nan("");
  const int node[3] = {0, first, second};
  double size = 0.0, largest = 0.0;
  for (int k = 0; k < 3; ++k)
    add_traces(w, &g->node[node[k]], sum[k], &size);
  for (int j = 0; j < 2; ++j)
    largest = fmax(largest, cabs(sum[0][j] - 2.0 * sum[1][j] + sum[2][j]) / size);
  return largest;
}

/* Moves the section to τ = 0 and adds the points with s = s_0 to the solutions. False if points were lost. */
static bool collect_fibre(search_state *w) {
  km_monodromy *g = &w->section;
  const km_complex *P = g->node[0].parameters;
  int start = g->h->section_start, length = g->h->closure->length, node = add_section_node(w, -P[start + 2]);
  for (int i = 0; node >= 0 && i < g->node[node].count; ++i) {
    const km_complex *x = g->node[node].points + (size_t)i * (size_t)g->h->length;
    if (cabs(x[length] - P[start]) < cabs(km_complex_trace(g->h->closure, x) - P[start + 1]))
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

/* The trace test in two directions; with less reach where points are lost. Returns the larger difference, or the first
 * one that doesn't pass. */
static double test_traces(search_state *w, uint64_t *random) {
  double largest = 0.0, reach = trace_reach;
  for (int i = 0, passed = 0; i < DIRECTIONS; ++i) {
    double difference = trace_difference(w, reach, random);
    if (difference > trace_tolerance)
      return difference;
    if (isnan(difference)) {
      reach = fmax(0.7 * reach, least_reach);
      continue;
    }
    largest = fmax(largest, difference);
    if (++passed == 2)
      return largest;
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
    out->section_points = w->section.node[0].count;
    int before = out->graph.node[0].count;
    if (out->section_points - known > largest_news * out->section_points)
      continue; /* surely more points are missing */
    out->trace_difference = test_traces(w, random);
    if (out->trace_difference <= trace_tolerance && out->section_points > before)
      return collect_fibre(w);
    if (isnan(out->trace_difference) || tested == out->section_points || !km_monodromy_extend(&out->graph, 1))
      return false;
    tested = out->section_points;
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
  w->x = KM_ARENA_NEW(arena, km_complex, (size_t)out->section.length);
  w->end = KM_ARENA_NEW(arena, km_complex, (size_t)out->section.parameter_count);
  out->graph.h = &out->homotopy;
  w->section.h = &out->section;
  out->graph.node[0].parameters = KM_NEW(km_complex, (size_t)out->homotopy.parameter_count);
  return !arena->failed && out->graph.node[0].parameters;
}

km_status km_fibre_search_run(km_complex_closure *closure, const km_complex *centre, int limit, uint64_t *random,
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
             km_monodromy_search(&out->graph, out->graph.node[0].count < FEW_SOLUTIONS ? QUIET_NODES_OF_FEW : 0))
      test_completeness(&w, random);
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
