/* Paths: their lengths and times, and the same by calls and by text. */
#include "support/arms.h"

#include <string.h>

/* Lengths of line, helix, circle and weave in closed form; ξ is the derivative of the pose by s. */
static void paths_have_their_lengths(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(
      &f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0], \"path\": {\"start\":"
          "{\"T\": [0.5, 0, 0.5], \"R\": [[1, 0, 0], [0, -1, 0], [0, 0, -1]]}, \"segments\": ["
          "{\"type\": \"line\", \"to\": [0.5, 0.3, 0.1], \"R_to\": [[0, 1, 0], [1, 0, 0], [0, 0, -1]], \"steps\": 7},"
          "{\"type\": \"helix\", \"center\": [0.5, 0.1, 0], \"axis\": [0, 0, 1], \"angle\": 3, \"pitch\": 0.1, "
          "\"steps\": 9},"
          "{\"type\": \"circle\", \"center\": [0.5, 0.1, 0], \"axis\": [0, 0, 1], \"turn\": true, \"steps\": 8},"
          "{\"type\": \"spline\", \"points\": [{\"T\": [0.4, 0.2, 0.3], \"time\": 1}, {\"T\": [0.4, 0.3, 0.3],"
          " \"R\": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], \"time\": 2.5}], \"steps\": 11}]}}");
  const km_path *path = study->path;
  assert_int_equal(km_path_samples(path), 36);
  double L = study->arm->length, a = hypot(0.5, L * M_PI / 2.0), b = 3.0 * hypot(0.2, 0.1 / (2.0 * M_PI));
  double c = 2.0 * M_PI * hypot(0.2, L);
  assert_near(km_path_length(path, 7), a, 1e-12);
  assert_near(km_path_length(path, 16), a + b, 1e-12);
  assert_near(km_path_length(path, 24), a + b + c, 1e-12);
  assert_near(km_path_time(path, 35) - km_path_time(path, 24), 2.5, 1e-12);
  km_frame_pose end;
  km_path_pose(path, 35, &end);
  assert_near(end.p[0], 0.4, 1e-12);
  assert_near(end.R[4], -1.0, 1e-12);
  for (int i = 0; i < 35; ++i)
    for (int k = 1; k < 4; ++k) {
      const double h = 1e-4;
      km_path_point x = km_path_at(path, i, 0.25 * k - h), y = km_path_at(path, i, 0.25 * k + h),
                    at = km_path_at(path, i, 0.25 * k);
      double ds = y.s - x.s;
      km_rotation back = km_rotation_inverse(&x.pose.R), turn = km_rotation_product(&y.pose.R, &back);
      km_vec3 w = km_quaternion_log(km_rotation_quaternion(&turn));
      km_vec3 v = km_vec3_scale(1.0 / ds, km_vec3_sub(y.pose.p, x.pose.p));
      assert_true(km_vec3_norm(km_vec3_sub(v, at.twist.v)) < 1e-5);
      assert_true(km_vec3_norm(km_vec3_sub(km_vec3_scale(1.0 / ds, w), at.twist.w)) < 1e-5);
      assert_near(km_vec3_dot(at.twist.v, at.twist.v) + km_vec3_dot(at.twist.w, at.twist.w), 1.0, 1e-12);
    }
  km_study_free(study);
  fixture_close(&f);
}

