/* Octahedra of eight rigid plates hinged along their edges. Those in general position are rigid (theorems of Cauchy
 * and Gluck); Bricard's (1897), symmetric to a line or a plane, are flexible with self-intersections. */
#include "support/hinges.h"
#include "support/laws.h"
#include "support/random_mechanism.h"
#include "support/support.h"

#include "kmech/mobility.h"

enum { EDGES = 12, MADE = 20, SIDES = 2 };

/* Corners are opposite in pairs; a plate has one of each pair: bit k of its number. `mirrored`: pairs whose corners
 * the symmetry swaps, the others' lie on its plane. */
typedef struct octahedron {
  km_vec3 corner[3][SIDES];
  unsigned mirrored;
} octahedron;

static km_vec3 drawn(randomness *r) {
  return (km_vec3){uniform(r, 0.3, 1.3), uniform(r, -1.0, 1.0), uniform(r, -1.0, 1.0)};
}

static octahedron general(randomness *r) {
  octahedron o = {.mirrored = 0};
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < SIDES; ++side)
      o.corner[k][side] = drawn(r);
  return o;
}

/* Symmetric to the z axis. */
static octahedron symmetric_to_a_line(randomness *r) {
  octahedron o = {.mirrored = 7};
  for (int k = 0; k < 3; ++k) {
    km_vec3 p = o.corner[k][0] = drawn(r);
    o.corner[k][1] = (km_vec3){-p.x, -p.y, p.z};
  }
  return o;
}

/* Symmetric to the plane x = 0. */
static octahedron symmetric_to_a_plane(randomness *r) {
  octahedron o = {.mirrored = 3};
  for (int k = 0; k < 3; ++k) {
    km_vec3 p = o.corner[k][0] = drawn(r);
    o.corner[k][1] = (km_vec3){-p.x, p.y, p.z};
  }
  o.corner[2][0].x = o.corner[2][1].x = 0.0;
  o.corner[2][1].y -= 1.5;
  return o;
}

/* The hinge between plates that differ in pair k of corners lies along the edge of the corners that they share.
 * twin: that onto which the symmetry maps it. */
static fixture build(const octahedron *o, int twin[EDGES]) {
  int edge_of[8][3], plate_of[EDGES], pair_of[EDGES];
  hinges h = {0};
  km_text text = {0};
  for (int plate = 0; plate < 8; ++plate)
    for (int k = 0; k < 3; ++k) {
      int other = plate ^ 1 << k, a = (k + 1) % 3, b = (k + 2) % 3;
      if (other < plate)
        continue;
      km_vec3 from = o->corner[a][plate >> a & 1], to = o->corner[b][plate >> b & 1];
      plate_of[h.count] = plate;
      pair_of[h.count] = k;
      edge_of[plate][k] = edge_of[other][k] = h.count;
      hinges_add(&h, "Rz", plate, other, from, km_vec3_sub(to, from));
    }
  assert_int_equal(h.count, EDGES);
  for (int e = 0; e < EDGES; ++e)
    twin[e] = edge_of[plate_of[e] ^ (int)o->mirrored][pair_of[e]];
  hinges_write(&h, &text, 0.0);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* Eight plates with twelve hinges have −18 freedoms by count. */
static void judge(octahedron o, int freedom) {
  int twin[EDGES];
  fixture f = build(&o, twin);
  km_mobility there;
  km_finite_mobility found;
  km_mobility_compute(f.mechanism, f.state, &there);
  assert_int_equal(there.kutzbach, -18);
  assert_int_equal(there.mobility, freedom);
  assert_int_equal(there.redundant_constraints, 18 + freedom);
  for (int e = 0; e < EDGES; ++e)
    assert_near(km_mobility_number(f.state, e), km_mobility_number(f.state, twin[e]), 1e-9);
  assert_int_equal(km_finite_mobility_find(f.mechanism, f.state, NULL, NULL, &found, NULL), KM_OK);
  assert_int_equal(found.mobility, freedom);
  km_finite_mobility_free(&found);
  fixture_close(&f);
}

static void general_octahedra_stand(void **state) {
  (void)state;
  randomness r = {1};
  for (int i = 0; i < MADE; ++i)
    judge(general(&r), 0);
}

static void bricards_octahedra_move(void **state) {
  (void)state;
  randomness r = {2};
  for (int i = 0; i < MADE; ++i) {
    judge(symmetric_to_a_line(&r), 1);
    judge(symmetric_to_a_plane(&r), 1);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(general_octahedra_stand),
                                     cmocka_unit_test(bricards_octahedra_move)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
