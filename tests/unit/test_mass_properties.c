/* Mass properties of meshes against closed forms. */
#include "support/solids.h"
#include "support/support.h"

#include <math.h>
#include <string.h>

static km_vec3 on_sphere(km_vec3 v) {
  return km_vec3_scale(1.0 / km_vec3_norm(v), v);
}

/* An octahedron, each triangle parted into four `levels` times; vertices repeated, so that welding has work. */
static km_mesh *sphere(int levels) {
  km_mesh *m = km_mesh_create(24, 8);
  for (int t = 0; t < 8; ++t) {
    double x = t & 1 ? -1 : 1, y = t & 2 ? -1 : 1, z = t & 4 ? -1 : 1;
    bool mirrored = x * y * z < 0.0;
    m->vertices[3 * t] = (km_vec3){x, 0, 0};
    m->vertices[3 * t + (mirrored ? 2 : 1)] = (km_vec3){0, y, 0};
    m->vertices[3 * t + (mirrored ? 1 : 2)] = (km_vec3){0, 0, z};
    m->triangles[t] = (km_triangle){.corner = {3 * t, 3 * t + 1, 3 * t + 2}};
  }
  for (int l = 0; l < levels; ++l) {
    km_mesh *fine = km_mesh_create(12 * m->triangle_count, 4 * m->triangle_count);
    for (int t = 0; t < m->triangle_count; ++t) {
      km_vec3 c[6], *v = fine->vertices + 12 * t;
      for (int k = 0; k < 3; ++k)
        c[k] = m->vertices[m->triangles[t].corner[k]];
      for (int k = 0; k < 3; ++k)
        c[3 + k] = on_sphere(km_vec3_add(c[k], c[(k + 1) % 3]));
      const int parts[12] = {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5};
      for (int k = 0; k < 12; ++k) {
        v[k] = c[parts[k]];
        fine->triangles[4 * t + k / 3].corner[k % 3] = 12 * t + k;
      }
    }
    km_mesh_free(m);
    m = fine;
  }
  return m;
}

static void check_inertia(const double found[6], const double expected[6], double tolerance) {
  for (int k = 0; k < 6; ++k)
    assert_near(found[k], expected[k], tolerance);
}

static void a_box(void **state) {
  (void)state;
  km_mesh *m = solid_box(2, 3, 5);
  km_mass_properties p = solid_weigh(m);
  assert_near(p.volume, 30, 1e-13);
  assert_near(km_vec3_norm(p.center), 0, 1e-15);
  check_inertia(p.inertia, (double[6]){30 * 34 / 12.0, 30 * 29 / 12.0, 30 * 13 / 12.0, 0, 0, 0}, 1e-12);
  assert_false(p.inside_out);
  km_mesh_free(m);
}

/* The prism's own formulas hold for any n; a fine one is a cylinder. */
static void a_cylinder(void **state) {
  (void)state;
  const double r = 0.7, h = 2.5;
  static const int sides[] = {3, 5, 64, 4096};
  for (int i = 0; i < 4; ++i) {
    int n = sides[i];
    double angle = 2.0 * solid_pi / n, area = 0.5 * n * r * r * sin(angle),
           polar = area * r * r / 6.0 * (2.0 + cos(angle));
    double across = h * polar / 2.0 + area * h * h * h / 12.0;
    km_mesh *m = solid_prism(n, r, h, 0.3);
    km_mass_properties p = solid_weigh(m);
    assert_near(p.volume, area * h, 1e-12);
    check_inertia(p.inertia, (double[6]){across, across, h * polar, 0, 0, 0}, 1e-11);
    km_mesh_free(m);
    if (n == 4096)
      assert_near(p.inertia[2] / p.volume, 0.5 * r * r, 1e-6);
  }
}

/* Each refinement divides the error by four. */
static void a_sphere(void **state) {
  (void)state;
  double last[2] = {0};
  for (int levels = 2; levels < 6; ++levels) {
    km_mesh *m = sphere(levels);
    assert_true(km_mesh_weld(m));
    assert_int_equal(m->vertex_count, m->triangle_count / 2 + 2); /* Euler */
    km_mass_properties p = solid_weigh(m);
    double errors[2] = {4.0 / 3.0 * solid_pi - p.volume, 8.0 / 15.0 * solid_pi - p.inertia[0]};
    for (int k = 0; k < 2; ++k) {
      assert_true(errors[k] > 0.0);
      if (levels > 3)
        assert_near(last[k] / errors[k], 4.0, 0.1);
      last[k] = errors[k];
    }
    km_mesh_free(m);
  }
  assert_true(last[0] < 0.01);
}

