/* Tracks: what every method must keep, and what the methods owe each other. */
#include "support/arms.h"

#include "exchange/json/convert.h"
#include "exchange/json/json.h"
#include "report/record/track_record.h"

#include <stdio.h>
#include <string.h>

#define ALL_METHODS                                                                                                    \
  "[\"greedy\", \"lookahead\", \"fixed\", \"dls\", \"gradient\", {\"method\": \"dp\", \"spacing\": 0.4},"              \
  " {\"method\": \"global\", \"evaluations\": 40}]"
enum { METHODS = 7 };

#define PANDA_CIRCLE                                                                                                   \
  "{\"effector\": [\"flange\", \"tool\"], \"path\": {\"start\": {\"T\": [0.5, 0.0, 0.45], \"R\": [[1, 0, 0], "         \
  "[0, -1, 0], [0, 0, -1]]}, \"segments\": [{\"type\": \"circle\", \"center\": [0.4, 0.0, 0.45], \"axis\": [0, 0, "    \
  "1], "                                                                                                               \
  "\"steps\": 96}]}, \"q0\": [1.188359, -0.3642308, -1.092908, -2.1855599, -0.3532835, 1.987876, 0.2719783]"

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

/* Every row on the path, by the bodies' poses, and within limits; rates that move the effector along it. */
static void check_rows(const fixture *f, const km_study *study, const km_track *track) {
  const km_arm *arm = study->arm;
  size_t rows = km_table_rows(track->table);
  km_track_summary s = km_track_summarise(track);
  assert_true(s.error_position <= 1e-9 * arm->length && s.error_rotation <= 1e-9);
  assert_int_equal(s.violations, 0);
  for (size_t r = 0; r < rows && r <= (size_t)track->end.sample; ++r) {
    double q[KM_ARM_MOST], values[12];
    for (int k = 0; k < arm->n; ++k)
      q[k] = km_arm_read(arm, k, km_table_row(track->table, r)[3 + k]);
    km_pose at = effector_by_bodies(f, arm, q);
    km_frame_pose want;
    km_path_pose(study->path, (int)r, &want);
    double got[12] = {at.p.x, at.p.y, at.p.z};
    for (int k = 0; k < 3; ++k) {
      values[k] = want.p[k];
      for (int i = 0; i < 3; ++i)
        values[3 + 3 * k + i] = want.R[3 * i + k];
      got[3 + 3 * k] = at.R.axis[k].x;
      got[4 + 3 * k] = at.R.axis[k].y;
      got[5 + 3 * k] = at.R.axis[k].z;
    }
    for (int k = 0; k < 12; ++k)
      assert_near(got[k], values[k], k < 3 ? 1e-9 * arm->length : 1e-9);
    assert_int_equal(km_arm_limit_passed(arm, q), -1);
  }
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
      check_rows(&f, study, track);
      km_track_free(track);
    }
    km_study_free(study);
  }
  fixture_close(&f);
}

static void assert_same_rows(const km_track *a, const km_track *b) {
  assert_int_equal(km_table_rows(a->table), km_table_rows(b->table));
  for (size_t r = 0; r < km_table_rows(a->table); ++r)
    assert_memory_equal(km_table_row(a->table, r), km_table_row(b->table, r),
                        km_table_columns(a->table) * sizeof(double));
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
             "\"spacing\": 0.5}]",
             "manipulability");
  km_study *study = study_of(&f, text);
  for (int i = 0; i < 2; ++i) {
    km_track *one = track_of(study, i, 1);
    for (int jobs = 2; jobs <= 5; jobs += 3) {
      km_track *many = track_of(study, i, jobs);
      assert_same_rows(one, many);
      km_track_free(many);
    }
    km_track_free(one);
  }
  km_study_free(study);
  fixture_close(&f);
}

