/* Circuits of assembly modes: against closed forms of four-bars and six-bars, and published ones. */
#include "support/support.h"

#include "base/random.h"
#include "kmech/space.h"
#include "model/model.h"

#include <complex.h>
#include <stdio.h>
#include <string.h>

/* Modes and circuits of a fixture with locked coordinates. */
typedef struct found {
  km_all_modes modes;
  km_mode_circuits circuits;
} found;

static found find(const fixture *f, const int *locked, int count) {
  found r;
  km_error error = {0};
  const km_all_modes_def def = {.locked = locked, .locked_count = count, .seed = 1};
  if (km_all_modes_find(f->mechanism, f->state, &def, NULL, NULL, &r.modes, &error) ||
      km_mode_circuits_find(f->mechanism, f->state, &def, &r.modes, NULL, NULL, &r.circuits, &error))
    fail_msg("%s", error.text);
  return r;
}

static void release(found *r) {
  km_mode_circuits_free(&r->circuits);
  km_all_modes_free(&r->modes);
}

/* ---- Six-bars: a four-bar of bodies 0 to 3, and two bars 4 and 5 between points of two of them. */

enum { JOINTS = 7, STEPS = 10000, NODES = 4 * STEPS };

typedef double complex point;

static point at(double x, double y) {
  const double parts[2] = {x, y};
  point p;
  memcpy(&p, parts, sizeof p);
  return p;
}

typedef struct six_bar {
  point hinge[JOINTS]; /* places of the joints as drawn */
  int pair[2];         /* bodies that carry the bars */
  int fixed, driver;   /* fixed body; driven joint */
} six_bar;

static void bodies_of(const six_bar *b, int joint, int *first, int *second) {
  const int pairs[JOINTS][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {b->pair[0], 4}, {b->pair[1], 5}, {4, 5}};
  *first = pairs[joint][0];
  *second = pairs[joint][1];
}

static fixture build_six_bar(const six_bar *b) {
  km_text text = {0};
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int i = 0, n = 0; i < 6; ++i)
    if (i != b->fixed)
      km_text_format(&text, "%s{\"name\": \"b%d\"}", n++ ? ", " : "", i);
  km_text_add(&text, "], \"joints\": [");
  for (int j = 0; j < JOINTS; ++j) {
    int body[2];
    bodies_of(b, j, &body[0], &body[1]);
    km_text_format(&text, "%s{\"name\": \"J%d\", \"type\": \"revolute\", \"bodies\": [", j ? ", " : "", j);
    for (int k = 0; k < 2; ++k)
      if (body[k] == b->fixed)
        km_text_format(&text, "%s\"fixed\"", k ? ", " : "");
      else
        km_text_format(&text, "%s\"b%d\"", k ? ", " : "", body[k]);
    km_text_format(&text, "], \"at\": [%.17g, %.17g]}", creal(b->hinge[j]), cimag(b->hinge[j]));
  }
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* Intersection of the circles about p and q with radii r and s, on the side of `sign`; false: they don't meet. */
static bool intersect(point p, double r, point q, double s, double sign, point *out) {
  double d = cabs(q - p), along = (d * d + r * r - s * s) / (2.0 * d), square = r * r - along * along;
  *out = p + (q - p) / d * at(along, sign * sqrt(fmax(square, 0.0)));
  return square >= 0.0;
}

/* Joint angles at the angle phi of body 1, relative to those that are drawn; parts: 0 the four-bar is open, 1 the bars
 * are, 2 all is closed. */
