/* Places of large graphs, and the graphs that they are written into. */
#include "support/support.h"

#include "kmech/report.h"
#include "report/drawing/graph_layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bodies on bodies that came before, the inertial frame often; then joints between any two. All at one place, so
 * that loops close. */
static fixture random_graph(randomness *r, int bodies, int chords) {
  km_text t = {0};
  km_text_add(&t, "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int b = 1; b <= bodies; ++b)
    km_text_format(&t, "%s{\"name\": \"b%d\"}", b > 1 ? ", " : "", b);
  km_text_add(&t, "], \"joints\": [");
  for (int j = 1; j <= bodies + chords; ++j) {
    int child = j <= bodies ? j : 1 + below(r, bodies), parent = below(r, j <= bodies ? j : bodies + 1);
    parent = parent == child ? 0 : parent;
    km_text_format(&t, "%s{\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [", j > 1 ? ", " : "", j);
    km_text_format(&t, parent ? "[\"b%d\", \"origin\"]" : "[\"fixed\", \"origin\"]", parent);
    km_text_format(&t, ", [\"b%d\", \"origin\"]]}", child);
  }
  km_text_add(&t, "]}]}");
  fixture f = fixture_read(t.data);
  km_text_free(&t);
  return f;
}

/* A node of the picture. */
typedef struct node {
  int level;
  double x;
} node;

static int by_level(const void *a, const void *b) {
  const node *p = a, *q = b;
  return p->level != q->level ? p->level - q->level : (p->x > q->x) - (p->x < q->x);
}

/* Nodes of a level are at least a column apart, and a body lies between its first and last child. */
static void check_places(const km_mechanism *m, const km_graph_places *p) {
  const km_topology *t = &m->topology;
  node nodes[1000];
  int count = 0;
  double first[500], last[500];
  for (int b = 0; b < t->body_count; ++b) {
    nodes[count++] = (node){t->level[b], p->body[b]};
    first[b] = INFINITY;
    last[b] = -INFINITY;
  }
  for (int b = 1; b < t->body_count; ++b) {
    first[t->parent[b]] = fmin(first[t->parent[b]], p->body[b]);
    last[t->parent[b]] = fmax(last[t->parent[b]], p->body[b]);
  }
  for (int l = 0; l < t->loop_count; ++l) {
    int tail = m->model->frames[m->model->joints[t->chord[l]].frame[0]].body;
    nodes[count++] = (node){p->level[l], p->loop[l]};
    assert_int_equal(p->level[l], t->level[tail] + 1);
    first[tail] = fmin(first[tail], p->loop[l]);
    last[tail] = fmax(last[tail], p->loop[l]);
  }
  for (int b = 0; b < t->body_count; ++b)
    assert_true(first[b] > last[b] || (p->body[b] >= first[b] && p->body[b] <= last[b]));
  qsort(nodes, (size_t)count, sizeof *nodes, by_level);
  for (int i = 1; i < count; ++i)
    assert_true(nodes[i].level > nodes[i - 1].level || nodes[i].x - nodes[i - 1].x >= p->pitch * (1.0 - 1e-12));
}

static void places(void **state) {
  (void)state;
  randomness r = {7};
  for (int i = 0; i < 100; ++i) {
    fixture f = random_graph(&r, 1 + below(&r, 200), below(&r, 200));
    km_graph_places p;
    assert_true(km_graph_places_find(f.mechanism, &p));
    check_places(f.mechanism, &p);
    km_graph_places_free(&p);
    fixture_close(&f);
  }
}

static int occurrences(const char *text, const char *word) {
  int count = 0;
  for (const char *at = strstr(text, word); at; at = strstr(at + 1, word))
    ++count;
  return count;
}

/* Up to 300 joints are left to graphviz; of more every node, arc and line has its place, and every arc's label. */
static void written(void **state) {
  (void)state;
  randomness r = {8};
  for (int chords = 99; chords <= 102; ++chords) {
    fixture f = random_graph(&r, 200, chords);
    km_text dot = {0};
    km_graph_write(f.mechanism, "graph", &dot);
    bool large = f.mechanism->topology.joint_count > 300;
    int arcs = 200 + chords, nodes = 201 + chords;
    assert_int_equal(occurrences(dot.data, "layout=nop2"), large);
    assert_int_equal(occurrences(dot.data, " lp=\""), large ? arcs : 0);
    assert_int_equal(occurrences(dot.data, " pos=\""), large ? nodes + arcs + chords : 0);
    assert_int_equal(occurrences(dot.data, "nan") + occurrences(dot.data, "inf"), 0);
    km_text_free(&dot);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(places), cmocka_unit_test(written)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