/* Paths by calls have the stated ends and the lengths of their shapes. */
static void paths_by_calls_go_where_they_are_told(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_arm *arm;
  assert_int_equal(km_arm_create(f.mechanism, f.state, km_model_frame_count(f.model) - 1, KM_TASK_POSE, &arm, NULL),
                   KM_OK);
  const km_frame_pose knots[2] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.5, 0.2, 0.5}},
                                  {{0, -1, 0, 1, 0, 0, 0, 0, 1}, {0.4, 0.3, 0.4}}};
  km_path_segment g[4];
  for (int i = 0; i < 4; ++i)
    g[i] = km_path_segment_default((km_path_shape)i);
  g[0] = (km_path_segment){.shape = KM_PATH_LINE, .steps = 10, .to = {0.5, 0.3, 0.4}, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  g[1].center[0] = g[1].center[2] = 0.4;
  g[1].center[1] = 0.3;
  g[1].axis[2] = 2.0; /* any length */
  g[1].angle = 2.0 * M_PI;
  g[1].pitch = 0.05;
  g[2].to[0] = 0.5;
  g[2].to[1] = 0.1;
  g[2].to[2] = 0.45;
  g[2].sideways[0] = 1.0;
  g[2].amplitude = 0.02;
  g[2].waves = 3.0;
  g[3].points = knots;
  g[3].point_count = 2;
  km_path_plan plan = km_path_plan_default();
  km_path *path;
  km_error error;
  plan.start.p[0] = 0.5;
  plan.start.p[2] = 0.4;
  plan.segments = g;
  plan.segment_count = 4;
  plan.speed = 0.1;
  if (km_path_create(arm, &plan, &path, &error))
    fail_msg("%s", error.text);
  assert_int_equal(km_path_samples(path), 311);
  assert_near(km_path_travel(path, 10), 0.3, 1e-12);
  assert_near(km_path_time(path, 10), 3.0, 1e-11);
  assert_near(km_path_travel(path, 110) - 0.3, hypot(2.0 * M_PI * 0.1, 0.05), 1e-12);
  km_frame_pose ends[4];
  for (int i = 0; i < 4; ++i)
    km_path_pose(path, 10 + 100 * i, &ends[i]);
  for (int k = 0; k < 3; ++k) {
    assert_near(ends[0].p[k], g[0].to[k], 1e-12);
    assert_near(ends[1].p[k], ends[0].p[k] + (k == 2 ? 0.05 : 0.0), 1e-12);
    assert_near(ends[2].p[k], g[2].to[k], 1e-12);
    assert_near(ends[3].p[k], knots[1].p[k], 1e-12);
  }
  for (int k = 0; k < 9; ++k)
    assert_near(ends[3].R[k], knots[1].R[k], 1e-12);
  km_path_free(path);
  g[0].to[1] = 0.0; /* the present position */
  g[0].to[2] = 0.4;
  assert_int_equal(km_path_create(arm, &plan, &path, &error), KM_USAGE);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Equal points by a study's text and by calls are bit-equal: with and without times, with a start of its own, and
 * with constant orientations. */
static void splines_by_calls_are_those_of_text(void **state) {
  (void)state;
  static const char text[] =
      "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0], \"path\": {\"segments\": ["
      "{\"type\": \"spline\", \"points\": [{\"T\": [0.5, 0, 0.5]}, {\"T\": [0.5, 0.1, 0.5], \"R\": [[1, 0, 0], [0, -1, "
      "0], [0, 0, -1]]}, {\"T\": [0.4, 0.2, 0.5]}], \"steps\": 7},"
      "{\"type\": \"spline\", \"points\": [{\"T\": [0.4, 0.3, 0.5], \"time\": 0.5}, {\"T\": [0.4, 0.4, 0.4], \"time\": "
      "2}], \"steps\": 5}]}}";
  static const double times[2] = {0.5, 2.0}, q0[7] = {0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0};
  const km_frame_pose points[5] = {{{0}, {0.5, 0, 0.5}},
                                   {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0.5, 0.1, 0.5}},
                                   {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0.4, 0.2, 0.5}},
                                   {{0}, {0.4, 0.3, 0.5}},
                                   {{0}, {0.4, 0.4, 0.4}}};
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(&f, text);
  km_path_segment g[2] = {km_path_segment_default(KM_PATH_SPLINE), km_path_segment_default(KM_PATH_SPLINE)};
  km_path_plan plan = km_path_plan_default();
  g[0].points = points;
  g[0].point_count = 3;
  g[0].unturned = 1;
  g[0].own_start = true;
  g[0].steps = 7;
  g[1].points = points + 3;
  g[1].point_count = g[1].unturned = 2;
  g[1].times = times;
  g[1].steps = 5;
  assert_int_equal(km_arm_place(study->arm, q0, &plan.start, NULL), KM_OK);
  plan.start.p[0] = 0.9; /* the first spline begins elsewhere */
  plan.segments = g;
  plan.segment_count = 2;
  km_path *path;
  assert_int_equal(km_path_create(study->arm, &plan, &path, NULL), KM_OK);
  assert_int_equal(km_path_samples(path), 13);
  for (int i = 0; i < 13; ++i) {
    km_frame_pose a, b;
    km_path_pose(path, i, &a);
    km_path_pose(study->path, i, &b);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(km_path_time(path, i) == km_path_time(study->path, i));
    assert_true(km_path_length(path, i) == km_path_length(study->path, i));
  }
  assert_near(km_path_time(path, 12) - km_path_time(path, 7), 2.0, 1e-12);
  km_path_free(path);
  km_study_free(study);
  fixture_close(&f);
}

