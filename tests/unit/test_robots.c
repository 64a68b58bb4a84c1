/* Robot descriptions: small mechanisms whose poses, masses, limits and mobility are derived by hand, in each format. */
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

static const char urdf_2r[] =
    "<robot name='arm'><link name='base'/>"
    "<link name='upper'><inertial><origin xyz='0.5 0 0' rpy='0 0 " HALF_TURN_4 "'/><mass value='2'/>"
    "<inertia ixx='1' iyy='2' izz='2.5' ixy='0' ixz='0' iyz='0'/></inertial></link>"
    "<link name='lower'/><link name='tip'/>"
    "<joint name='A' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 0 2'/>"
    "<limit lower='-1' upper='2' effort='3' velocity='1.5'/><dynamics damping='0.5' friction='0.25'/></joint>"
    "<joint name='B' type='continuous'><origin xyz='1 0 0'/><parent link='upper'/><child link='lower'/>"
    "<axis xyz='0 0 1'/></joint>"
    "<joint name='T' type='fixed'><origin xyz='0.5 0 0' rpy='0 0 " HALF_TURN_4 "'/><parent link='lower'/>"
    "<child link='tip'/></joint></robot>";

static const char mjcf_2r[] =
    "<mujoco model='arm'><compiler angle='degree'/><worldbody><body name='upper'>"
    "<inertial pos='0.5 0 0' euler='0 0 90' mass='2' diaginertia='1 2 2.5'/>"
    "<joint name='A' axis='0 0 2' range='-57.29577951308232 114.59155902616465' damping='0.5' frictionloss='0.25'/>"
    "<body name='lower' pos='1 0 0'><joint name='B' axis='0 0 1'/>"
    "<body name='tip' pos='0.5 0 0' euler='0 0 90'/></body></body></worldbody>"
    "<actuator><position joint='A' forcerange='-1 1' gear='3'/></actuator></mujoco>";

static const char sdf_2r[] =
    "<sdf version='1.9'><model name='arm'><link name='upper'><inertial><pose>0.5 0 0 0 0 " HALF_TURN_4 "</pose>"
    "<mass>2</mass><inertia><ixx>1</ixx><iyy>2</iyy><izz>2.5</izz></inertia></inertial></link>"
    "<link name='lower'><pose relative_to='B'/></link>"
    "<link name='tip'><pose relative_to='lower'>0.5 0 0 0 0 " HALF_TURN_4 "</pose></link>"
    "<joint name='A' type='revolute'><parent>world</parent><child>upper</child><axis><xyz>0 0 2</xyz>"
    "<limit><lower>-1</lower><upper>2</upper><effort>3</effort><velocity>1.5</velocity></limit>"
    "<dynamics><damping>0.5</damping><friction>0.25</friction></dynamics></axis></joint>"
    "<joint name='B' type='revolute'><pose relative_to='upper'>1 0 0 0 0 0</pose><parent>upper</parent>"
    "<child>lower</child><axis><xyz>0 0 1</xyz></axis></joint>"
    "<joint name='T' type='fixed'><parent>lower</parent><child>tip</child></joint></model></sdf>";

static const char *const arms[] = {urdf_2r, mjcf_2r, sdf_2r};

static void an_arm_stands_where_its_joints_say(void **unused) {
  (void)unused;
  for (int i = 0; i < 3; ++i) {
    fixture f = open_text(arms[i]);
    double low, high;
    assert_int_equal(mobility_of(&f), 2);
    go_to(&f, "A", 0.3);
    go_to(&f, "B", -0.7);
    assert_planar(&f, "upper", 0, 0, 0.3);
    assert_planar(&f, "lower", cos(0.3), sin(0.3), -0.4);
    assert_planar(&f, "tip", cos(0.3) + 0.5 * cos(-0.4), sin(0.3) + 0.5 * sin(-0.4), -0.4 + M_PI / 2);
    const km_model_body *upper = &f.model->bodies[body_of(f.model, "upper")];
    assert_near(upper->mass, 2.0, 0.0);
    assert_near(upper->center_of_mass.x, 0.5, 0.0);
    const double inertia[6] = {2, 1, 2.5, 0, 0, 0}; /* a quarter turn changes x and y */
    for (int k = 0; k < 6; ++k)
      assert_near(upper->inertia[k], inertia[k], 1e-15);
    int a = coordinate_of(f.model, "A");
    assert_true(km_model_coordinate_limits(f.model, a, &low, &high));
    assert_near(low, -1.0, 1e-15);
    assert_near(high, 2.0, 1e-15);
    const km_model_coordinate *drive = &f.model->coordinates[a];
    assert_near(drive->damping, 0.5, 0.0);
    assert_near(drive->friction, 0.25, 0.0);
    assert_near(drive->max_force, 3.0, 0.0);
    if (i == 1)
      assert_true(drive->max_rate == HUGE_VAL); /* MJCF has no limits of rates */
    else
      assert_near(drive->max_rate, 1.5, 0.0);
    assert_false(km_model_coordinate_limits(f.model, coordinate_of(f.model, "B"), &low, &high));
    fixture_close(&f);
  }
}

