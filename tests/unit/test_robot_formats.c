/* Peculiarities of robot formats: defaults, angles, masses, copies, screws, gears. */
#include "support/robots.h"

#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "exchange/robot/robot.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define HALF_TURN_4 "1.5707963267948966"

static void defaults_come_from_the_nearest_class(void **unused) {
  (void)unused;
  static const char text[] =
      "<mujoco><compiler angle='radian'/><default><joint damping='1' axis='0 0 1'/><default class='outer'>"
      "<joint damping='2'/><default class='inner'><joint range='-1 1'/></default></default></default><worldbody>"
      "<body name='a'><joint name='plain'/><body name='b' childclass='inner'><joint name='nested'/>"
      "<body name='c'><joint name='own' class='outer' damping='5'/></body></body></body></worldbody></mujoco>";
  km_model *model = read_as(text, false, NULL);
  const char *const labels[] = {"plain", "nested", "own"};
  const double damping[] = {1, 2, 5};
  for (int i = 0; i < 3; ++i) {
    const km_model_coordinate *c = &model->coordinates[coordinate_of(model, labels[i])];
    assert_near(c->damping, damping[i], 0.0);
    assert_int_equal(isfinite(c->low), i == 1);
  }
  km_model_free(model);
}

/* Euler angles: small letters turn about the moving axes, capitals about the fixed ones. */
static void euler_angles_follow_their_sequence(void **unused) {
  (void)unused;
  static const char format[] = "<mujoco><compiler angle='radian' eulerseq='%s'/><worldbody><body name='b' euler='%s'/>"
                               "</worldbody></mujoco>";
  char moving[300], fixed[300];
  snprintf(moving, sizeof moving, format, "zyx", "0.3 0.2 0.1");
  snprintf(fixed, sizeof fixed, format, "XYZ", "0.1 0.2 0.3");
  static const char rpy[] = "<robot name='r'><link name='w'/><link name='b'/><joint name='j' type='fixed'>"
                            "<origin rpy='0.1 0.2 0.3'/><parent link='w'/><child link='b'/></joint></robot>";
  const char *const texts[] = {moving, fixed, rpy};
  km_frame_pose pose[3];
  for (int i = 0; i < 3; ++i) {
    fixture f = open_text(texts[i]);
    pose[i] = pose_of(&f, "b");
    fixture_close(&f);
  }
  for (int k = 0; k < 9; ++k) {
    assert_near(pose[0].R[k], pose[2].R[k], 1e-15);
    assert_near(pose[1].R[k], pose[2].R[k], 1e-15);
  }
  assert_near(pose[2].R[6], -sin(0.2), 1e-15); /* Rz Ry Rx */
}

/* Mass and moments of a solid of revolution by Simpson's rule over its discs. */
static km_mass by_discs(double (*radius2)(double z), double end) {
  enum { STEPS = 20000 };
  km_mass sum = {0};
  double h = 2 * end / STEPS;
  for (int i = 0; i <= STEPS; ++i) {
    double z = -end + i * h, s = radius2(z), weight = (i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2) * h / 3;
    sum.mass += weight * M_PI * s;
    sum.inertia[2] += weight * M_PI * s * s / 2;
    sum.inertia[0] += weight * (M_PI * s * s / 4 + M_PI * s * z * z);
  }
  return sum;
}

static double capsule(double z) { /* radius 0.3, half length 0.5 */
  double over = fmax(fabs(z) - 0.5, 0.0);
  return fmax(0.09 - over * over, 0.0);
}

static double ellipsoid(double z) { /* half axes 0.3, 0.3, 0.8 */
  return 0.09 * (1 - z * z / 0.64);
}

static double cone(double z) { /* radius 0.3, half length 0.8 */
  double r = 0.15 * (1 - z / 0.8);
  return r * r;
}

static void solids_weigh_what_their_discs_weigh(void **unused) {
  (void)unused;
  const double half[3] = {0.3, 0.3, 0.8};
  const km_mass found[] = {km_solid_capsule(0.3, 0.5), km_solid_ellipsoid(half), km_solid_cone(0.3, 0.8)};
  const km_mass expected[] = {by_discs(capsule, 0.8), by_discs(ellipsoid, 0.8), by_discs(cone, 0.8)};
  for (int i = 0; i < 3; ++i) { /* Simpson's error: h⁴ times derivatives of size 100, and at the caps' edges h³ */
    assert_near(found[i].mass, expected[i].mass, 1e-9);
    double away = found[i].mass * found[i].center.z * found[i].center.z;
    assert_near(found[i].inertia[0] + away, expected[i].inertia[0], 1e-9);
    assert_near(found[i].inertia[2], expected[i].inertia[2], 1e-9);
  }
}