/* The same arm in millimetres and degrees: the same radians, objectives and column entries. */
static void units_dont_matter(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_arena arena = {0};
  km_text json = {0};
  const km_value *tree;
  km_units units = f.model->units;
  units.angle = km_unit_find(KM_ANGLE, "degrees");
  units.length = km_unit_find(KM_LENGTH, "millimeters");
  assert_int_equal(km_model_convert(f.model, &units, NULL, false, &arena, &tree, NULL), KM_OK);
  km_json_write(tree, &json);
  fixture g = fixture_read(json.data);
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
        double factor = strcmp(name, "s") == 0 || strcmp(name, "error_position") == 0     ? 1e-3
                        : strcmp(name, "error_rotation") == 0 || strcmp(unit, "rad") != 0 ? 1.0
                                                                                          : M_PI / 180.0;
        if (strncmp(name, "v.", 2) == 0)
          factor = M_PI / 180.0;
        assert_near(km_table_row(x->table, r)[c], factor * km_table_row(y->table, r)[c], 1e-9);
      }
    km_track_free(x);
    km_track_free(y);
  }
  km_study_free(a);
  km_study_free(b);
  km_text_free(&json);
  km_arena_free(&arena);
  fixture_close(&f);
  fixture_close(&g);
}

/* Where look-ahead isn't at least as good it gives greedy's track. */
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
    check_rows(&f, study, ahead);
    km_track_free(greedy);
    km_track_free(ahead);
    km_study_free(study);
  }
  fixture_close(&f);
}

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
  double q[KM_ARM_MOST];
  assert_int_equal(track->end.stop, KM_TRACK_EDGE);
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

static void rates_are_kept(void **state) {
  (void)state;
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(
      &f,
      "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.6, 0.1, -1.4, 0.3, 0.9, 0], \"path\": {\"speed\": 0.5,"
      "\"segments\": [{\"type\": \"line\", \"to\": [0.4, 0.45, 0.5], \"steps\": 60}]},"
      "\"rates\": [0.75, 1.45, 1.7, 1.3, 2.2, 2.3, 2.3], \"methods\": [\"greedy\", \"lookahead\"]}");
  for (int i = 0; i < 2; ++i) {
    km_track *track = track_of(study, i, 1);
    assert_int_equal(track->end.stop, i ? KM_TRACK_COMPLETE : KM_TRACK_RATE); /* look-ahead finds a way round */
    assert_int_equal(track->end.column, i ? -1 : 0);
    for (size_t r = 0; r < km_table_rows(track->table); ++r)
      assert_true(fabs(track_cell(track, r, "v.A1")) <= 0.75 * (1.0 + 1e-9));
    km_track_free(track);
  }
  km_study_free(study);
  fixture_close(&f);
}

/* No row of a track is faster than the rates, between its samples neither, and its rate margin says so. */
static void check_rates(const km_track *track, const double *rate) {
  const km_arm *arm = track->arm;
  const km_table *table = track->table;
  assert_int_equal(km_track_summarise(track).violations, 0);
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    const double *row = km_table_row(table, r);
    double margin = 1.0;
    for (int k = 0; k < arm->n; ++k) {
      margin = fmin(margin, 1.0 - fabs(row[3 + arm->n + k]) / rate[k]);
      if (r + 1 < km_table_rows(table)) {
        const double *next = km_table_row(table, r + 1);
        assert_true(fabs(next[3 + k] - row[3 + k]) / (next[2] - row[2]) <= rate[k] * (1.0 + 1e-9));
      }
    }
    assert_true(margin >= -1e-9);
    assert_near(track_cell(track, r, "objective.rate-margin"), margin, 1e-12);
  }
}

/* At the start greedy's rate of A7 is .2147: only a track that leaves it otherwise keeps .2; and fixed, which nears a
 * singular pose between samples. */
