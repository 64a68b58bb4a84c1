/* Loops of large substructures: a cycle basis, of cycles no longer than the tree's. */
#include "support/support.h"

#include "topology/short_loops.h"

#include <string.h>

/* A large graph and its topology. */
typedef struct network {
  km_arena arena;
  km_graph graph;
  km_edge *edges;
  km_topology t;
} network;

static void open(network *n, int bodies, int most_joints) {
  *n = (network){.graph = {.body_count = bodies}};
  n->edges = KM_ARENA_NEW(&n->arena, km_edge, (size_t)most_joints);
  n->graph.edges = n->edges;
}

static void join(network *n, int a, int b) {
  n->edges[n->graph.joint_count++] = (km_edge){a, b};
}

static void finish(network *n) {
  assert_int_equal(km_topology_build(&n->graph, &n->arena, &n->t, NULL), KM_OK);
}

static int length_of(const network *n, int loop) {
  return n->t.member_start[loop + 1] - n->t.member_start[loop];
}

/* Number of joints of the tree's loop. */
static int tree_length(const network *n, int loop) {
  const km_topology *t = &n->t;
  int a = n->edges[t->chord[loop]].tail, b = n->edges[t->chord[loop]].head, length = 1;
  for (; a != b; ++length) {
    if (t->level[a] >= t->level[b])
      a = t->parent[a];
    else
      b = t->parent[b];
  }
  return length;
}

/* The traversal from the base along the first side and back along the other closes, by the senses of its members. */
static void check_cycle(const network *n, int loop) {
  const km_topology *t = &n->t;
  int *flow = KM_NEW(int, (size_t)t->body_count), ends[2] = {t->base[loop], t->base[loop]}, chords = 0;
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i) {
    const km_member *member = &t->member[i];
    const km_edge *edge = &n->edges[member->joint];
    int *end = &ends[member->side < 0], sense = (int)km_member_sign(member);
    assert_int_equal(member->is_reversed ? edge->head : edge->tail, *end);
    *end = member->is_reversed ? edge->tail : edge->head;
    assert_true(t->level[*end] >= t->level[t->base[loop]]);
    flow[edge->tail] -= sense;
    flow[edge->head] += sense;
    chords += member->joint == t->chord[loop];
    if (member->joint == t->chord[loop])
      assert_true(member->side > 0 && !member->is_reversed);
  }
  assert_int_equal(ends[0], ends[1]);
  assert_int_equal(chords, 1);
  for (int b = 0; b < t->body_count; ++b)
    assert_int_equal(flow[b], 0);
  km_free(flow);
}

/* The rank of loops by joints over the whole numbers modulo a prime. */
static int rank_of(const network *n) {
  enum { PRIME = 32003 };
  const km_topology *t = &n->t;
  size_t joints = (size_t)t->joint_count;
  int rank = 0, *rows = KM_NEW(int, (size_t)t->loop_count *joints), *pivot = KM_NEW(int, (size_t)t->loop_count);
  for (int l = 0; l < t->loop_count; ++l) {
    int *row = rows + (size_t)l * joints;
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i)
      row[t->member[i].joint] = km_member_sign(&t->member[i]) > 0 ? 1 : PRIME - 1;
    for (int k = 0; k < l; ++k) {
      const int *other = rows + (size_t)k * joints;
      int factor = pivot[k] < 0 ? 0 : row[pivot[k]];
      for (size_t j = 0; j < joints && factor; ++j)
        row[j] = (row[j] + (PRIME - factor) * other[j]) % PRIME;
    }
    pivot[l] = -1;
    for (size_t j = 0; j < joints && pivot[l] < 0; ++j)
      if (row[j])
        pivot[l] = (int)j;
    rank += pivot[l] >= 0;
    int inverse = 1;
    while (pivot[l] >= 0 && row[pivot[l]] * inverse % PRIME != 1)
      ++inverse;
    for (size_t j = 0; j < joints; ++j)
      row[j] = row[j] * inverse % PRIME;
  }
  km_free(rows);
  km_free(pivot);
  return rank;
}

static void check_basis(const network *n) {
  for (int l = 0; l < n->t.loop_count; ++l) {
    check_cycle(n, l);
    assert_true(length_of(n, l) <= tree_length(n, l));
  }
  assert_int_equal(rank_of(n), n->t.loop_count);
}

/* rows · columns bodies, each joined to those beside and below it, and the first one to the inertial frame. */
static void open_grid(network *n, int rows, int columns) {
  open(n, rows * columns + 1, 2 * rows * columns + 1);
  join(n, 0, 1);
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k) {
      int body = 1 + i * columns + k;
      if (k > 0)
        join(n, body - 1, body);
      if (i > 0)
        join(n, body, body - columns);
    }
}

static void shuffle(network *n, randomness *r) {
  for (int i = n->graph.joint_count - 1; i > 0; --i) {
    int k = below(r, i + 1);
    km_edge swap = n->edges[i];
    n->edges[i] = n->edges[k];
    n->edges[k] = below(r, 2) ? swap : (km_edge){swap.head, swap.tail};
  }
}

static void loops_of_a_grid_are_its_faces(void **state) {
  (void)state;
  network n;
  open_grid(&n, 9, 12);
  finish(&n);
  assert_int_equal(n.t.loop_count, 8 * 11);
  for (int l = 0; l < n.t.loop_count; ++l)
    assert_int_equal(length_of(&n, l), 4);
  check_basis(&n);
  km_arena_free(&n.arena);
}

static void small_substructures_keep_the_loops_of_the_tree(void **state) {
  (void)state;
  network n;
  int longest = 0;
  open_grid(&n, 6, 11);
  finish(&n);
  assert_int_equal(n.t.loop_count, KM_MAX_TREE_LOOPS);
  for (int l = 0; l < n.t.loop_count; ++l) {
    assert_int_equal(length_of(&n, l), tree_length(&n, l));
    longest = length_of(&n, l) > longest ? length_of(&n, l) : longest;
  }
  assert_true(longest > 4);
  check_basis(&n);
  km_arena_free(&n.arena);
}

static void loops_of_large_graphs_are_a_basis(void **state) {
  (void)state;
  randomness r = {3};
  for (int i = 0; i < 40; ++i) {
    network n;
    if (i % 2) {
      open_grid(&n, 5 + below(&r, 8), 14);
    } else { /* any bodies joined, some twice */
      int bodies = 20 + below(&r, 60), more = 60 + below(&r, 60);
      open(&n, bodies, bodies + more);
      for (int b = 1; b < bodies; ++b)
        join(&n, below(&r, b), b);
      for (int k = 0, a; k < more; ++k) {
        a = below(&r, bodies - 1);
        join(&n, a, a + 1 + below(&r, bodies - 1 - a));
      }
    }
    shuffle(&n, &r);
    finish(&n);
    check_basis(&n);
    km_arena_free(&n.arena);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(loops_of_a_grid_are_its_faces),
      cmocka_unit_test(small_substructures_keep_the_loops_of_the_tree),
      cmocka_unit_test(loops_of_large_graphs_are_a_basis),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
