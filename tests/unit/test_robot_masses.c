/* Masses, springs and named frames of robot descriptions: numbers by hand, those of the MJCF compiler by MuJoCo
 * 2.2.2. */
#include "support/robots.h"

#include "kmech/base.h"
#include "kmech/exchange.h"
#include "model/geometry/mass_properties.h"
#include "model/model.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define IN_BODY(COMPILER, CONTENT)                                                                                     \
  "<mujoco><compiler angle='radian' " COMPILER "/><worldbody><body name='a'><joint name='j' axis='0 0 1'/>" CONTENT    \
  "</body></worldbody></mujoco>"

static void assert_mass(const char *text, double mass, const double inertia[6]) {
  km_model *model = read_as(text, false, NULL);
  const km_model_body *body = &model->bodies[body_of(model, "a")];
  assert_near(body->mass, mass, 1e-14 * mass);
  for (int k = 0; k < 6; ++k)
    assert_near(body->inertia[k], inertia[k], 1e-15);
  km_model_free(model);
}

/* Lower bounds apply to principal moments; invalid moments become their mean if requested; a body whose geoms have
 * no mass keeps its stated values. */
static void compilers_change_masses(void **unused) {
  (void)unused;
  assert_mass(
      IN_BODY("boundinertia='0.02'", "<inertial pos='0 0 0' mass='1' fullinertia='0.0505 0.0505 0.1 -0.0495 0 0'/>"),
      1.0, (const double[]){0.06, 0.06, 0.1, -0.04, 0.0, 0.0});
  assert_mass(
      IN_BODY("boundinertia='0.02' boundmass='2'", "<inertial pos='0 0 0' mass='1' diaginertia='0.01 0.03 0.03'/>"),
      2.0, (const double[]){0.02, 0.03, 0.03, 0.0, 0.0, 0.0});
  assert_mass(IN_BODY("balanceinertia='true'", "<inertial pos='0 0 0' mass='1' diaginertia='0.01 0.02 0.06'/>"), 1.0,
              (const double[]){0.03, 0.03, 0.03, 0.0, 0.0, 0.0});
  assert_mass(IN_BODY("balanceinertia='true'", "<inertial pos='0 0 0' mass='1' diaginertia='0.01 0.02 0.03'/>"), 1.0,
              (const double[]){0.01, 0.02, 0.03, 0.0, 0.0, 0.0});
  assert_mass(IN_BODY("inertiafromgeom='true' inertiagrouprange='3 4'",
                      "<inertial pos='0 0 0' mass='1' diaginertia='0.01 0.02 0.02'/><geom size='0.1' group='1'/>"),
              1.0, (const double[]){0.01, 0.02, 0.02, 0.0, 0.0, 0.0});
}

/* The axes are perpendicular, and the inertia is recovered from them. */
static void principal_axes_give_the_inertia(void **unused) {
  (void)unused;
  randomness r = {5};
  for (int i = 0; i < 200; ++i) {
    double inertia[6], moments[3], back[6], largest = 0.0;
    km_vec3 axes[3];
    for (int k = 0; k < 6; ++k) {
      inertia[k] = i % 7 == k ? 0.0 : uniform(&r, -1.0, 1.0);
      largest = fmax(largest, fabs(inertia[k]));
    }
    km_principal_axes(inertia, moments, axes);
    km_inertia_about(moments, axes, back);
    for (int k = 0; k < 6; ++k)
      assert_near(back[k], inertia[k], 1e-14 * largest);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        assert_near(km_vec3_dot(axes[a], axes[b]), a == b, 1e-14);
  }
}

static void assert_spring(const km_model *model, const char *label, double rest, double stiffness) {
  int c = coordinate_of(model, label), found = 0;
  for (int i = 0; i < model->module_count; ++i) {
    const km_model_module *spring = &model->modules[i];
    if (spring->input.coordinate != c)
      continue;
    ++found;
    assert_near(spring->law.coefficients[0], stiffness * rest, 1e-15);
    assert_near(spring->law.coefficients[1], -stiffness, 1e-15);
  }
  assert_int_equal(found, 1);
}

