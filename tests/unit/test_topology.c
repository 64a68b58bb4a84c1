/* Topology against its definitions by brute force, on random graphs. */
#include "support/support.h"

#include "kmech/mechanism.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

enum { MOST_BODIES = 9, MOST_JOINTS = 16 };

typedef struct graph {
  int bodies, joints;
  km_edge edges[MOST_JOINTS];
  bool is_cut[MOST_JOINTS];
} graph;

/* A random connected graph; parallel edges are allowed. A random share of its joints is to be cut. */
static graph random_graph(randomness *r) {
  graph g = {.bodies = 2 + below(r, MOST_BODIES - 1)};
  for (int b = 1; b < g.bodies; ++b)
    g.edges[g.joints++] = (km_edge){below(r, b), b};
  int more = below(r, MOST_JOINTS - g.joints + 1);
  for (int i = 0; i < more; ++i) {
    int a = below(r, g.bodies), b = below(r, g.bodies - 1);
    g.edges[g.joints++] = (km_edge){a, b + (b >= a)};
  }
  for (int i = g.joints - 1; i > 0; --i) { /* any order, any sense */
    int k = below(r, i + 1);
    km_edge swap = g.edges[i];
    g.edges[i] = g.edges[k];
    g.edges[k] = swap;
    if (below(r, 2))
      g.edges[i] = (km_edge){g.edges[i].head, g.edges[i].tail};
  }
  int share = below(r, 3);
  for (int i = 0; i < g.joints; ++i)
    g.is_cut[i] = below(r, 3) < share;
  return g;
}

static bool connected_without(const graph *g, int from, int to, int skipped_body, unsigned skipped_joints) {
  bool seen[MOST_BODIES] = {0};
  int stack[MOST_BODIES], top = 0;
  seen[from] = true;
  stack[top++] = from;
  while (top) {
    int body = stack[--top];
    for (int j = 0; j < g->joints; ++j) {
      int next = g->edges[j].tail == body ? g->edges[j].head : g->edges[j].head == body ? g->edges[j].tail : -1;
      if (next < 0 || next == skipped_body || (skipped_joints >> j & 1u) || seen[next])
        continue;
      seen[next] = true;
      stack[top++] = next;
    }
  }
  return seen[to];
}

/* True if joints a and b lie on a common simple cycle: with two vertices subdividing them, exactly if no single body
 * or joint separates the subdivisions (Menger); checked for every body and joint. */
static bool share_a_cycle(const graph *g, int a, int b) {
  /* Every body: removed, some end of a must still reach some end of b by an end that is left, and so on. */
  for (int body = 0; body < g->bodies; ++body) {
    bool joined = false;
    const int ea[2] = {g->edges[a].tail, g->edges[a].head}, eb[2] = {g->edges[b].tail, g->edges[b].head};
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 2; ++k)
        if (ea[i] != body && eb[k] != body && connected_without(g, ea[i], eb[k], body, 1u << a | 1u << b))
          joined = true;
    if (!joined)
      return false;
  }
  for (int j = 0; j < g->joints; ++j) {
    if (j == a || j == b)
      continue;
    bool joined = false;
    const int ea[2] = {g->edges[a].tail, g->edges[a].head}, eb[2] = {g->edges[b].tail, g->edges[b].head};
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 2; ++k)
        if (connected_without(g, ea[i], eb[k], -1, 1u << a | 1u << b | 1u << j))
          joined = true;
    if (!joined)
      return false;
  }
  /* The two joints themselves must not be bridges of each other's way round. */
  return connected_without(g, g->edges[a].tail, g->edges[a].head, -1, 1u << a) &&
         connected_without(g, g->edges[b].tail, g->edges[b].head, -1, 1u << b);
}

static km_topology build(const graph *g, const km_coupled_joints *ties, int tie_count, km_arena *arena) {
  km_graph graph_of = {g->bodies, g->joints, tie_count, g->edges, g->is_cut, ties};
  km_topology t;
  assert_int_equal(km_topology_build(&graph_of, arena, &t, NULL), KM_OK);
  return t;
}

/* The tree has as few joints to cut as possible: one less than the parts into which their removal separates bodies. */
static void check_cuts(const graph *g, const km_topology *t) {
  unsigned cut = 0;
  int parts = 0, used = 0;
  for (int j = 0; j < g->joints; ++j)
    cut |= (unsigned)g->is_cut[j] << j;
  for (int b = 0; b < g->bodies; ++b) {
    bool is_first = true;
    for (int other = 0; other < b; ++other)
      is_first = is_first && !connected_without(g, other, b, -1, cut);
    parts += is_first;
    used += b > 0 && g->is_cut[t->arc[b]];
  }
  assert_int_equal(used, parts - 1);
}