static int joint_angles(const six_bar *b, double phi, double first, double second, double angle[JOINTS]) {
  const point *h = b->hinge;
  point turn[6] = {1.0}, C, R, foot[2];
  turn[1] = at(cos(phi), sin(phi));
  point B = h[0] + turn[1] * (h[1] - h[0]);
  bool is_closed = intersect(B, cabs(h[2] - h[1]), h[3], cabs(h[2] - h[3]), first, &C);
  turn[2] = (C - B) / (h[2] - h[1]);
  turn[3] = (C - h[3]) / (h[2] - h[3]);
  const point origin[4] = {0.0, h[0] - turn[1] * h[0], B - turn[2] * h[1], h[3] - turn[3] * h[3]};
  for (int k = 0; k < 2; ++k)
    foot[k] = origin[b->pair[k]] + turn[b->pair[k]] * h[4 + k];
  int parts = is_closed;
  parts += intersect(foot[0], cabs(h[6] - h[4]), foot[1], cabs(h[6] - h[5]), second, &R) && is_closed;
  turn[4] = (R - foot[0]) / (h[6] - h[4]);
  turn[5] = (R - foot[1]) / (h[6] - h[5]);
  for (int j = 0; j < JOINTS; ++j) {
    int p, q;
    bodies_of(b, j, &p, &q);
    angle[j] = carg(turn[q] / turn[p]);
  }
  return parts;
}

/* Closed form on a dense grid: node 4 k + 2 i + j is at the angle 2πk/STEPS on sides i and j of both pairs of bars. */
typedef struct closed_form {
  six_bar bars;
  int parts[NODES], parent[NODES];
  double angle[NODES][JOINTS];
} closed_form;

static int root(closed_form *c, int node) {
  while (c->parent[node] != node)
    node = c->parent[node] = c->parent[c->parent[node]];
  return node;
}

/* Connects two neighbours; where the driver's angle passes 0 between them, one of them is returned, else −1. */
static int join(closed_form *c, int a, int b) {
  double x = c->angle[a][c->bars.driver], y = c->angle[b][c->bars.driver];
  c->parent[root(c, a)] = root(c, b);
  return (x < 0.0) != (y < 0.0) && fabs(x - y) < 1.0 ? a : -1;
}

/* Fills the closed form; crossings[] are nodes at which the driver's angle is 0. Returns their number. */
static int follow_closed_form(closed_form *c, int *crossings, int most) {
  int count = 0;
  for (int n = 0; n < NODES; ++n) {
    c->parent[n] = n;
    c->parts[n] =
        joint_angles(&c->bars, 2.0 * M_PI * (n / 4 + 0.5) / STEPS, n & 2 ? 1.0 : -1.0, n & 1 ? 1.0 : -1.0, c->angle[n]);
  }
  for (int n = 0; n < NODES; ++n) {
    if (c->parts[n] < 2)
      continue;
    for (int side = -1; side <= 1; side += 2) {
      int next = (n + 4 * side + NODES) % NODES, other = c->parts[next] == 0 ? n ^ 2 : n ^ 1;
      bool is_turn = c->parts[next] < 2;
      if (is_turn && c->parts[other] < 2)
        continue;
      if (!is_turn && side < 0)
        continue; /* the neighbour joins the pair */
      int crossing = join(c, n, is_turn ? other : next);
      if (crossing >= 0 && (!is_turn || n < other) && count < most)
        crossings[count++] = crossing;
    }
  }
  return count;
}

/* Returns the mode nearest to a node, by the largest difference of an angle; −1: none within 0.2, which is more than a
 * step of the grid beside a dead point. */
static int mode_at(const fixture *f, const found *r, const closed_form *c, int node) {
  int best = -1;
  double least = 0.2;
  for (int i = 0; i < r->modes.count; ++i) {
    double worst = 0.0;
    for (int j = 0; j < JOINTS; ++j) {
      char label[16];
      snprintf(label, sizeof label, "J%d", j);
      double q = r->modes.coordinates[i * f->model->coordinate_count + fixture_coordinate(f, label)];
      worst = fmax(worst, fabs(remainder(q - c->angle[node][j], 2.0 * M_PI)));
    }
    if (worst < least) {
      least = worst;
      best = i;
    }
  }
  return best;
}

typedef struct family {
  const char *name;
  int pair[2], fixed, driver;
} family;