/* Springs of all coordinates; unsupported ones are reported. */
static void springs_are_read(void **unused) {
  (void)unused;
  static const char sdf[] =
      "<sdf version='1.9'><model name='m'><link name='base'/><link name='a'/><link name='b'/>"
      "<joint name='U' type='universal'><parent>base</parent><child>a</child><axis><xyz>1 0 0</xyz><dynamics>"
      "<spring_stiffness>2</spring_stiffness><spring_reference>0.5</spring_reference></dynamics></axis><axis2><xyz>0 1 0</xyz>"
      "<dynamics><spring_stiffness>3</spring_stiffness></dynamics></axis2></joint>"
      "<joint name='V' type='revolute2'><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz><dynamics>"
      "<spring_stiffness>4</spring_stiffness></dynamics></axis><axis2><xyz>0.6 0.8 0</xyz><dynamics>"
      "<spring_stiffness>5</spring_stiffness><spring_reference>-1</spring_reference></dynamics></axis2></joint></model></sdf>";
  km_model *model = read_as(sdf, false, NULL);
  assert_spring(model, "U[0]", 0.5, 2.0);
  assert_spring(model, "U[1]", 0.0, 3.0);
  assert_spring(model, "V", 0.0, 4.0);
  assert_spring(model, "V:2", -1.0, 5.0);
  km_model_free(model);
  static const char mjcf[] =
      "<mujoco><compiler angle='radian'/><worldbody><body name='a'><joint name='B' type='ball' stiffness='3'/><geom size='0.1'/>"
      "<body name='b'><joint name='H' stiffness='2' springref='0.25'/><geom size='0.1'/></body>"
      "<body name='c'><joint name='T' springdamper='0.5 1'/><geom size='0.1'/></body></body>"
      "<body name='d'><joint name='F' type='free' damping='0.3' stiffness='1'/><geom size='0.1'/></body></worldbody></mujoco>";
  km_messages *messages = km_messages_create();
  model = read_as(mjcf, false, messages);
  for (int k = 0; k < 3; ++k)
    assert_spring(model, (const char *[]){"B[0]", "B[1]", "B[2]"}[k], 0.0, 3.0);
  assert_spring(model, "H", 0.25, 2.0);
  assert_int_equal(model->module_count, 4);
  int free_one = coordinate_of(model, "F[0]");
  for (int k = 0; k < 6; ++k)
    assert_near(model->coordinates[free_one + k].damping, 0.3, 0.0);
  assert_int_equal(km_messages_count(messages), 2);
  assert_non_null(strstr(km_messages_text(messages, 0), "springs and dampers by time constants left out: 1, \"T\""));
  assert_non_null(
      strstr(km_messages_text(messages, 1), "springs, rotors and friction of free joints left out: 1, \"F\""));
  km_messages_free(messages);
  km_model_free(model);
}