/* A box of 2 × 1 × 1 cut into two cubes is the box. */
static void geoms_add_up(void **unused) {
  (void)unused;
  static const char one[] = "<mujoco><worldbody><body name='b'><geom type='box' size='1 .5 .5' pos='1 0 0'/></body>"
                            "</worldbody></mujoco>";
  static const char two[] = "<mujoco><worldbody><body name='b'><geom type='box' size='.5 .5 .5' pos='.5 0 0'/>"
                            "<geom type='box' size='.5' fromto='1 0 0 2 0 0'/></body></worldbody></mujoco>";
  km_model *a = read_as(one, false, NULL), *b = read_as(two, false, NULL);
  assert_near(a->bodies[1].mass, 2000.0, 0.0);
  assert_near(b->bodies[1].mass, 2000.0, 1e-12);
  assert_near(b->bodies[1].center_of_mass.x, 1.0, 1e-15);
  for (int k = 0; k < 6; ++k)
    assert_near(a->bodies[1].inertia[k], b->bodies[1].inertia[k], 1e-12);
  km_model_free(a);
  km_model_free(b);
}

static void copies_stand_in_a_ring(void **unused) {
  (void)unused;
  static const char text[] =
      "<mujoco><worldbody><replicate count='4' euler='0 0 90'><body name='b' pos='1 0 0'><joint name='j'/>"
      "</body></replicate></worldbody></mujoco>";
  fixture f = open_text(text);
  assert_int_equal(km_model_body_count(f.model), 4);
  assert_planar(&f, "b0", 1, 0, 0);
  assert_planar(&f, "b1", 0, 1, M_PI / 2);
  assert_planar(&f, "b2", -1, 0, M_PI);
  coordinate_of(f.model, "j3");
  fixture_close(&f);
}

/* Axis of a joint for each way of stating its frame: x of the model, y of the child. */
static void axes_are_in_the_frame_that_is_told(void **unused) {
  (void)unused;
  static const char format[] =
      "<sdf version='%s'><model name='m'><link name='l'><pose>0 0 0 0 0 " HALF_TURN_4 "</pose></link>"
      "<joint name='j' type='prismatic'><parent>world</parent><child>l</child><axis><xyz%s>%s</xyz>%s</axis></joint>"
      "</model></sdf>";
  static const struct {
    const char *version, *attribute, *xyz, *more;
  } ways[] = {{"1.4", "", "1 0 0", ""},
              {"1.6", "", "0 -1 0", ""},
              {"1.6", "", "1 0 0", "<use_parent_model_frame>1</use_parent_model_frame>"},
              {"1.9", "", "0 -1 0", ""},
              {"1.9", " expressed_in='__model__'", "1 0 0", ""}};
  for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
    char text[700];
    snprintf(text, sizeof text, format, ways[i].version, ways[i].attribute, ways[i].xyz, ways[i].more);
    fixture f = open_text(text);
    go_to(&f, "j", 0.7);
    assert_planar(&f, "l", 0.7, 0, M_PI / 2);
    fixture_close(&f);
  }
}

static void a_missing_mass_is_a_kilogram(void **unused) {
  (void)unused;
  km_model *model = read_as("<sdf version='1.9'><model name='m'><link name='l'/></model></sdf>", false, NULL);
  assert_near(model->bodies[1].mass, 1.0, 0.0);
  assert_near(model->bodies[1].inertia[1], 1.0, 0.0);
  km_model_free(model);
}

/* A screw of -20 radians per metre: a turn moves it 2π/20 back. */
static void threads_count_radians_per_length(void **unused) {
  (void)unused;
  static const char text[] =
      "<sdf version='1.6'><model name='m'><link name='l'/><joint name='j' type='screw'><parent>world</parent>"
      "<child>l</child><thread_pitch>-20</thread_pitch><axis><xyz>1 0 0</xyz></axis></joint></model></sdf>";
  fixture f = open_text(text);
  go_to(&f, "j", 1.0);
  assert_near(pose_of(&f, "l").p[0], 1.0 / 20.0, 1e-15);
  fixture_close(&f);
}