/* Watt's and Stephenson's six-bars: two modes are on one circuit if and only if the closed form connects them. */
static void six_bars_as_followed_in_closed_form(void **state) {
  (void)state;
  const family families[] = {{"Watt I", {2, 3}, 0, 0},
                             {"Watt II", {0, 3}, 0, 0},
                             {"Watt II, last joint", {0, 3}, 0, 5},
                             {"Stephenson I", {1, 3}, 0, 0},
                             {"Stephenson II", {1, 3}, 4, 4},
                             {"Stephenson III", {0, 2}, 0, 0},
                             {"Stephenson III, last joint", {0, 2}, 0, 4}};
  closed_form *c = KM_NEW(closed_form, 1);
  uint64_t random = 21;
  int compared = 0, connected = 0, apart = 0;
  assert_non_null(c);
  for (size_t k = 0; k < 4 * (sizeof families / sizeof *families); ++k) {
    const family *now = &families[k % (sizeof families / sizeof *families)];
    const point drawn[JOINTS] = {0.0, at(0.2, 0.6), at(1.1, 0.9), 1.0, at(0.5, 0.4), at(1.3, 0.3), at(0.8, 1.3)};
    c->bars = (six_bar){.pair = {now->pair[0], now->pair[1]}, .fixed = now->fixed, .driver = now->driver};
    for (int j = 0; j < JOINTS; ++j)
      c->bars.hinge[j] = drawn[j] + at(0.4 * km_uniform(&random), 0.4 * km_uniform(&random));
    fixture f = build_six_bar(&c->bars);
    char label[8];
    snprintf(label, sizeof label, "J%d", now->driver);
    int driver = fixture_coordinate(&f, label), crossings[32], mode[32];
    found r = find(&f, &driver, 1);
    int count = follow_closed_form(c, crossings, 32);
    if (!r.modes.is_complete || r.circuits.gap || count != r.modes.count)
      fail_msg("%s %zu: %d modes, %d in closed form", now->name, k, r.modes.count, count);
    for (int i = 0; i < count; ++i) {
      mode[i] = mode_at(&f, &r, c, crossings[i]);
      if (mode[i] < 0)
        fail_msg("%s %zu: no mode at crossing %d", now->name, k, i);
    }
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < a; ++b) {
        bool is_same = root(c, crossings[a]) == root(c, crossings[b]);
        if (is_same != (r.circuits.circuit[mode[a]] == r.circuits.circuit[mode[b]]))
          fail_msg("%s %zu: modes %d and %d", now->name, k, mode[a] + 1, mode[b] + 1);
        ++compared;
        connected += is_same;
        apart += !is_same;
      }
    release(&r);
    fixture_close(&f);
  }
  assert_true(compared > 40 && connected > 10 && apart > 10);
  km_free(c);
}

/* ---- Four-bars. */

static fixture build_four_bar(const point h[4]) {
  km_text text = {0};
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"b1\"}, "
                     "{\"name\": \"b2\"}, {\"name\": \"b3\"}], \"joints\": [");
  const char *const bodies[] = {"fixed", "b1", "b2", "b3", "fixed"};
  for (int j = 0; j < 4; ++j)
    km_text_format(
        &text, "%s{\"name\": \"J%d\", \"type\": \"revolute\", \"bodies\": [\"%s\", \"%s\"], \"at\": [%.17g, %.17g]}",
        j ? ", " : "", j, bodies[j], bodies[j + 1], creal(h[j]), cimag(h[j]));
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* Grashof: the shortest and longest bar together are shorter than both others. Then there are two circuits, with one
 * mode each at an angle of a bar that goes round; else both modes are on one circuit. */
