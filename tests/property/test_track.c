/* Tracks: what every method must keep, and what the methods owe each other. */
#include "support/arms.h"

#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "report/record/track_record.h"

#include <stdio.h>
#include <string.h>

#define ALL_METHODS                                                                                                    \
  "[\"greedy\", \"lookahead\", \"fixed\", \"dls\", \"gradient\", {\"method\": \"dp\", \"spacing\": 0.4},"              \
  " {\"method\": \"global\", \"evaluations\": 40}]"
enum { METHODS = 7 };

/* A line, a helix that turns the effector, and a line that turns it to straight down; k is a metre. */
static void iiwa_study(char *out, size_t size, double k, double angle, const char *methods, const char *objective) {
  snprintf(
      out, size,
      "{\"effector\": [\"flange\", \"tool\"], \"q0\": [%.17g, %.17g, %.17g, %.17g, %.17g, %.17g, 0],"
      "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [%.17g, %.17g, %.17g], \"steps\": 12},"
      "{\"type\": \"helix\", \"center\": [%.17g, %.17g, 0], \"axis\": [0, 0, 2], \"angle\": %.17g, \"pitch\": %.17g,"
      " \"turn\": true, \"steps\": 10}, {\"type\": \"line\", \"to\": [%.17g, %.17g, %.17g],"
      " \"R_to\": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], \"steps\": 12}]},"
      "\"methods\": %s, \"objective\": \"%s\"}",
      0.2 * angle, 0.6 * angle, 0.1 * angle, -1.4 * angle, 0.3 * angle, 0.9 * angle, 0.4 * k, 0.45 * k, 0.5 * k,
      0.45 * k, 0.4 * k, 1.0 * angle, 0.05 * k, 0.5 * k, 0.3 * k, 0.55 * k, methods, objective);
}

static void all_methods_stay_on_the_path(void **state) {
  (void)state;
  static const char *const objectives[] = {"singular-value", "limit-distance", "path-control"};
  fixture f = fixture_open("iiwa14");
  for (int o = 0; o < 3; ++o) {
    char text[2048];
    iiwa_study(text, sizeof text, 1.0, 1.0, ALL_METHODS, objectives[o]);
    km_study *study = study_of(&f, text);
    for (int i = 0; i < METHODS; ++i) {
      km_track *track = track_of(study, i, 1);
      assert_int_equal(track->end.stop, KM_TRACK_COMPLETE);
      assert_int_equal(km_table_rows(track->table), 35);
      assert_on_path(&f, study, track);
      km_track_free(track);
    }
    km_study_free(study);
  }
  fixture_close(&f);
}

static void one_branch_is_greedy(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  char text[2048];
  iiwa_study(text, sizeof text, 1.0, 1.0, "[\"pinv\", {\"method\": \"lookahead\", \"branches\": 1}]", "singular-value");
  km_study *study = study_of(&f, text);
  km_track *greedy = track_of(study, 0, 1), *ahead = track_of(study, 1, 1);
  assert_same_rows(greedy, ahead);
  km_track_free(greedy);
  km_track_free(ahead);
  km_study_free(study);
  fixture_close(&f);
}

static void threads_dont_matter(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  char text[2048];
  iiwa_study(text, sizeof text, 1.0, 1.0,
             "[{\"method\": \"lookahead\", \"branches\": 5, \"levels\": 2, \"angle\": 20}, {\"method\": \"dp\", "
             "\"spacing\": 0.5}, {\"method\": \"lookahead\", \"branches\": 3, \"levels\": 3, \"stride\": 8}, "
             "{\"method\": \"lookahead\", \"branches\": 5, \"levels\": 2, \"stride\": 8}, \"greedy\"]",
             "manipulability");
  km_study *study = study_of(&f, text);
  for (int i = 0; i < 5; ++i) {
    km_track *one = track_of(study, i, 1);
    static const int jobs[] = {2, 5, 1000000};
    for (size_t k = 0; k < sizeof jobs / sizeof *jobs; ++k) {
      if (jobs[k] > 5 && i != 4) /* greedy alone has no place for each thread */
        continue;
      km_track *many = track_of(study, i, jobs[k]);
      assert_same_rows(one, many);
      assert_true(one->summary.evaluations == many->summary.evaluations);
      km_track_free(many);
    }
    km_track_free(one);
  }
  km_study_free(study);
  fixture_close(&f);
}