/* Springs are preserved by each format that has them, those of ball joints by MJCF; omitted ones are reported. */
static void springs_are_written(void **unused) {
  (void)unused;
  static const char mjcf[] =
      "<mujoco><compiler angle='radian'/><worldbody><body name='a'><joint name='B' type='ball' stiffness='3'/><geom size='0.1'/>"
      "<body name='b'><joint name='H' stiffness='2' springref='0.25'/><geom size='0.1'/></body></body></worldbody></mujoco>";
  static const struct {
    km_model_format format;
    int springs, told;
  } written[] = {{KM_FORMAT_JSON, 4, 0}, {KM_FORMAT_MJCF, 4, 0}, {KM_FORMAT_SDF, 1, 3}, {KM_FORMAT_URDF, 0, 4}};
  km_model *model = read_as(mjcf, false, NULL);
  for (size_t i = 0; i < sizeof written / sizeof *written; ++i) {
    km_messages *messages = km_messages_create();
    km_bytes bytes;
    assert_int_equal(km_model_write_as(model, written[i].format, NULL, NULL, messages, &bytes, NULL), KM_OK);
    km_model *back = read_as(bytes.data, false, NULL);
    char told[64];
    bool found = false;
    snprintf(told, sizeof told, "springs not written: %d", written[i].told);
    for (size_t k = 0; k < km_messages_count(messages); ++k)
      found = found || strstr(km_messages_text(messages, k), told);
    assert_int_equal(found, written[i].told > 0);
    assert_int_equal(back->module_count, written[i].springs);
    if (written[i].springs > 0)
      assert_spring(back, "H", 0.25, 2.0);
    for (int k = 0; k < 3 && written[i].springs > 1; ++k)
      assert_spring(back, (const char *[]){"B[0]", "B[1]", "B[2]"}[k], 0.0, 3.0);
    km_model_free(back);
    km_bytes_free(&bytes);
    km_messages_free(messages);
  }
  km_model_free(model);
}

/* A name is kept where the place is the body's own origin; a site between two ends has the pose that MuJoCo gives
 * it. */
static void named_places_are_read(void **unused) {
  (void)unused;
  int frame;
  km_frame_pose pose;
  fixture f =
      open_text("<sdf version='1.9'><model name='m'><link name='a'/><frame name='f' attached_to='a'/></model></sdf>");
  assert_int_equal(km_model_find_frame(f.model, (const char *const[]){"a", "f"}, 2, &frame, NULL), KM_OK);
  fixture_close(&f);
  f = open_text(IN_BODY(
      "",
      "<geom size='0.1'/><site name='own'/><site name='s' type='capsule' size='0.01' fromto='0.3 0.2 0.1 0 0 0'/>"));
  assert_int_equal(km_model_find_frame(f.model, (const char *const[]){"a", "own"}, 2, &frame, NULL), KM_OK);
  assert_int_equal(km_model_find_frame(f.model, (const char *const[]){"a", "s"}, 2, &frame, NULL), KM_OK);
  km_poses_compute(f.mechanism, f.state);
  assert_int_equal(km_frame_place(f.mechanism, f.state, frame, &pose, NULL), KM_OK);
  const double place[3] = {0.15, 0.1, 0.05}, along[3] = {0.801784, 0.534522, 0.267261};
  for (int k = 0; k < 3; ++k) {
    assert_near(pose.p[k], place[k], 1e-15);
    assert_near(pose.R[3 * k + 2], along[k], 1e-6); /* as MuJoCo prints it */
  }
  fixture_close(&f);
}

static int errors_about(const char *text, const char *words) {
  km_model *model;
  km_messages *messages = km_messages_create();
  int found = 0;
  assert_int_equal(km_model_read(text, strlen(text), messages, &model, NULL), KM_MODEL);
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    found += strstr(km_messages_text(messages, i), words) != NULL;
  km_messages_free(messages);
  return found;
}

/* Each unknown class is reported once, also that of children. */
static void missing_classes_are_told_once(void **unused) {
  (void)unused;
  assert_int_equal(errors_about("<mujoco><default><default class='arm'/></default><worldbody><body><joint class='amr'/>"
                                "<joint class='amr'/><geom class='amr' size='0.1'/></body></worldbody></mujoco>",
                                "the class \"amr\" isn't there"),
                   1);
  assert_int_equal(
      errors_about("<mujoco><worldbody><body childclass='nope'><joint/><geom size='0.1'/></body></worldbody></mujoco>",
                   "the class \"nope\" isn't there"),
      1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(compilers_change_masses), cmocka_unit_test(principal_axes_give_the_inertia),
      cmocka_unit_test(springs_are_read),        cmocka_unit_test(springs_are_written),
      cmocka_unit_test(named_places_are_read),   cmocka_unit_test(missing_classes_are_told_once)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