/* A body 1 km off, turned: the inertia turns with it and keeps its digits. */
static void far_away(void **state) {
  (void)state;
  km_rotation R = solid_turn(0.4, -1.1, 0.8);
  const double own[3] = {34 * 30 / 12.0, 29 * 30 / 12.0, 13 * 30 / 12.0};
  km_vec3 far = {1000, -700, 300};
  km_mesh *m = solid_box(2, 3, 5);
  solid_move(m, &R, far);
  km_mass_properties p = solid_weigh(m);
  static const int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  double expected[6] = {0};
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 3; ++i) {
      const double axis[3] = {R.axis[i].x, R.axis[i].y, R.axis[i].z};
      expected[k] += own[i] * axis[pairs[k][0]] * axis[pairs[k][1]];
    }
  assert_near(p.volume, 30, 1e-10);
  assert_near(km_vec3_norm(km_vec3_sub(p.center, far)), 0, 1e-12);
  check_inertia(p.inertia, expected, 1e-9);
  km_mesh_free(m);
}

static void turn_round(km_triangle *t) {
  *t = (km_triangle){.corner = {t->corner[0], t->corner[2], t->corner[1]}};
}

static void inside_out(void **state) {
  (void)state;
  km_mesh *m = solid_box(2, 3, 5);
  km_vec3 far = {10, 20, 30};
  km_rotation none = km_rotation_identity();
  solid_move(m, &none, far);
  for (int t = 0; t < m->triangle_count; ++t)
    turn_round(&m->triangles[t]);
  km_mass_properties p = solid_weigh(m);
  assert_true(p.inside_out);
  assert_near(p.volume, 30, 1e-12);
  assert_near(km_vec3_norm(km_vec3_sub(p.center, far)), 0, 1e-13);
  check_inertia(p.inertia, (double[6]){85, 72.5, 32.5, 0, 0, 0}, 1e-11);
  km_mesh_free(m);
}

/* A box of 4 and, `away` from its middle, one of 2 that is inside out. */
static km_mesh *box_and_hole(double away) {
  km_mesh *parts[2] = {solid_box(4, 4, 4), solid_box(2, 2, 2)};
  km_mesh *out = km_mesh_create(2 * parts[0]->vertex_count, 2 * parts[0]->triangle_count);
  km_rotation none = km_rotation_identity();
  int vertices = 0, triangles = 0;
  solid_move(parts[1], &none, (km_vec3){away, 0, 0});
  for (int i = 0; i < 2; ++i) {
    for (int t = 0; t < parts[i]->triangle_count; ++t, ++triangles) {
      if (i == 1)
        turn_round(&parts[i]->triangles[t]);
      for (int k = 0; k < 3; ++k)
        out->triangles[triangles].corner[k] = vertices + parts[i]->triangles[t].corner[k];
    }
    for (int v = 0; v < parts[i]->vertex_count; ++v)
      out->vertices[vertices++] = parts[i]->vertices[v];
    km_mesh_free(parts[i]);
  }
  return out;
}

/* Within the box it is a hollow; so far beside it a body would have a negative moment of inertia. */
static void holes(void **state) {
  (void)state;
  km_mass mass;
  km_error error;
  km_mesh *hollow = box_and_hole(0.5), *beside = box_and_hole(20.0);
  assert_int_equal(km_mesh_weigh(hollow, "m", &mass, &error), KM_OK);
  assert_near(mass.mass, 56.0, 1e-12);
  assert_int_equal(km_mesh_weigh(beside, "m", &mass, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "m: a part of it is inside out"));
  km_mesh_free(hollow);
  km_mesh_free(beside);
}

static void faults(void **state) {
  (void)state;
  km_mesh_faults found;
  km_mesh *m = solid_prism(5, 1, 1, 0);
  const int whole = m->triangle_count;
  static const int open[] = {0, 3, 4, 5, 6}; /* the last four are a side's two halves and the lids' pieces beside it */
  for (int missing = 0; missing < 5; ++missing) {
    m->triangle_count = whole - missing;
    assert_int_equal(km_mesh_check(m, &found, NULL), KM_OK);
    assert_int_equal(found.open_edges, open[missing]);
    assert_int_equal(found.mixed_edges, 0);
  }
  m->triangle_count = whole;
  turn_round(&m->triangles[0]);
  assert_int_equal(km_mesh_check(m, &found, NULL), KM_OK);
  assert_int_equal(found.open_edges, 0);
  assert_int_equal(found.mixed_edges, 3);
  km_mesh_free(m);
}

static void no_volume(void **state) {
  (void)state;
  km_mass_properties p;
  km_error error;
  km_mesh *flat = solid_box(2, 3, 0), *none = km_mesh_create(0, 0);
  assert_int_equal(km_mass_properties_of(flat, &p, &error), KM_MODEL);
  assert_int_equal(km_mass_properties_of(none, &p, &error), KM_MODEL);
  assert_true(km_mesh_weld(none));
  km_mesh_free(flat);
  km_mesh_free(none);
  km_mesh_free(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_box),     cmocka_unit_test(a_cylinder), cmocka_unit_test(a_sphere),
      cmocka_unit_test(far_away),  cmocka_unit_test(inside_out), cmocka_unit_test(faults),
      cmocka_unit_test(no_volume), cmocka_unit_test(holes),
  };
  return cmocka_run_group_tests_name("mass_properties", tests, NULL, NULL);
}