static void rates_are_those_of_the_track(void **state) {
  (void)state;
  static const double slow[7] = {0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2}, fast[7] = {3, 3, 3, 3, 3, 3, 3};
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(
      &f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.23349215770225018, 0.26035290052477955, "
          "-0.3627097588915864, -1.0297798799285236, -0.5355568075983933, -0.891974004983985, 0.7161869578901001],"
          "\"path\": {\"speed\": 0.1, \"segments\": [{\"type\": \"line\", \"to\": [0.6597432320109469, "
          "0.18715067349256231, 0.8623306490231781], \"steps\": 60}]}, \"methods\": [\"lookahead\", \"greedy\"],"
          "\"objective\": {\"singular-value\": 1, \"rate-margin\": 1e-6}, \"rates\": [0.2, 0.2, 0.2, 0.2, 0.2, "
          "0.2, 0.2]}");
  for (int i = 0; i < 2; ++i) {
    km_track *track = track_of(study, i, 1);
    assert_int_equal(track->end.stop, i ? KM_TRACK_RATE : KM_TRACK_COMPLETE);
    assert_int_equal(track->end.sample, i ? 0 : 60);
    check_rates(track, slow);
    km_track_free(track);
  }
  km_study_free(study);
  fixture_close(&f);
  f = fixture_open("panda");
  study = study_of(&f, PANDA_CIRCLE ", \"objective\": {\"singular-value\": 1, \"rate-margin\": 1e-6}, \"methods\": "
                                    "[\"fixed\"], \"rates\": [3, 3, 3, 3, 3, 3, 3]}");
  km_track *track = track_of(study, 0, 1);
  assert_int_equal(track->end.stop, KM_TRACK_RATE);
  check_rates(track, fast);
  km_track_free(track);
  km_study_free(study);
  fixture_close(&f);
}

/* Greedy comes to an end by the rates; a small self-motion, other than 30° asks for, leads on. With one branch there is
 * none. */
static void small_self_motions_are_found(void **state) {
  (void)state;
  static const double rate[7] = {0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2};
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(
      &f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.5, 0.1, -1.6, 0.2, 0.9, 0],"
          "\"path\": {\"speed\": 0.1, \"segments\": [{\"type\": \"line\", \"to\": [0.5, 0.4, 0.4], \"steps\": 60}]},"
          "\"methods\": [\"greedy\", {\"method\": \"lookahead\", \"branches\": 1}, \"lookahead\", \"dp\"],"
          "\"objective\": {\"singular-value\": 1, \"rate-margin\": 1e-6}, \"rates\": [0.2, 0.2, 0.2, 0.2, 0.2, 0.2, "
          "0.2]}");
  km_track *greedy = track_of(study, 0, 1), *one = track_of(study, 1, 1);
  assert_int_equal(greedy->end.stop, KM_TRACK_RATE);
  assert_same_rows(greedy, one);
  km_track_free(greedy);
  km_track_free(one);
  for (int i = 2; i < 4; ++i) {
    km_track *track = track_of(study, i, 1), *threads = track_of(study, i, 3);
    assert_int_equal(track->end.stop, KM_TRACK_COMPLETE);
    check_rows(&f, study, track);
    check_rates(track, rate);
    assert_same_rows(track, threads);
    assert_true(i == 2 || track->summary.converged < 0.02);
    km_track_free(track);
    km_track_free(threads);
  }
  km_study_free(study);
  fixture_close(&f);
}

/* The same with four freedoms to spare: greedy's first step is too fast, look-ahead's isn't. */
static void small_self_motions_of_several_freedoms(void **state) {
  (void)state;
  static const double rate[7] = {0.09, 0.09, 0.09, 0.09, 0.09, 0.09, 0.09};
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(
      &f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.5, 0.1, -1.6, 0.2, 0.9, 0], \"task\": \"position\","
          "\"path\": {\"speed\": 0.1, \"segments\": [{\"type\": \"line\", \"to\": [0.5, 0.4, 0.4], \"steps\": 60}]},"
          "\"methods\": [\"greedy\", \"lookahead\"], \"objective\": \"rate-margin\","
          "\"rates\": [0.09, 0.09, 0.09, 0.09, 0.09, 0.09, 0.09]}");
  km_track *greedy = track_of(study, 0, 1), *ahead = track_of(study, 1, 1);
  assert_int_equal(greedy->end.sample, 0);
  assert_true(ahead->end.sample > 30);
  check_rates(ahead, rate);
  km_track_free(greedy);
  km_track_free(ahead);
  km_study_free(study);
  fixture_close(&f);
}

