/* Shapes of bodies: what they weigh against closed forms, and their meshes against the solids that they stand for. */
#include "support/support.h"

#include "exchange/mesh/shape_meshes.h"
#include "kmech/report.h"
#include "model/geometry/mass_properties.h"

#include <math.h>
#include <string.h>

static const char model[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"shapes\": ["
    "{\"box\": [1, 2, 3], \"T\": [5, 0, 0], \"R\": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], \"density\": 2},"
    "{\"sphere\": 0.5, \"T\": [0, 1, 0], \"color\": [1, 0, 0]},"
    "{\"cylinder\": [0.5, 2], \"T\": [-1, 0, 0], \"density\": 3, \"color\": [0, 0.5, 1, 0.25]},"
    "{\"capsule\": [0.5, 2]}]}],"
    " \"joints\": [{\"name\": \"J\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}";

/* 12 of the box, turned by 90° about z, and 1.5 π of the cylinder; the others have no density. */
static void densities_weigh(void **unused) {
  (void)unused;
  fixture f = fixture_read(model);
  const km_model_body *b = &f.model->bodies[1];
  const double box = 12.0, round = 1.5 * M_PI, sum = box + round, x = (5 * box - round) / sum;
  assert_int_equal(f.model->shape_count, 4);
  assert_near(b->mass, sum, 1e-14 * sum);
  assert_near(b->center_of_mass.x, x, 1e-14);
  assert_near(b->center_of_mass.y, 0.0, 1e-15);
  const double along = box * (5 - x) * (5 - x) + round * (1 + x) * (1 + x);
  /* box: m/12 (a² + b²); cylinder: m r²/2 about its axis, m (3 r² + h²)/12 across */
  assert_near(b->inertia[0], box / 12 * (1 + 9) + round / 12 * (0.75 + 4), 1e-13 * along);
  assert_near(b->inertia[1], box / 12 * (4 + 9) + round / 12 * (0.75 + 4) + along, 1e-14 * along);
  assert_near(b->inertia[2], box / 12 * (1 + 4) + round * 0.125 + along, 1e-14 * along);
  assert_near(f.model->shapes[1].color[3], 1.0, 0.0);
  assert_near(f.model->shapes[2].color[3], 0.25, 0.0);
  fixture_close(&f);
}

/* Polyhedra with their corners on the surface: closed, outwards, and a little smaller than the solid: by less than
 * 1 − (sin φ/φ)², φ half a facet's angle, for 32 facets and arcs of 90°/8. */
static void meshes_stand_for_solids(void **unused) {
  (void)unused;
  fixture f = fixture_read(model);
  for (int s = 0; s < f.model->shape_count; ++s) {
    const km_model_shape *shape = &f.model->shapes[s];
    km_mesh *mesh;
    km_mesh_faults faults;
    km_mass_properties found;
    km_mass exact;
    assert_int_equal(km_shape_mesh(f.model, shape, &mesh, NULL), KM_OK);
    assert_int_equal(km_mesh_check(mesh, &faults, NULL), KM_OK);
    assert_int_equal(faults.open_edges + faults.mixed_edges, 0);
    assert_int_equal(km_mass_properties_of(mesh, &found, NULL), KM_OK);
    assert_false(found.inside_out);
    assert_true(km_shape_solid(shape, &exact));
    double ratio = found.volume / exact.mass, least = shape->kind == KM_SHAPE_BOX ? 1.0 - 1e-14 : 1.0 - 0.02;
    assert_true(ratio >= least && ratio <= 1.0 + 1e-14);
    assert_near(km_vec3_norm(km_vec3_sub(found.center, exact.center)), 0.0, 1e-12);
    km_mesh_free(mesh);
  }
  km_meshes *meshes;
  assert_int_equal(km_model_read_meshes(f.model, &meshes, NULL), KM_OK);
  assert_non_null(meshes->items[1]);
  km_meshes_free(meshes);
  fixture_close(&f);
}

static void robots_bring_shapes(void **unused) {
  (void)unused;
  static const char *const texts[] = {
      "<robot name='r'><material name='red'><color rgba='1 0 0 1'/></material><link name='base'/><link name='b'>"
      "<visual><origin xyz='1 2 3'/><geometry><box size='1 2 3'/></geometry><material name='red'/></visual>"
      "<visual><geometry><cylinder radius='0.5' length='2'/></geometry></visual>"
      "<visual><geometry><mesh filename='m.stl' scale='0.001 0.001 0.001'/></geometry></visual></link>"
      "<joint name='J' type='continuous'><parent link='base'/><child link='b'/></joint></robot>",
      "<mujoco><asset><mesh name='m' file='m.stl' scale='0.001 0.001 0.001'/></asset><worldbody><geom size='1'/>"
      "<body name='b'><joint name='J'/><geom type='box' size='0.5 1 1.5' pos='1 2 3' rgba='1 0 0 1'/>"
      "<geom type='cylinder' size='0.5 1'/><geom type='mesh' mesh='m' mass='0'/><geom size='1' group='3'/>"
      "</body></worldbody></mujoco>",
      "<sdf version='1.9'><model name='r'><link name='b'><visual name='v'><pose>1 2 3 0 0 0</pose><geometry><box>"
      "<size>1 2 3</size></box></geometry><material><diffuse>1 0 0 1</diffuse></material></visual><visual name='w'>"
      "<geometry><cylinder><radius>0.5</radius><length>2</length></cylinder></geometry></visual><visual name='x'>"
      "<geometry><mesh><uri>m.stl</uri><scale>0.001 0.001 0.001</scale></mesh></geometry></visual></link></model></sdf>"};
  for (int i = 0; i < 3; ++i) {
    km_model *m;
    km_error error;
    if (km_model_read(texts[i], strlen(texts[i]), NULL, &m, &error))
      fail_msg("%s", error.text);
    assert_int_equal(m->shape_count, 3);
    const km_model_shape *s = m->shapes;
    assert_string_equal(m->bodies[s[0].body].name, "b");
    assert_int_equal(s[0].kind, KM_SHAPE_BOX);
    for (int k = 0; k < 3; ++k)
      assert_near(s[0].size[k], k + 1.0, 1e-15);
    assert_near(s[0].pose.p.z, 3.0, 1e-15);
    assert_near(s[0].color[0], 1.0, 0.0);
    assert_near(s[0].color[3], 1.0, 0.0);
    assert_int_equal(s[1].kind, KM_SHAPE_CYLINDER);
    assert_near(s[1].size[0], 0.5, 0.0);
    assert_near(s[1].size[1], 2.0, 0.0);
    assert_true(s[1].color[3] < 0.0);
    assert_int_equal(s[2].kind, KM_SHAPE_OF_MESH);
    assert_string_equal(s[2].mesh, "m.stl");
    assert_near(s[2].scale[2], 0.001, 0.0);
    km_model_free(m);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(densities_weigh), cmocka_unit_test(meshes_stand_for_solids),
                                     cmocka_unit_test(robots_bring_shapes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
