/* Errors of arms, paths and methods, each with its text, and cancelled work. */
#include "support/arms.h"
#include "support/refusals.h"

#include "kmech/arm.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>

static void expect(km_status status, km_status expected, const km_error *error, const char *words) {
  const told_text t = {"a call", words};
  assert_true(is_told(&t, status, expected, NULL, error));
}

static bool stop(void *context, double done) {
  (void)context, (void)done;
  return false;
}

static void values(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  km_error e = {.text = ""};
  km_frame_pose pose;
  double q[7] = {0}, speeds[7] = {1, 1, 0, 1, 1, 1, 1}, J[42];
  expect(km_arm_set_rates(arm, speeds, 3, &e), KM_USAGE, &e,
         "found 3 values; expected 7, one a joint from joint1 to joint7");
  expect(km_arm_set_rates(arm, speeds, 7, &e), KM_USAGE, &e, "found 0 for joint3; expected a speed greater than 0");
  q[2] = (double)NAN;
  expect(km_arm_jacobian(arm, q, J, &e), KM_USAGE, &e, "for joint3; expected a finite value");
  q[2] = 0.0;
  assert_int_equal(km_arm_place(arm, q, &pose, &e), KM_OK);
  pose.p[1] = HUGE_VAL;
  expect(km_arm_solve(arm, &pose, q, 1, NULL, NULL, q, &e), KM_USAGE, &e, "a pose at inf; expected a finite place");
  km_arm_free(arm);
  fixture_close(&f);
}

/* A planar joint changes a pose by its three coordinates. */
static void nothing_to_spare(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"frames\": [{\"name\": \"tip\"}]}], \"joints\": [{\"name\": "
      "\"F\", \"type\": \"planar\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}");
  fixture g = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"frames\": [{\"name\": \"tip\"}]}], \"joints\": [{\"name\": "
      "\"S\", \"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}");
  fixture h =
      fixture_read(/* rotation about its own joint */
                   "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"frames\": [{\"name\": \"tip\"}]}], \"joints\": [{\"name\": "
                   "\"H\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}");
  km_arm *arm = arm_of(&f, "b", "tip", KM_TASK_POSE), *none = NULL;
  km_selfmotion motion;
  km_error e = {.text = ""};
  double q[3] = {0};
  static const char *const tip[] = {"b", "tip"};
  int frame;
  expect(km_selfmotion_follow(arm, q, NULL, NULL, &motion, &e), KM_USAGE, &e,
         "spare freedoms for its task; expected 1 or 2");
  assert_int_equal(km_model_find_frame(h.model, tip, 2, &frame, NULL), KM_OK);
  expect(km_arm_create(h.mechanism, h.state, frame, KM_TASK_POSITION, &none, &e), KM_USAGE, &e,
         "no joint on the way to frame \"tip\" of body \"b\" moves it as the task counts");
  assert_int_equal(km_model_find_frame(g.model, tip, 2, &frame, NULL), KM_OK);
  expect(km_arm_create(g.mechanism, g.state, frame, KM_TASK_POSITION, &none, &e), KM_USAGE, &e,
         "joint \"S\" is a ball (spherical); expected joints with axes of their own");
  km_arm_free(arm);
  fixture_close(&f);
  fixture_close(&g);
  fixture_close(&h);
}

/* Three links of 1 m whose first hinge may hardly turn: the pose behind it is reached, but never within the limits. */
static void beyond_limits(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"frames\": [{\"name\": \"tip\", \"T\": [1, 0, 0]}]}, "
      "{\"name\": \"c\", \"frames\": [{\"name\": \"tip\", \"T\": [1, 0, 0]}]}, {\"name\": \"d\", \"frames\": [{\"name\": \"tip\", "
      "\"T\": [1, 0, 0]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"limits\": "
      "[-0.1, 0.1]}, {\"name\": \"B\", \"type\": \"Ry\", \"body_frame_pairs\": [[\"b\", \"tip\"], \"c\"], \"limits\": [-0.1, 0.1]}, "
      "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c\", \"tip\"], \"d\"], \"limits\": [-0.1, 0.1]}]}]}");
  km_arm *arm = arm_of(&f, "d", "tip", KM_TASK_POSITION);
  const double q[3] = {0.0, 0.05, 0.05}, behind[3] = {3.0, 0.2, 0.4};
  double found[3];
  km_frame_pose pose;
  km_error e = {.text = ""};
  assert_int_equal(km_arm_place(arm, behind, &pose, &e), KM_OK);
  expect(km_arm_solve(arm, &pose, q, 1, NULL, NULL, found, &e), KM_NO_RESULT, &e,
         "but never with all joints within their limits");
  km_arm_free(arm);
  fixture_close(&f);
}