static void gears_turn_against_their_reference(void **unused) {
  (void)unused;
  static const char text[] =
      "<sdf version='1.6'><model name='m'><link name='frame'/><link name='small'/><link name='large'>"
      "<pose>1 0 0 0 0 0</pose></link>"
      "<joint name='w' type='fixed'><parent>world</parent><child>frame</child></joint>"
      "<joint name='S' type='revolute'><parent>frame</parent><child>small</child><axis><xyz>0 0 1</xyz></axis></joint>"
      "<joint name='L' type='revolute'><parent>frame</parent><child>large</child><axis><xyz>0 0 -1</xyz></axis></joint>"
      "<joint name='G' type='gearbox'><parent>small</parent><child>large</child><gearbox_ratio>3</gearbox_ratio>"
      "<gearbox_reference_body>frame</gearbox_reference_body><axis><xyz>0 0 1</xyz></axis>"
      "<axis2><xyz>0 0 1</xyz></axis2></joint></model></sdf>";
  fixture f = open_text(text);
  km_assembly evidence;
  assert_int_equal(mobility_of(&f), 1);
  go_to(&f, "S", 0.2);
  go_to(&f, "L", 0.6); /* its axis is opposite, so -3 · 0.2 about z is +0.6 */
  assert_int_equal(km_assemble(f.mechanism, f.state, &evidence, NULL), KM_OK);
  assert_near(evidence.residual, 0.0, 1e-15);
  fixture_close(&f);
}

/* A link that hangs in a frame in a nested model. */
static void frames_reach_across_models(void **unused) {
  (void)unused;
  static const char text[] = "<sdf version='1.9'><model name='outer'><pose>0 0 0 0 0 " HALF_TURN_4 "</pose>"
                             "<frame name='f' attached_to='inner::l'><pose>0 2 0 0 0 0</pose></frame>"
                             "<link name='k'><pose relative_to='f'>1 0 0 0 0 0</pose></link>"
                             "<model name='inner'><pose>3 0 0 0 0 0</pose><link name='l'/></model></model></sdf>";
  fixture f = open_text(text);
  assert_planar(&f, "k", -2, 4, M_PI / 2); /* (3 + 1, 2) turned by a quarter */
  fixture_close(&f);
}

static void faults_of_inertias_are_dropped_with_a_warning(void **unused) {
  (void)unused;
  static const char text[] = "<robot name='r'><link name='a'><inertial><mass value='1'/><inertia ixx='-1' iyy='1' "
                             "izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>";
  km_messages *messages = km_messages_create();
  km_model *model = read_as(text, false, messages);
  assert_int_equal(km_messages_severity(messages, 0), KM_WARNING);
  assert_near(model->bodies[1].mass, 1.0, 0.0);
  assert_near(model->bodies[1].inertia[1], 0.0, 0.0);
  km_model_free(model);
  km_messages_free(messages);
}

/* Depth and length are bounded, and the location is reported. */
static void texts_without_measure_are_refused(void **unused) {
  (void)unused;
  enum { DEEP = 100000, LONG = 2000000 };
  km_text deep = {0}, wide = {0};
  km_model *model;
  km_error error;
  km_text_add(&deep, "<robot>");
  for (int i = 0; i < DEEP; ++i)
    km_text_add(&deep, "<a>");
  assert_int_equal(km_model_read(deep.data, deep.size, NULL, &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "line 1, column 6149: elements are nested more than 2048 deep"));
  km_text_add(&wide, "<robot name='");
  for (int i = 0; i < LONG / 10; ++i)
    km_text_add(&wide, "0123456789");
  km_text_add(&wide, "'/>");
  assert_int_equal(km_model_read(wide.data, wide.size, NULL, &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "longer than a million bytes"));
  km_text_free(&deep);
  km_text_free(&wide);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(defaults_come_from_the_nearest_class),
                                     cmocka_unit_test(euler_angles_follow_their_sequence),
                                     cmocka_unit_test(solids_weigh_what_their_discs_weigh),
                                     cmocka_unit_test(geoms_add_up),
                                     cmocka_unit_test(copies_stand_in_a_ring),
                                     cmocka_unit_test(axes_are_in_the_frame_that_is_told),
                                     cmocka_unit_test(a_missing_mass_is_a_kilogram),
                                     cmocka_unit_test(threads_count_radians_per_length),
                                     cmocka_unit_test(gears_turn_against_their_reference),
                                     cmocka_unit_test(frames_reach_across_models),
                                     cmocka_unit_test(texts_without_measure_are_refused),
                                     cmocka_unit_test(faults_of_inertias_are_dropped_with_a_warning)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
