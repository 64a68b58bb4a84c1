/* Robot descriptions beyond the tree of joints: texts that aren't quite XML, keyframes, tendons, shapes, limits of
 * ball joints; and their preservation by writing. Numbers by hand. */
#include "support/robots.h"

#include "base/memory.h"
#include "base/text.h"
#include "kmech/exchange.h"
#include "kmech/mechanism.h"
#include "kmech/sweep.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Comments may hold "--", and the declaration may come after one; lines still count. */
static void loose_xml_is_read(void **unused) {
  (void)unused;
  static const char loose[] =
      "<!-- a -- b\n --- -->\n<?xml version='1.0'?>\n<robot name='r'><!-- <link name='x'/> -- -->"
      "<link name='a'/></robot>";
  static const char faulty[] = "<!-- a -- b\n --- -->\n<robot name='r'>\n<lnk/></robot";
  static const char endless[] = "<robot name='r'><!-- -- <link name='a'/></robot>";
  km_model *model = read_as(loose, false, NULL);
  km_error error;
  assert_int_equal(km_model_body_count(model), 1);
  km_model_free(model);
  assert_int_equal(km_model_read(faulty, strlen(faulty), NULL, &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "line 4"));
  assert_int_equal(km_model_read(endless, strlen(endless), NULL, &model, &error), KM_MODEL);
}

/* A keyframe of twenty joints, the last one's value among them. */
static void long_keyframes_are_read(void **unused) {
  (void)unused;
  enum { JOINTS = 20 };
  char text[4000] = "<mujoco><compiler angle='radian'/><worldbody>";
  for (int i = 0; i < JOINTS; ++i)
    sprintf(text + strlen(text), "<body name='b%d'><joint name='j%d'/></body>", i, i);
  strcat(text, "</worldbody><keyframe><key name='far' qpos='");
  for (int i = 0; i < JOINTS; ++i)
    sprintf(text + strlen(text), "%g ", 0.1 * i);
  strcat(text, "'/></keyframe></mujoco>");
  km_model *model = read_as(text, false, NULL);
  assert_int_equal(km_model_pose_count(model), 1);
  assert_int_equal(model->poses[0].count, JOINTS);
  for (int i = 0; i < JOINTS; ++i)
    assert_near(model->poses[0].values[i], 0.1 * i, 1e-15);
  km_model_free(model);
}

/* A quaternion of zeros is no turn, as in MuJoCo. */
static void no_quaternion_is_no_turn(void **unused) {
  (void)unused;
  km_model *model =
      read_as("<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody><keyframe><key name='k' "
              "qpos='1 2 3 0 0 0 0'/></keyframe></mujoco>",
              false, NULL);
  assert_int_equal(km_model_pose_count(model), 1);
  for (int k = 0; k < 6; ++k)
    assert_near(model->poses[0].values[k], k < 3 ? k + 1.0 : 0.0, 0.0);
  km_model_free(model);
}

/* In a connected part without the world, the link that is child of no joint is fixed, whatever its position in the
 * file. */
static void the_root_is_no_child(void **unused) {
  (void)unused;
  static const char text[] =
      "<sdf version='1.9'><model name='m'><link name='tip'><pose>1 0 0 0 0 0</pose></link><link name='base'/>"
      "<joint name='A' type='revolute'><parent>base</parent><child>tip</child><pose relative_to='base'/>"
      "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>";
  fixture f = open_text(text);
  go_to(&f, "A", 0.5);
  assert_planar(&f, "base", 0, 0, 0);
  assert_planar(&f, "tip", cos(0.5), sin(0.5), 0.5);
  fixture_close(&f);
}

static const char three_joints[] =
    "<mujoco><compiler angle='radian'/><worldbody><body name='a'><joint name='A' axis='0 0 1' ref='0.5'/></body>"
    "<body name='b'><joint name='B' axis='0 0 1'/></body><body name='c'><joint name='C' type='slide' axis='1 0 0'/>"
    "</body></worldbody><tendon><fixed name='t'><joint joint='A' coef='2'/><joint joint='B' coef='-1'/></fixed>"
    "<fixed name='u'><joint joint='C' coef='4'/></fixed></tendon>"
    "<equality><tendon name='e' tendon1='t' tendon2='u' polycoef='0.25 3 0 0 0'/></equality></mujoco>";

