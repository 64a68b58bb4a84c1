/* Meshes of solids with known masses. */
#include "support/solids.h"

#include "support/support.h"

km_mesh *solid_prism(int n, double r, double h, double turn) {
  km_mesh *m = km_mesh_create(2 * n + 2, 4 * n);
  int bottom = 2 * n, top = 2 * n + 1;
  m->vertices[bottom] = (km_vec3){0, 0, -0.5 * h};
  m->vertices[top] = (km_vec3){0, 0, 0.5 * h};
  for (int i = 0; i < n; ++i) {
    double a = turn + 2.0 * solid_pi * i / n;
    int next = (i + 1) % n;
    m->vertices[i] = (km_vec3){r * cos(a), r * sin(a), -0.5 * h};
    m->vertices[n + i] = (km_vec3){r * cos(a), r * sin(a), 0.5 * h};
    m->triangles[4 * i] = (km_triangle){.corner = {bottom, next, i}};
    m->triangles[4 * i + 1] = (km_triangle){.corner = {top, n + i, n + next}};
    m->triangles[4 * i + 2] = (km_triangle){.corner = {i, next, n + next}};
    m->triangles[4 * i + 3] = (km_triangle){.corner = {i, n + next, n + i}};
  }
  return m;
}

km_mesh *solid_box(double a, double b, double c) {
  km_mesh *m = solid_prism(4, sqrt(0.5), 1.0, 0.25 * solid_pi);
  for (int i = 0; i < m->vertex_count; ++i) {
    km_vec3 *v = &m->vertices[i];
    *v = (km_vec3){a * v->x, b * v->y, c * v->z};
  }
  return m;
}

km_mass_properties solid_weigh(const km_mesh *mesh) {
  km_mass_properties p;
  km_mesh_faults faults;
  km_error error;
  assert_int_equal(km_mesh_check(mesh, &faults, &error), KM_OK);
  assert_int_equal(faults.open_edges, 0);
  assert_int_equal(faults.mixed_edges, 0);
  if (km_mass_properties_of(mesh, &p, &error))
    fail_msg("%s", error.text);
  return p;
}

km_rotation solid_turn(double x, double y, double z) {
  km_rotation r = km_rotation_identity();
  const double angles[3] = {x, y, z};
  for (int k = 0; k < 3; ++k)
    r = km_rotation_about_axis(&r, k, cos(angles[k]), sin(angles[k]));
  return r;
}

void solid_move(km_mesh *m, const km_rotation *R, km_vec3 by) {
  for (int i = 0; i < m->vertex_count; ++i)
    m->vertices[i] = km_vec3_add(km_rotate(R, m->vertices[i]), by);
}