static void four_bars_by_grashof(void **state) {
  (void)state;
  uint64_t random = 9;
  int round = 0, others = 0;
  for (int trial = 0; trial < 40; ++trial) {
    double crank = 0.3 + 0.3 * km_uniform(&random), angle = 6.28 * km_uniform(&random);
    const point h[4] = {0.0, at(crank * cos(angle), crank * sin(angle)),
                        at(1.0 + 0.5 * km_uniform(&random), 1.0 + 0.5 * km_uniform(&random)), 1.0};
    double sum = 0.0, shortest = HUGE_VAL, longest = 0.0, length[4];
    for (int i = 0; i < 4; ++i) {
      length[i] = cabs(h[(i + 1) % 4] - h[i]);
      sum += length[i];
      shortest = fmin(shortest, length[i]);
      longest = fmax(longest, length[i]);
    }
    bool is_grashof = 2.0 * (shortest + longest) < sum;
    if (is_grashof && shortest < fmin(length[0], length[3]))
      continue; /* a double rocker: the crank doesn't go round */
    fixture f = build_four_bar(h);
    int driver = fixture_coordinate(&f, "J0");
    found r = find(&f, &driver, 1);
    assert_int_equal(r.modes.count, 2);
    assert_int_equal(r.circuits.gap, KM_CIRCUIT_GAP_NONE);
    assert_int_equal(r.circuits.freedom, 1);
    assert_int_equal(r.circuits.count, is_grashof ? 2 : 1);
    assert_int_equal(r.circuits.circuit[0], 1);
    assert_int_equal(r.circuits.circuit[1], is_grashof ? 2 : 1);
    round += is_grashof;
    others += !is_grashof;
    release(&r);
    fixture_close(&f);
  }
  assert_true(round > 3 && others > 3);
}

/* A parallelogram becomes an antiparallelogram at its change points: all branches of a branch point are one circuit. */
static void branch_points_connect(void **state) {
  (void)state;
  const point h[4] = {0.0, at(0.4, 0.3), at(1.4, 0.3), 1.0};
  fixture f = build_four_bar(h);
  int driver = fixture_coordinate(&f, "J0");
  found r = find(&f, &driver, 1);
  assert_int_equal(r.modes.count, 2);
  assert_int_equal(r.circuits.count, 1);
  assert_int_equal(r.circuits.gap, KM_CIRCUIT_GAP_NONE);
  release(&r);
  fixture_close(&f);
}

/* ---- The double butterfly. */

/* Its six modes are in four circuits. An independent program followed them by Newton's method on the complex equations
 * of the loops, in steps of 4e-3. */
static void double_butterfly_has_four_circuits(void **state) {
  (void)state;
  fixture f = fixture_open("../tests/cli/models/butterfly_linkage");
  int driver = fixture_coordinate(&f, "J");
  assert_int_equal(km_state_move_to(f.mechanism, f.state, &(km_hold){driver, 0.0}, 1, NULL), KM_OK);
  found r = find(&f, &driver, 1);
  const double first[] = {0.910841, 1.5848, 2.7582, 3.14048, 3.32632, 3.33573}; /* angle A of the modes in order */
  const int circuit[] = {1, 1, 2, 2, 3, 4};
  assert_true(r.modes.is_complete);
  assert_int_equal(r.modes.count, 6);
  assert_int_equal(r.circuits.count, 4);
  for (int i = 0; i < 6; ++i) {
    double a = r.modes.coordinates[i * f.model->coordinate_count + fixture_coordinate(&f, "A")];
    assert_near(a, first[i], 1e-5);
    assert_int_equal(r.circuits.circuit[i], circuit[i]);
  }
  release(&r);
  fixture_close(&f);
}

/* ---- Ends of curves, and questions without an answer. */

/* A slide along a hinged arm carries a pin that moves along a line: its curve goes to infinity in both senses. The arm
 * points to the pin or away from it, and neither curve meets the other. */
static void a_curve_ends_at_infinity(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"arm\"}, {\"name\": "
      "\"block\"}, {\"name\": \"cart\"}], \"joints\": [{\"name\": \"H\", \"type\": \"revolute\", \"bodies\": [\"fixed\", "
      "\"arm\"], \"at\": [0, 0]}, {\"name\": \"S\", \"type\": \"prismatic\", \"bodies\": [\"arm\", \"block\"], \"at\": "
      "[0.3, 1], \"axis\": [0.3, 1]}, {\"name\": \"R\", \"type\": \"revolute\", \"bodies\": [\"block\", \"cart\"], "
      "\"at\": [0.3, 1]}, {\"name\": \"X\", \"type\": \"prismatic\", \"bodies\": [\"fixed\", \"cart\"], \"at\": [0.3, 1], "
      "\"axis\": [1, 0]}]}]}");
  int driver = fixture_coordinate(&f, "X");
  found r = find(&f, &driver, 1);
  assert_int_equal(r.modes.count, 2);
  assert_int_equal(r.circuits.gap, KM_CIRCUIT_GAP_NONE);
  assert_int_equal(r.circuits.count, 2);
  release(&r);
  fixture_close(&f);
}