/* 2 (A - 0.5) - B - 3 · 4 C = 0.25. */
static void assert_tied(fixture *f) {
  assert_int_equal(mobility_of(f), 2);
  for (int k = 0; k < 3; ++k) {
    double A = 0.3 * k, C = 0.1 - 0.05 * k;
    go_to(f, "A", A);
    go_to(f, "C", C);
    go_to(f, "B", 2 * (A - 0.5) - 12 * C - 0.25);
    km_assembly evidence;
    assert_int_equal(km_assemble(f->mechanism, f->state, &evidence, NULL), KM_OK);
    assert_near(km_state_coordinate(f->state, coordinate_of(f->model, "A")), A, 1e-14);
    assert_near(km_state_coordinate(f->state, coordinate_of(f->model, "C")), C, 1e-14);
  }
}

static fixture sent(const km_model *model, km_model_format format) {
  km_bytes bytes;
  km_error error;
  if (km_model_write_as(model, format, NULL, NULL, NULL, &bytes, &error))
    fail_msg("%s", error.text);
  fixture f = fixture_of(read_as(bytes.data, false, NULL));
  km_bytes_free(&bytes);
  return f;
}

static void tendons_couple_several_joints(void **unused) {
  (void)unused;
  fixture f = open_text(three_joints);
  assert_tied(&f);
  const km_model_format formats[] = {KM_FORMAT_JSON, KM_FORMAT_MJCF};
  for (int i = 0; i < 2; ++i) {
    fixture g = sent(f.model, formats[i]);
    assert_tied(&g);
    fixture_close(&g);
  }
  fixture_close(&f);
}

static const char looks[] =
    "{\"model_parameters\": {\"units\": {\"length\": \"mm\"}}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": "
    "\"a\", \"mass\": 2, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 1}, \"shapes\": [{\"box\": [10, 20, 30], \"T\": [1, 2, 3], \"R\": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], \"color\": "
    "[1, 0.5, 0, 1]}, {\"sphere\": 5}, {\"cylinder\": [4, 50]}, {\"capsule\": [6, 70]}, {\"mesh\": \"part.stl\", "
    "\"scale\": [1, 2, 3]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", "
    "\"a\"]}]}]}";

/* Kinds, sizes in metres, pose and colour are preserved; the mass is the stated one. */
static void looks_are_written(void **unused) {
  (void)unused;
  fixture f = fixture_read(looks);
  for (int format = KM_FORMAT_URDF; format <= KM_FORMAT_SDF; ++format) {
    fixture g = sent(f.model, (km_model_format)format);
    assert_int_equal(g.model->shape_count, 5);
    for (int s = 0; s < 5; ++s) {
      const km_model_shape *one = &f.model->shapes[s], *two = &g.model->shapes[s];
      double first = one->kind == KM_SHAPE_OF_MESH ? 0.0 : one->size[0];
      assert_int_equal(two->kind, one->kind);
      assert_near(two->size[0] * (one->kind != KM_SHAPE_OF_MESH), 1e-3 * first, 1e-17);
      if (one->kind != KM_SHAPE_SPHERE && one->kind != KM_SHAPE_OF_MESH)
        assert_near(two->size[1], 1e-3 * one->size[1], 1e-17);
      assert_near(km_vec3_norm(km_vec3_sub(two->pose.p, km_vec3_scale(1e-3, one->pose.p))), 0.0, 1e-17);
      for (int k = 0; k < 3; ++k)
        assert_near(km_vec3_norm(km_vec3_sub(two->pose.R.axis[k], one->pose.R.axis[k])), 0.0, 1e-15);
      for (int k = 0; k < 4 && one->color[3] >= 0.0; ++k)
        assert_near(two->color[k], one->color[k], 0.0);
      assert_int_equal(two->color[3] >= 0.0, one->color[3] >= 0.0);
    }
    assert_string_equal(g.model->shapes[4].mesh, "part.stl");
    for (int k = 0; k < 3; ++k)
      assert_near(g.model->shapes[4].scale[k], 1e-3 * (k + 1), 1e-18);
    assert_near(g.model->bodies[body_of(g.model, "a")].mass, 2.0, 0.0);
    fixture_close(&g);
  }
  fixture_close(&f);
}