/* Samples at the points: the poses and the times are exactly those given. */
static void samples_are_the_points_where_asked(void **state) {
  (void)state;
  static const double times[3] = {4.0, 4.5, 7.0};
  const km_frame_pose points[3] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.5, 0, 0.5}},
                                   {{0, -1, 0, 1, 0, 0, 0, 0, 1}, {0.5, 0.1, 0.5}},
                                   {{0, 0, 1, 1, 0, 0, 0, 1, 0}, {0.3, 0.2, 0.4}}};
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  km_path_segment g = km_path_segment_default(KM_PATH_SPLINE);
  km_path_plan plan = km_path_plan_default();
  g.points = points;
  g.point_count = 3;
  g.times = times;
  g.own_start = g.at_points = true;
  plan.segments = &g;
  plan.segment_count = 1;
  km_path *path;
  assert_int_equal(km_path_create(arm, &plan, &path, NULL), KM_OK);
  assert_int_equal(km_path_samples(path), 3);
  for (int i = 0; i < 3; ++i) {
    km_frame_pose pose;
    km_path_pose(path, i, &pose);
    assert_near(km_path_time(path, i), times[i] - times[0], 1e-12);
    for (int k = 0; k < 12; ++k)
      assert_near(k < 9 ? pose.R[k] : pose.p[k - 9], k < 9 ? points[i].R[k] : points[i].p[k - 9], 1e-12);
  }
  km_path_free(path);
  km_arm_free(arm);
  fixture_close(&f);
}

/* Errors of a plan are reported with their location. */
static void faults_of_plans_have_places(void **state) {
  (void)state;
  static const double back[2] = {1.0, 0.5};
  const km_frame_pose points[2] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.5, 0.2, 0.5}},
                                   {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.5, 0.2, 0.6}}};
  const km_frame_pose skew[1] = {{{1, 0, 0, 0, 1, 0, 0, 0, 2}, {0.5, 0.2, 0.5}}};
  const struct {
    km_path_segment segment;
    const char *place;
  } faults[] = {
      {{.shape = KM_PATH_LINE, .steps = 0}, "segments[1].steps: "},
      {{.shape = KM_PATH_ARC, .steps = 5, .angle = 1.0}, "segments[1].axis: "},
      {{.shape = KM_PATH_ARC, .steps = 5, .angle = 1e5, .axis = {0, 0, 1}}, "segments[1].angle: "},
      {{.shape = KM_PATH_WEAVE, .steps = 5, .waves = 3}, "segments[1].sideways: "},
      {{.shape = KM_PATH_WEAVE, .steps = 5, .waves = -3, .sideways = {0, 0, 1}}, "segments[1].waves: "},
      {{.shape = KM_PATH_SPLINE, .steps = 5}, "segments[1].points: found 0 points; expected at least 1"},
      {{.shape = KM_PATH_SPLINE, .steps = 5, .points = points, .point_count = 1, .own_start = true},
       "segments[1].points: found 1 points; expected at least 2"},
      {{.shape = KM_PATH_SPLINE, .steps = 5, .points = points, .point_count = -1}, "segments[1].points: "},
      {{.shape = KM_PATH_SPLINE, .steps = 5, .points = points, .point_count = 2, .times = back},
       "segments[1].points[1]: time 0.5 after 1; "},
      {{.shape = KM_PATH_SPLINE, .steps = 5, .points = skew, .point_count = 1}, "segments[1].points[0]: "},
      {{.shape = KM_PATH_LINE, .steps = 5, .in_place = true}, "segments[1]: the effector doesn't move on it"},
      {{.shape = KM_PATH_LINE, .steps = 1000000, .to = {0.5, 0.1, 0.4}}, "segments: found 1000010 steps"},
  };
  fixture f = fixture_open("iiwa14");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
    km_path_segment g[2] = {km_path_segment_default(KM_PATH_LINE), faults[i].segment};
    km_path_plan plan = km_path_plan_default();
    km_path *path = NULL;
    km_error error;
    g[0].steps = 10;
    g[0].to[0] = 0.5;
    plan.segments = g;
    plan.segment_count = 2;
    assert_int_equal(km_path_create(arm, &plan, &path, &error), KM_USAGE);
    assert_null(path);
    if (strncmp(error.text, faults[i].place, strlen(faults[i].place)) != 0)
      fail_msg("found \"%s\"; expected \"%s\"", error.text, faults[i].place);
  }
  km_path_plan plan = km_path_plan_default();
  km_path *path;
  km_error error;
  assert_int_equal(km_path_create(arm, &plan, &path, &error), KM_USAGE);
  assert_string_equal(error.text, "segments: found none; expected at least one segment");
  plan.turn_speed = -1.0;
  assert_int_equal(km_path_create(arm, &plan, &path, &error), KM_USAGE);
  assert_string_equal(error.text, "turn_speed: found -1; expected 0 or more");
  km_arm_free(arm);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(paths_have_their_lengths),           cmocka_unit_test(paths_by_calls_go_where_they_are_told),
      cmocka_unit_test(splines_by_calls_are_those_of_text), cmocka_unit_test(samples_are_the_points_where_asked),
      cmocka_unit_test(faults_of_plans_have_places),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