/* Value in metres of a unit of force or energy in millimetres; 0: another unit. */
static double of_forces(const char *unit) {
  static const struct {
    const char *unit;
    double factor;
  } units[] = {{"N*mm", 1e-3}, {"N*mm/s", 1e-3}, {"N^2*mm^2", 1e-6}};
  for (size_t i = 0; i < sizeof units / sizeof *units; ++i)
    if (strcmp(units[i].unit, unit) == 0)
      return units[i].factor;
  return 0.0;
}

/* The arm in millimetres and degrees has equal radians, objectives, column entries and joint forces. Configurations
 * agree to Newton's 1e-12, rates to that over a step's time of some 0.01 s, accelerations to that over its square. */
static void units_dont_matter(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  fixture g = fixture_in_units(&f, "degrees", "millimeters", NULL, NULL);
  char metres[2048], millimetres[2048];
  iiwa_study(metres, sizeof metres, 1.0, 1.0, ALL_METHODS, "singular-value");
  iiwa_study(millimetres, sizeof millimetres, 1000.0, 180.0 / M_PI, ALL_METHODS, "singular-value");
  km_study *a = study_of(&f, metres), *b = study_of(&g, millimetres);
  for (int i = 0; i < METHODS; ++i) {
    km_track *x = track_of(a, i, 1), *y = track_of(b, i, 1);
    assert_int_equal(km_table_rows(x->table), km_table_rows(y->table));
    size_t columns = km_table_columns(x->table);
    for (size_t r = 0; r < km_table_rows(x->table); ++r)
      for (size_t c = 0; c < columns; ++c) {
        const char *name = km_table_name(x->table, c), *unit = km_table_unit(x->table, c);
        const double value = km_table_row(x->table, r)[c], other = km_table_row(y->table, r)[c],
                     forces = of_forces(km_table_unit(y->table, c));
        if (forces > 0.0) {
          assert_near(value, forces * other, 1e-8 * fmax(1.0, fabs(value)));
          continue;
        }
        double factor = strcmp(name, "s") == 0 || strcmp(name, "error_position") == 0     ? 1e-3
                        : strcmp(name, "error_rotation") == 0 || strcmp(unit, "rad") != 0 ? 1.0
                                                                                          : M_PI / 180.0;
        if (strncmp(name, "v.", 2) == 0)
          factor = M_PI / 180.0;
        assert_near(value, factor * other, 1e-9);
      }
    km_track_free(x);
    km_track_free(y);
  }
  km_study_free(a);
  km_study_free(b);
  fixture_close(&f);
  fixture_close(&g);
}

/* Look-ahead returns the greedy track if it isn't at least as good. */
static void look_ahead_is_at_least_greedy(void **state) {
  (void)state;
  static const char *const objectives[] = {"singular-value", "limit-distance", "path-control", "manipulability",
                                           "rate-margin"};
  randomness r = {21};
  fixture f = fixture_open("panda");
  for (int trial = 0; trial < 15; ++trial) {
    char text[1024];
    snprintf(
        text, sizeof text,
        "{\"effector\": [\"flange\", \"tool\"], \"path\": {\"segments\": [{\"type\": \"line\", \"to\": [%g, %g, %g],"
        "\"steps\": 24}]}, \"rates\": [9, 9, 9, 9, 9, 9, 9], \"methods\": [\"greedy\", \"lookahead\"], \"objective\": "
        "\"%s\"}",
        uniform(&r, 0.2, 0.6), uniform(&r, -0.5, 0.5), uniform(&r, 0.2, 0.7), objectives[trial % 5]);
    km_study *study = study_of(&f, text);
    km_track *greedy = track_of(study, 0, 1), *ahead = track_of(study, 1, 1);
    km_track_summary a = km_track_summarise(greedy), b = km_track_summarise(ahead);
    assert_true(ahead->end.sample >= greedy->end.sample);
    if (ahead->end.sample == greedy->end.sample && trial % 5 == 2)
      assert_true(b.objective_mean >= a.objective_mean * (1.0 - 1e-8));
    else if (ahead->end.sample == greedy->end.sample)
      assert_true(b.objective_min >= a.objective_min * (1.0 - 1e-8));
    assert_on_path(&f, study, ahead);
    km_track_free(greedy);
    km_track_free(ahead);
    km_study_free(study);
  }
  fixture_close(&f);
}