/* Each mode of a structure is a circuit of its own. Several freedoms and self-motions have no answer. */
static void other_freedoms(void **state) {
  (void)state;
  fixture f = fixture_open("../tests/cli/models/butterfly");
  found r = find(&f, NULL, 0);
  assert_int_equal(r.circuits.freedom, 0);
  assert_int_equal(r.circuits.count, r.modes.count);
  for (int i = 0; i < r.modes.count; ++i)
    assert_int_equal(r.circuits.circuit[i], i + 1);
  release(&r);
  fixture_close(&f);

  f = fixture_open("stewart");
  const char *const legs[] = {"P1", "P2", "P3", "P4", "P5", "P6"};
  int locked[6];
  for (int k = 0; k < 6; ++k)
    locked[k] = fixture_coordinate(&f, legs[k]);
  r = find(&f, locked, 6);
  assert_int_equal(r.circuits.gap, KM_CIRCUIT_GAP_FREEDOMS);
  assert_int_equal(r.circuits.freedom, 6);
  assert_int_equal(r.circuits.count, 0);
  assert_int_equal(r.circuits.circuit[0], 0);
  release(&r);
  fixture_close(&f);

  f = fixture_open("peaucellier");
  locked[0] = km_sweep_plan_default(f.model).coordinate;
  r = find(&f, locked, 1);
  assert_int_equal(r.circuits.gap, KM_CIRCUIT_GAP_SELF_MOTION);
  assert_int_equal(r.circuits.count, 0);
  release(&r);
  fixture_close(&f);

  f = fixture_open("rssr");
  locked[0] = fixture_coordinate(&f, "B[0]");
  r = find(&f, locked, 1);
  assert_int_equal(r.circuits.gap, KM_CIRCUIT_GAP_BALL);
  release(&r);
  fixture_close(&f);
}

static bool stop_at_once(void *context, double done) {
  (void)context;
  (void)done;
  return false;
}

static void refusals(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  int driver = 0;
  km_all_modes_def def = {.locked = &driver, .locked_count = 1};
  found r = find(&f, &driver, 1);
  km_mode_circuits circuits;
  km_error error;
  assert_int_equal(km_mode_circuits_find(f.mechanism, f.state, &def, &r.modes, stop_at_once, NULL, &circuits, &error),
                   KM_CANCELLED);
  assert_int_equal(circuits.gap, KM_CIRCUIT_GAP_STOPPED);
  km_mode_circuits_free(&circuits);
  assert_int_equal(km_mode_circuits_find(f.mechanism, f.state, &def, NULL, NULL, NULL, &circuits, &error), KM_USAGE);
  km_mode_circuits_free(&circuits);
  driver = 99;
  assert_int_equal(km_mode_circuits_find(f.mechanism, f.state, &def, &r.modes, NULL, NULL, &circuits, &error),
                   KM_USAGE);
  km_mode_circuits_free(&circuits);
  assert_string_equal(km_circuit_gap_name(KM_CIRCUIT_GAP_LOST), "lost");
  assert_string_equal(km_circuit_gap_name((km_circuit_gap)77), "");
  release(&r);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(six_bars_as_followed_in_closed_form),
                                     cmocka_unit_test(four_bars_by_grashof),
                                     cmocka_unit_test(branch_points_connect),
                                     cmocka_unit_test(double_butterfly_has_four_circuits),
                                     cmocka_unit_test(a_curve_ends_at_infinity),
                                     cmocka_unit_test(other_freedoms),
                                     cmocka_unit_test(refusals)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
