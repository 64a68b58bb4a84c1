/* Convex hulls against what they must be: around all points, closed, and of known volume. */
#include "support/solids.h"
#include "support/support.h"

#include "model/geometry/hull.h"

#include <math.h>
#include <string.h>

static km_mesh *hull_of(const km_mesh *points) {
  km_mesh *hull;
  km_error error;
  if (km_mesh_hull(points, &hull, &error))
    fail_msg("%s", error.text);
  return hull;
}

/* Every point is behind every face, to the grid's step over the size. */
static void assert_around(const km_mesh *hull, const km_mesh *points, double size) {
  km_mesh_faults faults;
  assert_int_equal(km_mesh_check(hull, &faults, NULL), KM_OK);
  assert_int_equal(faults.open_edges, 0);
  assert_int_equal(faults.mixed_edges, 0);
  assert_int_equal(hull->triangle_count, 2 * hull->vertex_count - 4); /* Euler, of triangles */
  for (int t = 0; t < hull->triangle_count; ++t) {
    const int *c = hull->triangles[t].corner;
    km_vec3 a = hull->vertices[c[0]], u = km_vec3_sub(hull->vertices[c[1]], a),
            v = km_vec3_sub(hull->vertices[c[2]], a);
    km_vec3 n = km_vec3_cross(u, v);
    double area = km_vec3_norm(n), long_side = fmax(km_vec3_norm(u), km_vec3_norm(v));
    for (int p = 0; p < points->vertex_count; ++p) /* a normal of a thin face turns by the step over its height */
      assert_true(km_vec3_dot(n, km_vec3_sub(points->vertices[p], a)) <= 8e-9 * size * (area + size * long_side));
  }
}

static void points_in_a_ball(void **unused) {
  (void)unused;
  randomness r = {7};
  for (int n = 4; n < 400; n += 36) {
    km_mesh *points = km_mesh_create(n, 0);
    for (int i = 0; i < n; ++i)
      points->vertices[i] = (km_vec3){uniform(&r, -1, 1), uniform(&r, -2, 2), uniform(&r, -30, 3)};
    km_mesh *hull = hull_of(points);
    assert_around(hull, points, 33.0);
    km_mesh_free(hull);
    km_mesh_free(points);
  }
}

/* A grid: most points are on faces and edges, none but the eight corners stands out. */
static void points_of_a_box(void **unused) {
  (void)unused;
  enum { SIDE = 9 };
  km_mesh *points = km_mesh_create(SIDE * SIDE * SIDE, 0);
  km_rotation R = solid_turn(0.3, -1.1, 0.7);
  for (int i = 0; i < points->vertex_count; ++i) {
    km_vec3 p = {3.0 * (i % SIDE), 2.0 * (i / SIDE % SIDE), 0.5 * (i / SIDE / SIDE)};
    points->vertices[i] = km_vec3_add((km_vec3){100, -50, 7}, km_rotate(&R, p));
  }
  km_mesh *hull = hull_of(points);
  km_mass_properties p = solid_weigh(hull);
  double volume = pow(SIDE - 1, 3) * 3.0 * 2.0 * 0.5;
  assert_near(p.volume / volume, 1, 1e-8); /* the grid of 2^30 steps */
  assert_false(p.inside_out);
  assert_around(hull, points, 30.0);
  km_mesh_free(hull);
  km_mesh_free(points);
}

/* Straight on the axes every sign is exact, and so is the volume; points that are given twice don't matter. */
static void a_cross_becomes_an_octahedron(void **unused) {
  (void)unused;
  km_mesh *points = km_mesh_create(14, 0);
  for (int i = 0; i < 12; ++i) {
    double x[3] = {0};
    x[i % 3] = i / 3 % 2 ? 1 : -1;
    points->vertices[i] = km_vec3_from_array(x);
  }
  km_mesh *hull = hull_of(points);
  assert_int_equal(hull->triangle_count, 8);
  assert_int_equal(hull->vertex_count, 6);
  assert_near(solid_weigh(hull).volume, 4.0 / 3.0, 1e-15);
  km_mesh_free(hull);
  km_mesh_free(points);
}

static void flat_points_have_none(void **unused) {
  (void)unused;
  km_mesh *points = km_mesh_create(50, 0), *hull;
  km_error error;
  for (int i = 0; i < 50; ++i)
    points->vertices[i] = (km_vec3){i % 7, i / 7, 2};
  assert_int_equal(km_mesh_hull(points, &hull, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "in a plane"));
  points->vertex_count = 0;
  assert_int_equal(km_mesh_hull(points, &hull, &error), KM_MODEL);
  assert_null(hull);
  points->vertex_count = 50;
  km_mesh_free(points);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(points_in_a_ball), cmocka_unit_test(points_of_a_box),
                                     cmocka_unit_test(a_cross_becomes_an_octahedron),
                                     cmocka_unit_test(flat_points_have_none)};
  return cmocka_run_group_tests_name("hull", tests, NULL, NULL);
}