static void the_root_is_free_where_that_is_asked(void **unused) {
  (void)unused;
  static const char loose[] =
      "<sdf version='1.9'><model name='m'><pose>1 2 3 0 0 0.5</pose><link name='l'/></model></sdf>";
  const char *const texts[] = {urdf_2r, loose};
  const int fixed[] = {2, 0};
  for (int i = 0; i < 2; ++i)
    for (int floating = 0; floating < 2; ++floating) {
      fixture f = fixture_of(read_as(texts[i], floating, NULL));
      assert_int_equal(mobility_of(&f), fixed[i] + 6 * floating);
      if (i == 1)
        assert_near(pose_of(&f, "l").p[2], 3.0, 1e-15);
      fixture_close(&f);
    }
}

/* Converted to the model format and read again: the same poses to rounding. */
static void what_is_converted_is_the_same_mechanism(void **unused) {
  (void)unused;
  for (int i = 0; i < 3; ++i) {
    fixture f = open_text(arms[i]);
    km_arena arena = {0};
    km_text text = {0};
    const km_value *tree;
    km_error error;
    if (km_model_convert(f.model, &f.model->units, NULL, false, &arena, &tree, &error))
      fail_msg("%s", error.text);
    km_json_write(tree, &text);
    fixture g = fixture_read(text.data);
    assert_int_equal(km_model_joint_count(g.model), km_model_joint_count(f.model));
    fixture *const both[] = {&f, &g};
    for (int k = 0; k < 2; ++k) {
      go_to(both[k], "A", 1.1);
      go_to(both[k], "B", 0.4);
    }
    km_frame_pose one = pose_of(&f, "tip"), two = pose_of(&g, "tip");
    for (int k = 0; k < 9; ++k)
      assert_near(one.R[k], two.R[k], 1e-12);
    for (int k = 0; k < 3; ++k)
      assert_near(one.p[k], two.p[k], 1e-12);
    km_text_free(&text);
    km_arena_free(&arena);
    fixture_close(&g);
    fixture_close(&f);
  }
}

/* x1 - ref1 = c0 + c1 (x2 - ref2) + …, at any value of x2. */
static void a_joint_follows_another_by_a_polynomial(void **unused) {
  (void)unused;
  static const char cam[] =
      "<mujoco><compiler angle='radian'/><worldbody><body name='a'><joint name='A' type='slide' ref='0.5'/></body>"
      "<body name='b'><joint name='B' ref='0.25'/></body></worldbody>"
      "<equality><joint joint1='A' joint2='B' polycoef='0.1 2 -3 0.5 1'/></equality>"
      "<keyframe><key qpos='7 1'/><key name='turned' qpos='0.6 0.25'/><key qpos='1'/></keyframe></mujoco>";
  fixture f = open_text(cam);
  assert_int_equal(mobility_of(&f), 1);
  int a = coordinate_of(f.model, "A"), b = coordinate_of(f.model, "B");
  assert_near(km_state_coordinate(f.state, a), 0.6, 1e-15);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.coordinate = b;
  plan.from = -1.0;
  plan.to = 1.5;
  plan.steps = 20;
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  for (size_t r = 0; r < 21; ++r) {
    const double *row = km_table_row(sweep.motion.table, r);
    double x = row[km_table_find(sweep.motion.table, "q.B")] - 0.25;
    double slope = 2 - 6 * x + 1.5 * x * x + 4 * x * x * x;
    assert_near(row[km_table_find(sweep.motion.table, "q.A")], 0.6 + x * (2 + x * (-3 + x * (0.5 + x))), 1e-12);
    slope /= km_mechanism_characteristic_length(f.mechanism, NULL);
    double share = 1.0 / (1.0 + slope * slope);
    assert_near(row[km_table_find(sweep.motion.table, "m.B")], share, 1e-12);
  }
  km_mobility_sweep_free(&sweep);
  int pose;
  assert_int_equal(km_model_pose_count(f.model), 2);
  assert_int_equal(km_model_find_pose(f.model, "turned", &pose, NULL), KM_OK);
  assert_int_equal(pose, 1);
  assert_string_equal(km_model_pose_name(f.model, 0), "key0");
  fixture_close(&f);
}