/* Greedy's rates are q′ ds/dt, its path-control column's. */
static void greedy_moves_by_its_column(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_study *study =
      study_of(&f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0], \"path\": "
                   "{\"speed\": 0.5, \"segments\": [{\"type\": \"line\", \"to\": [0.4, 0.45, 0.5], \"steps\": 60}]}}");
  km_track *track = track_of(study, 0, 1);
  for (size_t r = 0; r < km_table_rows(track->table); ++r)
    for (int k = 0; k < 7; ++k) {
      const double *row = km_table_row(track->table, r);
      assert_near(row[10 + k], row[17 + k] / row[24] * 0.5 / study->arm->length, 0.01); /* a step's share of the rate */
    }
  km_track_free(track);
  km_study_free(study);
  fixture_close(&f);
}

/* Eight coordinates with slides and a screw, five rows: three to spare. */
static void other_arms_and_tasks(void **state) {
  (void)state;
  static const char *const tasks[] = {"pose", "axis", "position"};
  fixture f = odd_arm();
  for (int i = 0; i < 3; ++i) {
    char text[1024];
    double start[KM_ARM_MAX_JOINTS];
    km_arm *arm = arm_of(&f, "hand", "tip", KM_TASK_POSE);
    for (int k = 0; k < arm->n; ++k)
      start[k] = f.mechanism->start[arm->coordinate[k]] / arm->unit[k];
    km_pose at = effector_by_bodies(&f, arm, start);
    km_arm_free(arm);
    snprintf(text, sizeof text,
             "{\"effector\": [\"hand\", \"tip\"], \"task\": \"%s\", \"objective\": {\"singular-value\": 1, "
             "\"limit-distance\": 0.1},"
             "\"path\": {\"segments\": [{\"type\": \"line\", \"to\": [%.15g, %.15g, %.15g], \"steps\": 10}]},"
             "\"methods\": [\"greedy\", \"lookahead\", \"fixed\", \"dls\", \"gradient\"]}",
             tasks[i], at.p.x + 0.1, at.p.y - 0.12, at.p.z + 0.05);
    km_study *study = study_of(&f, text);
    for (int m = 0; m < km_study_methods(study); ++m) {
      km_track *track = track_of(study, m, 1);
      if (track->plan.method.kind != KM_FIXED) /* the others reach a singular configuration if two joints are fixed */
        assert_int_equal(track->end.stop, KM_TRACK_COMPLETE);
      assert_true(km_track_summarise(track).error_position <= 1e-9);
      assert_true(km_track_summarise(track).error_rotation <= 1e-9);
      km_track_free(track);
    }
    km_study_free(study);
    for (int c = 0; c < f.mechanism->coordinate_count; ++c)
      f.state->q[c] = f.mechanism->start[c];
  }
  fixture_close(&f);
}

/* Equal studies give equal records, byte by byte, without computing times. Angles are in the model's unit. */
static void records_are_the_same_every_time(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_text text[2] = {{0}, {0}};
  for (int i = 0; i < 2; ++i) {
    km_study *study = study_of(
        &f, "{\"effector\": \"flange/tool\", \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0], \"path\": {\"segments\":"
            "[{\"type\": \"line\", \"to\": [0.5, 0.4, 0.4], \"steps\": 40}]}, \"methods\": [\"greedy\", \"dp\"]}");
    km_track *items[2] = {track_of(study, 0, 1), track_of(study, 1, 2)};
    km_tracks tracks = {study, "x", "x", items, 2};
    km_arena arena = {0};
    const km_value *record = km_tracks_record(&tracks, "", &arena);
    assert_non_null(record);
    km_json_write(record, &text[i]);
    km_tracks_print(&tracks, &text[i]);
    km_arena_free(&arena);
    for (int k = 0; k < 2; ++k)
      km_track_free(items[k]);
    km_study_free(study);
  }
  assert_string_equal(text[0].data, text[1].data);
  km_text_free(&text[0]);
  km_text_free(&text[1]);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(all_methods_stay_on_the_path, "Every method for redundant arms stays on the path",
                 "the tolerance that tracks promise"),
      cmocka_unit_test(one_branch_is_greedy),
      cmocka_unit_test(threads_dont_matter),
      cmocka_unit_test(units_dont_matter),
      cmocka_unit_test(look_ahead_is_at_least_greedy),
      cmocka_unit_test(greedy_moves_by_its_column),
      cmocka_unit_test(other_arms_and_tasks),
      cmocka_unit_test(records_are_the_same_every_time),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
