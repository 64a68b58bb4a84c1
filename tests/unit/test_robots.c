/* Robot descriptions: small mechanisms whose poses, masses, limits and mobility are derived by hand, in each format. */
#include "support/support.h"

#include "exchange/json/convert.h"
#include "exchange/json/json.h"
#include "exchange/robot/robot.h"
#include "kmech/frames.h"
#include "kmech/mobility.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static km_model *read_as(const char *text, bool floating, km_messages *messages) {
  km_model *model = NULL;
  km_error error = {0};
  if (km_model_read_as(text, strlen(text), &(km_read_def){.floating = floating}, messages, &model, &error))
    fail_msg("%s", error.text);
  return model;
}

static fixture open_text(const char *text) {
  return fixture_of(read_as(text, false, NULL));
}

static int coordinate_of(const km_model *model, const char *label) {
  for (int c = 0; c < km_model_coordinate_count(model); ++c)
    if (strcmp(km_model_coordinate_label(model, c), label) == 0)
      return c;
  fail_msg("no coordinate %s", label);
  return -1;
}

static int body_of(const km_model *model, const char *name) {
  for (int b = 1; b < model->body_count; ++b)
    if (strcmp(model->bodies[b].name, name) == 0)
      return b;
  fail_msg("no body %s", name);
  return -1;
}

static void go_to(fixture *f, const char *label, double value) {
  assert_int_equal(km_state_set_coordinate(f->mechanism, f->state, coordinate_of(f->model, label), value, NULL), KM_OK);
}

static km_frame_pose pose_of(const fixture *f, const char *body) {
  int b = body_of(f->model, body), frame = 0;
  km_frame_pose pose;
  while (km_model_frame_body(f->model, frame) != b || strcmp(km_model_frame_name(f->model, frame), "origin") != 0)
    frame++;
  km_poses_update(f->mechanism, f->state);
  assert_int_equal(km_frame_place(f->mechanism, f->state, frame, &pose, NULL), KM_OK);
  return pose;
}

/* Position, and rotation about z. A few operations on numbers of size 1: 1e-14. */
static void assert_planar(const fixture *f, const char *body, double x, double y, double angle) {
  km_frame_pose pose = pose_of(f, body);
  assert_near(pose.p[0], x, 1e-14);
  assert_near(pose.p[1], y, 1e-14);
  assert_near(pose.p[2], 0.0, 1e-14);
  assert_near(pose.R[0], cos(angle), 1e-14);
  assert_near(pose.R[3], sin(angle), 1e-14);
  assert_near(pose.R[8], 1.0, 1e-14);
}

static int mobility_of(fixture *f) {
  km_mobility mobility;
  km_error error;
  if (km_assemble(f->mechanism, f->state, NULL, &error))
    fail_msg("%s", error.text);
  km_mobility_update(f->mechanism, f->state, &mobility);
  return mobility.mobility;
}

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
static km_robot_mass by_discs(double (*radius2)(double z), double end) {
  enum { STEPS = 20000 };
  km_robot_mass sum = {0};
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

static void solids_weigh_what_their_discs_weigh(void **unused) {
  (void)unused;
  const double half[3] = {0.3, 0.3, 0.8};
  const km_robot_mass found[] = {km_solid_capsule(0.3, 0.5), km_solid_ellipsoid(half)};
  const km_robot_mass expected[] = {by_discs(capsule, 0.8), by_discs(ellipsoid, 0.8)};
  for (int i = 0; i < 2; ++i) { /* Simpson's error: h⁴ times derivatives of size 100, and at the caps' edges h³ */
    assert_near(found[i].mass, expected[i].mass, 1e-9);
    assert_near(found[i].inertia[0], expected[i].inertia[0], 1e-9);
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

/* The axis of one joint as seen by each way of telling in which frame it is: x of the model, y of the child. */
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

/* Depth and length are bounded, and the place is told. */
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
  const struct CMUnitTest tests[] = {cmocka_unit_test(an_arm_stands_where_its_joints_say),
                                     cmocka_unit_test(a_joint_follows_another_by_a_polynomial),
                                     cmocka_unit_test(the_root_is_free_where_that_is_asked),
                                     cmocka_unit_test(what_is_converted_is_the_same_mechanism),
                                     cmocka_unit_test(loops_close_at_the_pose_of_the_file),
                                     cmocka_unit_test(rounded_loops_have_a_tolerance),
                                     cmocka_unit_test(followers_keep_their_ratio_and_offset),
                                     cmocka_unit_test(several_joints_on_a_body_follow_each_other),
                                     cmocka_unit_test(defaults_come_from_the_nearest_class),
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