static void tracks(void **state) {
  (void)state;
  opened_study o = study_open("panda_circle");
  km_track *track = NULL;
  km_error e = {.text = ""};
  static const km_method_kind kinds[] = {KM_GREEDY, KM_LOOKAHEAD, KM_DP, KM_GLOBAL};
  km_track_plan plan = km_study_plan(o.study, 0);
  for (size_t i = 0; i < COUNT(kinds); ++i) {
    plan.method = km_method_default(kinds[i]);
    plan.progress = stop;
    expect(km_track_run(km_study_arm(o.study), &plan, &track, &e), KM_CANCELLED, &e, "cancelled");
    km_track_free(track);
    track = NULL;
  }
  plan.progress = NULL;
  plan.method = km_method_default(KM_LOOKAHEAD);
  plan.method.branches = 51;
  plan.method.angle = 0.01;
  plan.method.levels = 8;
  expect(km_track_run(km_study_arm(o.study), &plan, &track, &e), KM_USAGE, &e, "nodes; expected at most");
  plan.method = km_method_default(KM_GLOBAL);
  plan.method.knots = 1;
  expect(km_track_run(km_study_arm(o.study), &plan, &track, &e), KM_USAGE, &e, "knots");
  plan.method = km_method_default(KM_FIXED);
  plan.method.joint_count = 99;
  expect(km_track_run(km_study_arm(o.study), &plan, &track, &e), KM_USAGE, &e, "joint count is 99; expected 0 to");
  km_track_free(track);
  km_study_free(o.study);
  fixture_close(&o.f);
}

/* A map shows one spare freedom; for its position alone an arm of seven joints has four. */
static void maps(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_study *study = study_of(&f, PANDA_CIRCLE ", \"task\": \"position\"}");
  km_track *none[1] = {NULL};
  const km_tracks tracks = {study, "x", "panda", none, 0};
  km_text out = {0};
  km_error e = {.text = ""};
  expect(km_tracks_map(&tracks, KM_PICTURE_SVG, &out, &e), KM_USAGE, &e,
         "the arm has 4 spare freedoms for its task; a map needs 1");
  assert_int_equal(out.size, 0);
  km_text_free(&out);
  km_study_free(study);
  fixture_close(&f);
}

#define STUDY(inside)                                                                                                  \
  "{\"effector\": [\"flange\", \"tool\"], " inside                                                                     \
  "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [0.4, 0, 0.4], \"steps\": 4}]}}"

static const told_text studies[] = {
    {STUDY("\"coordinates\": [\"joint1\", \"joint1\", \"joint3\", \"joint4\", \"joint5\", \"joint6\", \"joint7\"], "),
     "\"joint1\" is given twice; expected each joint once"},
    {STUDY("\"coordinates\": [\"joint1\"], "), "found 1 joints; expected the 7 on the way to the effector"},
    {STUDY("\"methods\": [{\"method\": \"fixed\", \"joints\": [\"elbow\"]}], "), "\"elbow\" is no joint of the arm"},
    {STUDY("\"methods\": [{\"method\": \"fixed\", \"joints\": [\"joint1\", \"joint3\"]}], "),
     "found more joints than the 1 that are to spare"},
};

static void bound_studies(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  for (size_t i = 0; i < COUNT(studies); ++i) {
    km_study_def def = km_study_def_default();
    km_study *study = NULL;
    km_error e = {.text = ""};
    km_messages *messages = km_messages_create();
    km_status status = km_study_read(studies[i].text, strlen(studies[i].text), "", messages, &def, &e);
    assert_int_equal(status, KM_OK);
    status = km_study_bind(f.mechanism, f.state, &def, 1, messages, &study, &e);
    assert_words(&studies[i], status, status == KM_USAGE ? KM_USAGE : KM_MODEL, messages, &e);
    km_study_free(study);
    km_study_def_free(&def);
    km_messages_free(messages);
  }
  fixture_close(&f);
}

/* More joints than an arm may have, and a setting that no method has. */
static void long_arms(void **state) {
  (void)state;
  enum { LINKS = 33 };
  km_text text = {0};
  km_error e = {.text = ""};
  km_arm *arm = NULL;
  int frame;
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int i = 0; i < LINKS; ++i)
    km_text_format(&text, "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"tip\", \"T\": [1, 0, 0]}]}", i ? "," : "",
                   i);
  km_text_add(&text, "], \"joints\": [{\"name\": \"J0\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b0\"]}");
  for (int i = 1; i < LINKS; ++i)
    km_text_format(&text,
                   ",{\"name\": \"J%d\", \"type\": \"R%c\", \"body_frame_pairs\": [[\"b%d\", \"tip\"], \"b%d\"]}", i,
                   "xyz"[i % 3], i - 1, i);
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  static const char *const tip[] = {"b32", "tip"};
  assert_int_equal(km_model_find_frame(f.model, tip, 2, &frame, NULL), KM_OK);
  expect(km_arm_create(f.mechanism, f.state, frame, KM_TASK_POSE, &arm, &e), KM_USAGE, &e,
         "more than 32 coordinates on the way to the effector");
  km_method method = km_method_default(KM_LOOKAHEAD);
  expect(km_method_set(&method, "colour", 1.0, &e), KM_USAGE, &e, "\"colour\" is no setting that is a number");
  km_text_free(&text);
  fixture_close(&f);
}

static void paths(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_arm *arm = arm_of(&f, "flange", "tool", KM_TASK_POSE);
  km_path *path = NULL;
  km_error e = {.text = ""};
  km_path_segment segment = km_path_segment_default(KM_PATH_LINE);
  km_path_plan plan = km_path_plan_default();
  segment.shape = (km_path_shape)77;
  plan.segments = &segment;
  plan.segment_count = 1;
  expect(km_path_create(arm, &plan, &path, &e), KM_USAGE, &e, "shape");
  km_arm_free(arm);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(values),        cmocka_unit_test(nothing_to_spare),
                                     cmocka_unit_test(tracks),        cmocka_unit_test(bound_studies),
                                     cmocka_unit_test(paths),         cmocka_unit_test(long_arms),
                                     cmocka_unit_test(beyond_limits), cmocka_unit_test(maps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
