/* Tracks that don't come to the path's end: why, and exactly where. */
#include "support/arms.h"

#include "report/record/track_record.h"

#include <stdio.h>
#include <string.h>

static void a_limit_is_located(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_study *study =
      study_of(&f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0],"
                   "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [-0.5, -0.6, 0.3], \"steps\": 100}]}}");
  km_track *track = track_of(study, 0, 1);
  size_t last = km_table_rows(track->table) - 1;
  assert_int_equal(track->end.stop, KM_TRACK_LIMIT);
  assert_int_equal(track->end.column, 3);
  assert_near(track_cell(track, last, "q.A4"), -2.0943951023931953, 1e-9);
  assert_near(track_cell(track, last, "limit_margin"), 0.0, 1e-9);
  assert_true(track_cell(track, last, "s") > track_cell(track, last - 1, "s"));
  assert_true(km_track_summarise(track).error_position < 1e-9);
  km_track_free(track);
  km_study_free(study);
  fixture_close(&f);
}

/* Straight out the arm ends at a sphere about the shoulder: wrist .82 m from (0, 0, .36). */
static void the_edge_is_located(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_study *study =
      study_of(&f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0, 0.5, 0, -1.6, 0, 0.9, 0],"
                   "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [1.5, 0.2, 0.4], \"steps\": 50}]}}");
  km_track *track = track_of(study, 0, 1);
  size_t last = km_table_rows(track->table) - 1;
  double q[KM_ARM_MAX_JOINTS];
  assert_int_equal(track->end.stop, KM_TRACK_WORKSPACE_BOUNDARY);
  for (int k = 0; k < 7; ++k)
    q[k] = km_table_row(track->table, last)[3 + k];
  km_pose at = effector_by_bodies(&f, study->arm, q);
  km_vec3 wrist = km_vec3_axpy(-0.126, at.R.axis[2], at.p);
  assert_near(km_vec3_norm(km_vec3_sub(wrist, (km_vec3){0, 0, 0.36})), 0.82, 1e-8);
  assert_near(q[3], 0.0, 1e-3); /* stretched: the angle goes with the root of the distance */
  km_track_free(track);
  km_study_free(study);
  fixture_close(&f);
}

/* However far the next sample: this circle leaves the workspace and is back by then. */
static void the_edge_is_told_by_what_lies_just_ahead(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  for (int steps = 3; steps <= 30; steps += 27) {
    char text[512];
    snprintf(
        text, sizeof text,
        "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.5, 0.1, -1.6, 0.2, 0.9, 0], \"path\": {\"segments\":"
        "[{\"type\": \"circle\", \"center\": [0.6871171117835274, 0.17720173726286242, 0.40568237642953714],"
        "\"axis\": [0, 0, 1], \"steps\": %d}]}}",
        steps);
    km_study *study = study_of(&f, text);
    km_track *track = track_of(study, 0, 1);
    assert_int_equal(track->end.stop, KM_TRACK_WORKSPACE_BOUNDARY);
    km_track_free(track);
    km_study_free(study);
  }
  fixture_close(&f);
}

/* The arm itself is far from singular where the joint that is held keeps it from going on. */
static void a_held_joint_is_named(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_study *study = study_of(&f, PANDA_CIRCLE ", \"objective\": \"singular-value\", \"methods\": [\"fixed\"]}");
  km_track *track = track_of(study, 0, 1);
  km_text text = {0};
  km_track_end_text(track, &text);
  assert_int_equal(track->end.stop, KM_TRACK_FIXED_JOINTS);
  assert_true(track_cell(track, km_table_rows(track->table) - 1, "objective.singular-value") > 0.1);
  assert_non_null(strstr(text.data, "with joint joint3 held"));
  km_text_free(&text);
  km_track_free(track);
  km_study_free(study);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_limit_is_located),
      cmocka_unit_test(the_edge_is_located),
      cmocka_unit_test(the_edge_is_told_by_what_lies_just_ahead),
      cmocka_unit_test(a_held_joint_is_named),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
