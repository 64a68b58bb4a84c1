/* Tracks under joint rate limits: limits are kept, reported, and avoided by self-motions. */
#include "support/arms.h"

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

/* The initial rate of A7 by greedy is 0.2147: only a track that departs otherwise keeps 0.2; and fixed, which
 * approaches a singular configuration between samples. */
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

/* Greedy ends at the rate limits; a small self-motion, other than 30°, continues. One branch has none. */
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
    assert_on_path(&f, study, track);
    check_rates(track, rate);
    assert_same_rows(track, threads);
    assert_true(i == 2 || track->summary.converged < 0.02);
    km_track_free(track);
    km_track_free(threads);
  }
  km_study_free(study);
  fixture_close(&f);
}

/* Four redundant freedoms: greedy's first step is too fast, look-ahead's isn't. */
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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rates_are_kept),
      cmocka_unit_test(rates_are_those_of_the_track),
      cmocka_unit_test(small_self_motions_are_found),
      cmocka_unit_test(small_self_motions_of_several_freedoms),
      cmocka_unit_test(too_small_rates_stop_all),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