static void check_tree(const graph *g, const km_topology *t) {
  assert_int_equal(t->loop_count, g->joints - g->bodies + 1);
  assert_int_equal(t->order[0], 0);
  for (int i = 1; i < g->bodies; ++i) {
    int body = t->order[i];
    assert_int_equal(t->level[body], t->level[t->parent[body]] + 1);
    assert_true(t->level[body] >= t->level[t->order[i - 1]]);
    const km_edge *arc = &g->edges[t->arc[body]];
    assert_int_equal(t->is_reversed[t->arc[body]] ? arc->tail : arc->head, body);
    assert_int_equal(t->is_reversed[t->arc[body]] ? arc->head : arc->tail, t->parent[body]);
  }
  for (int j = 0; j < g->joints; ++j) /* breadth first: no joint skips a level */
    if (!g->is_cut[j])
      assert_in_range(t->level[g->edges[j].tail] - t->level[g->edges[j].head] + 1, 0, 2);
  check_cuts(g, t);
}

/* Each loop's members form a cycle: every body is touched an even number of times. */
static void check_loops(const graph *g, const km_topology *t) {
  for (int l = 0; l < t->loop_count; ++l) {
    int touched[MOST_BODIES] = {0};
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i) {
      touched[g->edges[t->member[i].joint].tail]++;
      touched[g->edges[t->member[i].joint].head]++;
    }
    for (int b = 0; b < g->bodies; ++b)
      assert_true(touched[b] == 0 || touched[b] == 2);
    assert_int_equal(touched[t->base[l]], 2);
  }
}

static void check_substructures(const graph *g, const km_topology *t) {
  for (int a = 0; a < g->joints; ++a) {
    bool bridge = !connected_without(g, g->edges[a].tail, g->edges[a].head, -1, 1u << a);
    assert_int_equal(t->substructure_of_joint[a] < 0, bridge);
    for (int b = 0; b < a; ++b) {
      bool same = t->substructure_of_joint[a] >= 0 && t->substructure_of_joint[a] == t->substructure_of_joint[b];
      assert_int_equal(same, share_a_cycle(g, a, b));
    }
  }
  int last = -1; /* numbered by their first joint */
  for (int s = 0; s < t->substructure_count; ++s) {
    assert_true(t->joint[t->joint_start[s]] > last);
    last = t->joint[t->joint_start[s]];
    for (int i = t->joint_start[s]; i < t->joint_start[s + 1]; ++i)
      assert_int_equal(t->substructure_of_joint[t->joint[i]], s);
    for (int i = t->loop_start[s]; i < t->loop_start[s + 1]; ++i)
      assert_int_equal(t->substructure_of_loop[t->loop[i]], s);
  }
}

static void random_graphs_agree_with_the_definition(void **state) {
  (void)state;
  randomness r = {7};
  for (int i = 0; i < 3000; ++i) {
    km_arena arena = {0};
    graph g = random_graph(&r);
    km_topology t = build(&g, NULL, 0, &arena);
    check_tree(&g, &t);
    check_loops(&g, &t);
    check_substructures(&g, &t);
    km_arena_free(&arena);
  }
}

/* One loop that ties two earlier ones together: Algorithm 4's greedy growth would miss it. */
static void a_late_loop_joins_two_substructures(void **state) {
  (void)state;
  graph g = {5, 7, {{0, 1}, {0, 2}, {1, 2}, {0, 3}, {0, 4}, {3, 4}, {2, 3}}, {0}};
  km_arena arena = {0};
  km_topology t = build(&g, NULL, 0, &arena);
  assert_int_equal(t.substructure_count, 1);
  km_arena_free(&arena);
}

static void couplings_join(void **state) {
  (void)state;
  graph g = {4, 4, {{0, 1}, {0, 2}, {0, 3}, {2, 3}}, {0}};
  const int geared[2] = {0, 3};
  const km_coupled_joints tie = {geared, 2};
  km_arena arena = {0};
  km_topology t = build(&g, &tie, 1, &arena);
  assert_int_equal(t.substructure_count, 1);
  for (int j = 0; j < 4; ++j)
    assert_int_equal(t.substructure_of_joint[j], 0);
  km_arena_free(&arena);
}