/* A parallelogram of sides 1 and 2: whatever its crank's angle, the coupler keeps its direction. */
static void loops_close_at_the_pose_of_the_file(void **unused) {
  (void)unused;
  static const char connect[] =
      "<mujoco><worldbody><body name='crank'><joint name='A' axis='0 0 1'/>"
      "<body name='coupler' pos='0 1 0'><joint name='B' axis='0 0 1'/></body></body>"
      "<body name='rocker' pos='2 0 0'><joint name='D' axis='0 0 1'/></body></worldbody>"
      "<equality><connect name='C' body1='coupler' body2='rocker' anchor='2 0 0'/></equality></mujoco>";
  static const char joint[] =
      "<sdf version='1.9'><model name='m'><link name='crank'/><link name='coupler'><pose>0 1 0 0 0 0</pose></link>"
      "<link name='rocker'><pose>2 0 0 0 0 0</pose></link>"
      "<joint name='A' type='revolute'><parent>world</parent><child>crank</child><axis><xyz>0 0 1</xyz></axis></joint>"
      "<joint name='B' type='revolute'><parent>crank</parent><child>coupler</child><axis><xyz>0 0 1</xyz></axis></joint>"
      "<joint name='C' type='revolute'><pose relative_to='coupler'>2 0 0 0 0 0</pose><parent>coupler</parent>"
      "<child>rocker</child><axis><xyz>0 0 1</xyz></axis></joint>"
      "<joint name='D' type='revolute'><parent>world</parent><child>rocker</child><axis><xyz>0 0 1</xyz></axis></joint>"
      "</model></sdf>";
  const char *const texts[] = {connect, joint};
  for (int i = 0; i < 2; ++i) {
    fixture f = open_text(texts[i]);
    km_assembly evidence;
    assert_int_equal(km_assemble(f.mechanism, f.state, &evidence, NULL), KM_OK);
    assert_near(evidence.residual, 0.0, 1e-15);
    assert_int_equal(mobility_of(&f), 1);
    assert_false(f.model->closure_tolerance_given);
    go_to(&f, "A", 0.2);
    go_to(&f, "B", -0.2);
    go_to(&f, "D", 0.2);
    assert_int_equal(km_assemble(f.mechanism, f.state, &evidence, NULL), KM_OK);
    assert_near(evidence.residual, 0.0, 1e-12);
    fixture_close(&f);
  }
}

/* Rounded digits in a file with loops loosen the closure; π/2 is exact however it is written. */
static void rounded_loops_have_a_tolerance(void **unused) {
  (void)unused;
  static const char format[] =
      "<mujoco><compiler angle='radian'/><worldbody><body name='a'><joint/><body name='b' pos='1 0 0' euler='%s 0 0'>"
      "<joint/></body></body></worldbody><equality><connect body1='b' anchor='0 1 0'/></equality></mujoco>";
  char text[600];
  const char *const angles[] = {"1.57079632679", "0.12345", "0.5"};
  const double expected[] = {1e-11, 1e-5, 0}; /* twice half a unit of the last digit, or less where π/2 is meant */
  for (int i = 0; i < 3; ++i) {
    snprintf(text, sizeof text, format, angles[i]);
    km_model *model = read_as(text, false, NULL);
    assert_int_equal(model->closure_tolerance_given, i == 1);
    assert_near(model->closure_tolerance, i == 1 ? expected[i] : 1e-9, 1e-12);
    km_model_free(model);
  }
}

