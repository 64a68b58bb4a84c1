/* Links of SDFormat that are weighed by their collisions, and those of included robots of URDF. */
#include "support/robots.h"

#include "base/file.h"
#include "kmech/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Densities of collisions before that of the link before that of water; by hand: a box of 2 × 1 × 1 of 500 with its
 * centre at 1, and a ball of radius 1 of 3 at -5, both turned with the link; the same scaled to 10 kg; a cone a
 * quarter of its height below its middle. */
static void links_weigh_what_their_collisions_weigh(void **unused) {
  (void)unused;
  static const char text[] =
      "<sdf version='1.11'><model name='m'><link name='l'><inertial auto='true'><density>3</density><pose>9 9 9 0 0 0</pose>"
      "</inertial><collision name='a'><density>500</density><pose>1 0 0 0 0 0</pose><geometry><box><size>2 1 1</size></box>"
      "</geometry></collision><collision name='b'><pose>-5 0 0 1 0 0</pose><geometry><sphere><radius>1</radius></sphere>"
      "</geometry></collision></link><link name='k'><inertial auto='1'><mass>10</mass></inertial><collision name='c'><geometry>"
      "<cone><radius>1</radius><length>4</length></cone></geometry></collision></link><link name='w'><inertial auto='true'/>"
      "<collision name='d'><geometry><ellipsoid><radii>1 1 2</radii></ellipsoid></geometry></collision><collision name='e'>"
      "<geometry><plane/></geometry></collision></link></model></sdf>";
  km_model *model = read_as(text, false, NULL);
  double box = 1000, ball = 3 * 4.0 / 3.0 * M_PI, sum = box + ball, x = (box - 5 * ball) / sum;
  const km_model_body *b = &model->bodies[1];
  assert_near(b->mass / sum, 1, 1e-15);
  assert_near(b->center_of_mass.x, x, 1e-15);
  assert_near(b->inertia[0], box / 6 + 0.4 * ball, 1e-12);
  double far = box * (1 - x) * (1 - x) + ball * (5 + x) * (5 + x);
  assert_near(b->inertia[1], box * 5 / 12 + 0.4 * ball + far, 1e-12);
  assert_near(model->bodies[2].mass, 10, 1e-14);
  assert_near(model->bodies[2].center_of_mass.z, -1, 1e-15);
  assert_near(model->bodies[2].inertia[2], 3, 1e-14);
  assert_near(model->bodies[3].mass / (1000 * 8.0 / 3.0 * M_PI), 1, 1e-15);
  km_model_free(model);
}

static const char included_robot[] =
    "<robot name='arm'><material name='red'><color rgba='1 0 0 1'/></material><link name='base'/><link name='a'><inertial>"
    "<origin xyz='0.1 0.2 0.3' rpy='0 0 1'/><mass value='2'/><inertia ixx='1' iyy='2' izz='2.5' ixy='0.1'/></inertial>"
    "<visual><origin xyz='0 0 1'/><geometry><cylinder radius='1' length='2'/></geometry><material name='red'/></visual></link>"
    "<link name='b'/><joint name='a' type='revolute'><origin xyz='1 2 3' rpy='0.1 0.2 0.3'/><parent link='base'/>"
    "<child link='a'/><axis xyz='1 1 0'/><limit lower='-1' upper='2' effort='5' velocity='7'/><dynamics damping='4'/></joint>"
    "<joint name='B' type='continuous'><origin xyz='0 1 0'/><parent link='a'/><child link='b'/><mimic joint='a' "
    "multiplier='-2'/></joint></robot>";

/* A robot of URDF is the same where SDFormat includes it; joints may be called as links. */
static void robots_are_included(void **unused) {
  (void)unused;
  char folder[] = "/tmp/kmech_include.XXXXXX", path[64];
  km_text text = {0};
  km_error error;
  assert_non_null(mkdtemp(folder));
  km_text_add(&text, included_robot);
  snprintf(path, sizeof path, "%s/arm.urdf", folder);
  assert_int_equal(km_file_write(path, &text, NULL), KM_OK);
  km_text_free(&text);
  km_text_format(
      &text, "<sdf version='1.11'><model name='m'><include merge='true'><uri>%s</uri></include></model></sdf>", path);
  fixture urdf = open_text(included_robot), sdf;
  sdf = open_text(text.data);
  assert_int_equal(sdf.model->body_count, urdf.model->body_count);
  assert_int_equal(km_model_joint_count(sdf.model), km_model_joint_count(urdf.model));
  for (int b = 1; b < urdf.model->body_count; ++b) {
    const km_model_body *x = &urdf.model->bodies[b], *y = &sdf.model->bodies[body_of(sdf.model, x->name)];
    assert_near(y->mass, x->mass, 0.0);
    for (int k = 0; k < 6; ++k)
      assert_near(y->inertia[k], x->inertia[k], 0.0);
  }
  assert_int_equal(sdf.model->shape_count, 1);
  assert_near(sdf.model->shapes[0].color[0], 1.0, 0.0);
  int u = coordinate_of(urdf.model, "a"), s = coordinate_of(sdf.model, "a");
  assert_near(sdf.model->coordinates[s].low, urdf.model->coordinates[u].low, 0.0);
  assert_near(sdf.model->coordinates[s].high, urdf.model->coordinates[u].high, 0.0);
  go_to(&urdf, "a", 0.7);
  go_to(&sdf, "a", 0.7);
  assert_int_equal(km_assemble(urdf.mechanism, urdf.state, NULL, &error), KM_OK);
  assert_int_equal(km_assemble(sdf.mechanism, sdf.state, NULL, &error), KM_OK);
  km_frame_pose p = pose_of(&urdf, "b"), q = pose_of(&sdf, "b");
  for (int k = 0; k < 3; ++k)
    assert_near(q.p[k], p.p[k], 1e-14);
  for (int k = 0; k < 9; ++k)
    assert_near(q.R[k], p.R[k], 1e-14);
  unlink(path);
  rmdir(folder);
  km_text_free(&text);
  fixture_close(&urdf);
  fixture_close(&sdf);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(links_weigh_what_their_collisions_weigh),
                                     cmocka_unit_test(robots_are_included)};
  return cmocka_run_group_tests_name("robot_links", tests, NULL, NULL);
}