/* Held alone, a component of a rotation vector would leave a joint that is none. */
static void a_ball_is_held_as_a_whole(void **state) {
  (void)state;
  fixture f = fixture_open("rssr");
  km_mechanism *mechanism = NULL;
  km_error error = {0};
  km_hold holds[3];
  for (int k = 0; k < 3; ++k) {
    static const char *const labels[3] = {"C[0]", "C[1]", "C[2]"};
    assert_int_equal(km_model_find_coordinate(f.model, labels[k], &holds[k].coordinate, NULL), KM_OK);
    holds[k].value = 0.0;
  }
  for (int count = 1; count < 3; ++count) {
    assert_int_equal(km_mechanism_compile(f.model, holds, count, &mechanism, &error), KM_USAGE);
    assert_non_null(strstr(error.text, "\"C[0]\" is a component of a rotation vector"));
    assert_null(mechanism);
  }
  assert_int_equal(km_mechanism_compile(f.model, holds, 3, &mechanism, &error), KM_OK);
  km_mechanism_free(mechanism);
  fixture_close(&f);
}

/* A tolerance that is not stated is not stated for a second compilation: ranks follow the gaps of the loops. */
static void options_of_a_mechanism_compile_it_alike(void **state) {
  (void)state;
  fixture f = fixture_open("rssr");
  for (int i = 0; i < 2; ++i) {
    km_mechanism *first = NULL, *second = NULL;
    const km_compiling given = {.closure_tolerance = i ? 1e-6 : 0.0, .length = 2.5, .length_source = KM_LENGTH_JOINTS};
    assert_int_equal(km_mechanism_compile_as(f.model, &given, &first, NULL), KM_OK);
    km_compiling options = km_mechanism_options(first);
    options.cuts_balls = true;
    assert_int_equal(km_mechanism_compile_as(f.model, &options, &second, NULL), KM_OK);
    assert_int_equal(second->closure_tolerance_given, i);
    assert_true(second->closure_tolerance == first->closure_tolerance && second->length == first->length);
    assert_int_equal(second->length_source, first->length_source);
    km_mechanism_free(second);
    km_mechanism_free(first);
  }
  fixture_close(&f);
}

/* Hinges on the ground: no link has a length, and the mechanism's is the greatest distance between two of them. */
static void length_of_hinges(void **state) {
  (void)state;
  enum { COUNT = 60 };
  for (int round = 0; round < 20; ++round) {
    double p[COUNT][3], greatest = 0.0;
    km_text bodies = {0}, joints = {0}, frames = {0}, json = {0};
    unsigned seed = 1u + (unsigned)round;
    for (int i = 0; i < COUNT; ++i) {
      for (int k = 0; k < 3; ++k) {
        seed = seed * 1664525u + 1013904223u;
        p[i][k] = round % 4 == 3 && k ? 0.0 : 1000.0 * (round % 2) + (seed >> 8) % 10000 / 1000.0;
      }
      for (int o = 0; o < i; ++o)
        greatest =
            fmax(greatest, sqrt(pow(p[i][0] - p[o][0], 2) + pow(p[i][1] - p[o][1], 2) + pow(p[i][2] - p[o][2], 2)));
      const char *comma = i ? ", " : "";
      km_text_format(&bodies, "%s{\"name\": \"b%d\"}", comma, i);
      km_text_format(&frames, "%s{\"name\": \"f%d\", \"T\": [%.17g, %.17g, %.17g]}", comma, i, p[i][0], p[i][1],
                     p[i][2]);
      km_text_format(&joints, "%s{\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed/f%d\", \"b%d\"]}",
                     comma, i, i, i);
    }
    km_text_format(
        &json,
        "{\"fixed\": {\"frames\": [%s]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [%s], \"joints\": [%s]}]}",
        frames.data, bodies.data, joints.data);
    km_model *model;
    km_mechanism *mechanism;
    km_error error;
    km_length_source source;
    if (km_model_read(json.data, json.size, NULL, &model, &error) ||
        km_mechanism_compile(model, NULL, 0, &mechanism, &error))
      fail_msg("%s", error.text);
    assert_near(km_mechanism_characteristic_length(mechanism, &source), greatest, 1e-12 * greatest);
    assert_int_equal(source, KM_LENGTH_JOINTS);
    km_mechanism_free(mechanism);
    km_model_free(model);
    km_text_free(&bodies);
    km_text_free(&joints);
    km_text_free(&frames);
    km_text_free(&json);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(length_of_hinges),
      cmocka_unit_test(random_graphs_agree_with_the_definition),
      cmocka_unit_test(a_late_loop_joins_two_substructures),
      cmocka_unit_test(couplings_join),
      cmocka_unit_test(a_ball_is_held_as_a_whole),
      cmocka_unit_test(options_of_a_mechanism_compile_it_alike),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