/* A hinge that stands at 30°, a screw, a ball: their poses as keyframes, and back. */
static void named_poses_are_written(void **unused) {
  (void)unused;
  static const char text[] =
      "{\"model_parameters\": {\"version\": \"1.1\", \"units\": {\"angle\": \"deg\", \"length\": \"mm\"}}, \"poses\": {\"half\": {\"A\": 45}, "
      "\"all\": {\"A\": -20, \"S\": 90, \"B\": [10, 20, 30]}}, \"assemblies\": [{\"name\": \"m\", \"bodies\": "
      "[{\"name\": \"a\"}, {\"name\": \"s\"}, {\"name\": \"b\"}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"initial_displacement\": 30, "
      "\"body_frame_pairs\": [\"fixed\", \"a\"]}, {\"name\": \"S\", \"type\": \"screw\", \"pitch\": 4, "
      "\"body_frame_pairs\": [\"a\", \"s\"]}, {\"name\": \"B\", \"type\": \"spherical\", \"body_frame_pairs\": "
      "[\"s\", \"b\"]}]}]}";
  fixture f = fixture_read(text), g = sent(f.model, KM_FORMAT_MJCF);
  static const double all[] = {-20, 90, 10, 20, 30}, half[] = {45, 0, 0, 0, 0};
  assert_int_equal(g.model->pose_count, 2);
  for (int p = 0; p < 2; ++p) {
    const km_model_pose *pose = &g.model->poses[p];
    const double *expected = strcmp(pose->name, "all") == 0 ? all : half;
    for (int i = 0; i < pose->count; ++i) {
      const char *label = km_model_coordinate_label(g.model, pose->coordinates[i]);
      int c = coordinate_of(f.model, strcmp(label, "S:slide") == 0 ? "S" : label);
      double unit = strcmp(label, "S:slide") == 0 ? 4e-3 / 360 : M_PI / 180;
      assert_near(pose->values[i], expected[c] * unit, 1e-15);
    }
    assert_int_equal(pose->count, 6); /* including the screw's translation */
  }
  fixture_close(&g);
  fixture_close(&f);
}

/* A sweep of the four-bar RSSR ends where a ball has turned by its limit. */
static void balls_end_sweeps_at_their_limit(void **unused) {
  (void)unused;
  char *text = read_model_text("rssr"), *at = strstr(text, "\"spherical\",");
  km_text limited = {0};
  km_text_format(&limited, "%.*s \"limits\": [0, 12], %s", (int)(at - text) + 12, text, at + 12);
  fixture f = fixture_read(limited.data);
  int ball = coordinate_of(f.model, "B[0]");
  km_sweep_plan plan = {.coordinate = coordinate_of(f.model, "A"), .from = 0, .to = 90, .steps = 30};
  km_mobility_sweep sweep;
  km_error error;
  if (km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error) != KM_PARTIAL)
    fail_msg("the sweep didn't end at the limit");
  assert_int_equal(sweep.motion.end.stop, KM_STOP_LIMIT);
  assert_int_equal(sweep.motion.end.coordinate, ball);
  const double *q = f.state->q + ball;
  assert_near(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]) / (12 * M_PI / 180), 1.0, 1e-9);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
  km_text_free(&limited);
  km_free(text);
}

/* In degrees, in MJCF's radians and back. */
static void limits_of_balls_are_kept(void **unused) {
  (void)unused;
  static const char text[] =
      "{\"model_parameters\": {\"version\": \"1.1\", \"units\": {\"angle\": \"deg\"}}, \"assemblies\": [{\"name\": \"m\", "
      "\"bodies\": [{\"name\": \"b\"}], \"joints\": [{\"name\": \"B\", \"type\": \"spherical\", \"limits\": [0, 60], "
      "\"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}";
  fixture f = fixture_read(text);
  const km_model_format formats[] = {KM_FORMAT_JSON, KM_FORMAT_MJCF};
  const double most[] = {60, M_PI / 3};
  for (int i = 0; i < 2; ++i) {
    fixture g = sent(f.model, formats[i]);
    assert_near(g.model->joints[0].most_turn, most[i], 1e-14);
    assert_near(g.mechanism->max_ball_angle[0], M_PI / 3, 1e-15);
    fixture_close(&g);
  }
  double q[3] = {0.7, -0.7, 0.5};
  double turned = sqrt(0.49 + 0.49 + 0.25) - M_PI / 3;
  assert_near(km_state_ball_excess(f.mechanism, 0, q), turned, 1e-15);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(loose_xml_is_read),
                                     cmocka_unit_test(long_keyframes_are_read),
                                     cmocka_unit_test(no_quaternion_is_no_turn),
                                     cmocka_unit_test(the_root_is_no_child),
                                     cmocka_unit_test(tendons_couple_several_joints),
                                     cmocka_unit_test(looks_are_written),
                                     cmocka_unit_test(named_poses_are_written),
                                     cmocka_unit_test(balls_end_sweeps_at_their_limit),
                                     cmocka_unit_test(limits_of_balls_are_kept)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