static void followers_keep_their_ratio_and_offset(void **unused) {
  (void)unused;
  static const char urdf[] =
      "<robot name='g'><link name='palm'/><link name='left'/><link name='right'/>"
      "<joint name='L' type='prismatic'><parent link='palm'/><child link='left'/><axis xyz='0 1 0'/></joint>"
      "<joint name='R' type='prismatic'><parent link='palm'/><child link='right'/><axis xyz='0 1 0'/>"
      "<mimic joint='L' multiplier='-2' offset='0.1'/></joint></robot>";
  static const char sdf[] =
      "<sdf version='1.11'><model name='g'><link name='left'/><link name='right'/>"
      "<joint name='L' type='prismatic'><parent>world</parent><child>left</child><axis><xyz>0 1 0</xyz></axis></joint>"
      "<joint name='R' type='prismatic'><parent>world</parent><child>right</child><axis><xyz>0 1 0</xyz>"
      "<mimic joint='L'><multiplier>-2</multiplier><reference>0.05</reference><offset>0</offset></mimic></axis></joint>"
      "</model></sdf>";
  static const char mjcf[] =
      "<mujoco><worldbody><body name='left'><joint name='L' type='slide' axis='0 1 0'/></body><body name='right'>"
      "<joint name='R' type='slide' axis='0 1 0'/></body></worldbody>"
      "<equality><joint joint1='R' joint2='L' polycoef='0.1 -2 0 0 0'/></equality></mujoco>";
  const char *const texts[] = {urdf, sdf, mjcf};
  for (int i = 0; i < 3; ++i) {
    fixture f = open_text(texts[i]);
    assert_int_equal(mobility_of(&f), 1);
    assert_near(km_state_coordinate(f.state, coordinate_of(f.model, "R")), 0.1, 1e-15);
    go_to(&f, "L", 0.3);
    go_to(&f, "R", -0.5);
    km_assembly evidence;
    assert_int_equal(km_assemble(f.mechanism, f.state, &evidence, NULL), KM_OK);
    assert_near(evidence.residual, 0.0, 1e-15); /* R = 0.1 - 2 L already holds */
    assert_near(pose_of(&f, "right").p[1], -0.5, 1e-15);
    fixture_close(&f);
  }
}

/* Two hinges and a slide on one body, the first with a reference value: turned by q - ref about its anchor. */
static void several_joints_on_a_body_follow_each_other(void **unused) {
  (void)unused;
  static const char text[] =
      "<mujoco><compiler angle='radian'/><worldbody><body name='b' pos='1 0 0'>"
      "<joint name='h' axis='0 0 1' pos='0 1 0' ref='0.5'/><joint name='s' type='slide' axis='1 0 0'/></body>"
      "</worldbody></mujoco>";
  fixture f = open_text(text);
  assert_near(km_state_coordinate(f.state, coordinate_of(f.model, "h")), 0.5, 0.0);
  assert_planar(&f, "b", 1, 0, 0);
  go_to(&f, "h", 0.9);
  go_to(&f, "s", 2.0);
  /* The body's origin is at (0, -1) from the anchor (1, 1), turned by 0.4, then 2 along the turned x axis. */
  assert_planar(&f, "b", 1 + sin(0.4) + 2 * cos(0.4), 1 - cos(0.4) + 2 * sin(0.4), 0.4);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(an_arm_stands_where_its_joints_say),
                                     cmocka_unit_test(a_joint_follows_another_by_a_polynomial),
                                     cmocka_unit_test(the_root_is_free_where_that_is_asked),
                                     cmocka_unit_test(what_is_converted_is_the_same_mechanism),
                                     cmocka_unit_test(loops_close_at_the_pose_of_the_file),
                                     cmocka_unit_test(rounded_loops_have_a_tolerance),
                                     cmocka_unit_test(followers_keep_their_ratio_and_offset),
                                     cmocka_unit_test(several_joints_on_a_body_follow_each_other)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