/* Where no self-motion keeps the rates every method stops, and dynamic programming is no reference. */
static void too_small_rates_stop_all(void **state) {
  (void)state;
  static const double rate[7] = {0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05};
  fixture f = fixture_open("iiwa14");
  km_study *study = study_of(
      &f, "{\"effector\": [\"flange\", \"tool\"], \"q0\": [0.2, 0.5, 0.1, -1.6, 0.2, 0.9, 0],"
          "\"path\": {\"speed\": 0.1, \"segments\": [{\"type\": \"line\", \"to\": [0.5, 0.4, 0.4], \"steps\": 60}]},"
          "\"methods\": [\"lookahead\", \"dp\"], \"objective\": {\"singular-value\": 1, \"rate-margin\": 1e-6},"
          "\"rates\": [0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05]}");
  for (int i = 0; i < 2; ++i) {
    km_track *track = track_of(study, i, 1);
    assert_int_equal(track->end.stop, KM_TRACK_RATE);
    assert_true(isnan(track->summary.converged));
    check_rates(track, rate);
    km_track_free(track);
  }
  km_study_free(study);
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

/* The arm itself is far from singular where the joint that is held keeps it from going on. */
static void a_held_joint_is_named(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  km_study *study = study_of(&f, PANDA_CIRCLE ", \"objective\": \"singular-value\", \"methods\": [\"fixed\"]}");
  km_track *track = track_of(study, 0, 1);
  km_text text = {0};
  km_track_end_text(track, &text);
  assert_int_equal(track->end.stop, KM_TRACK_HELD);
  assert_true(track_cell(track, km_table_rows(track->table) - 1, "objective.singular-value") > 0.1);
  assert_non_null(strstr(text.data, "with joint joint3 held"));
  km_text_free(&text);
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
    assert_int_equal(track->end.stop, KM_TRACK_EDGE);
    km_track_free(track);
    km_study_free(study);
  }
  fixture_close(&f);
}

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

/* Eight coordinates with slides and a screw, five rows: three to spare. */
static void other_arms_and_tasks(void **state) {
  (void)state;
  static const char *const tasks[] = {"pose", "axis", "position"};
  fixture f = odd_arm();
  for (int i = 0; i < 3; ++i) {
    char text[1024];
    double start[KM_ARM_MOST];
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
      if (track->plan.method.kind != KM_FIXED) /* with two joints held the others meet a singular pose */
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

/* The same study gives the same record, to the byte: it holds no times of work. Angles are in the model's unit. */
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
      cmocka_unit_test(all_methods_stay_on_the_path),
      cmocka_unit_test(one_branch_is_greedy),
      cmocka_unit_test(threads_dont_matter),
      cmocka_unit_test(units_dont_matter),
      cmocka_unit_test(look_ahead_is_at_least_greedy),
      cmocka_unit_test(a_limit_is_located),
      cmocka_unit_test(the_edge_is_located),
      cmocka_unit_test(rates_are_kept),
      cmocka_unit_test(rates_are_those_of_the_track),
      cmocka_unit_test(greedy_moves_by_its_column),
      cmocka_unit_test(a_held_joint_is_named),
      cmocka_unit_test(small_self_motions_are_found),
      cmocka_unit_test(small_self_motions_of_several_freedoms),
      cmocka_unit_test(too_small_rates_stop_all),
      cmocka_unit_test(the_edge_is_told_by_what_lies_just_ahead),
      cmocka_unit_test(paths_have_their_lengths),
      cmocka_unit_test(other_arms_and_tasks),
      cmocka_unit_test(records_are_the_same_every_time),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
