/* The shipped studies: look-ahead is at least greedy's, and near the reference of dynamic programming. */
#include "support/arms.h"

#include <string.h>

static km_track *run_method(const opened_study *o, km_method_kind kind) {
  for (int i = 0; i < km_study_methods(o->study); ++i)
    if (o->study->methods[i].kind == kind)
      return track_of(o->study, i, 2);
  fail_msg("no %s in the study", km_method_word(kind));
  return NULL;
}

static double score(const km_track *track) {
  km_track_summary s = km_track_summarise(track);
  return km_objective_by_mean(&track->plan.objective) ? s.objective_mean : s.objective_min;
}

static void look_ahead_is_near_the_reference(void **state) {
  (void)state;
  static const char *const names[] = {"iiwa_weld",  "thesis_line", "panda_circle",
                                      "iiwa_helix", "iiwa_reach",  "panda_limit"};
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
    opened_study o = study_open(names[i]);
    km_track *greedy = run_method(&o, KM_GREEDY), *ahead = run_method(&o, KM_LOOKAHEAD);
    km_track *reference = run_method(&o, KM_DP);
    assert_int_equal(ahead->end.stop, KM_TRACK_COMPLETE);
    assert_int_equal(reference->end.stop, KM_TRACK_COMPLETE);
    assert_int_equal(greedy->end.stop, strcmp(names[i], "panda_limit") == 0 ? KM_TRACK_LIMIT : KM_TRACK_COMPLETE);
    assert_true(km_track_summarise(reference).converged < 0.02);
    assert_true(score(ahead) >= score(greedy) * (1.0 - 1e-9));
    double share = km_objective_by_mean(&ahead->plan.objective) ? 0.85 : 0.95;
    assert_true(score(ahead) >= share * score(reference));
    assert_true(o.study->start_moved < 1e-6); /* the study's own start */
    km_track_free(greedy);
    km_track_free(ahead);
    km_track_free(reference);
    km_study_free(o.study);
    fixture_close(&o.f);
  }
}

/* Two lines and a quarter circle of 0.1 m, at 0.02 m/s; the torch turns with the arc. */
static void the_weld_takes_its_time(void **state) {
  (void)state;
  opened_study o = study_open("iiwa_weld");
  const km_path *path = o.study->path;
  int last = km_path_samples(path) - 1;
  double length = 0.4 + 0.05 * M_PI + 0.15;
  assert_near(km_path_travel(path, last), length, 1e-12);
  assert_near(km_path_turn(path, last), 0.5 * M_PI, 1e-12);
  assert_near(km_path_time(path, last), length / 0.02, 1e-9);
  km_study_free(o.study);
  fixture_close(&o.f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(look_ahead_is_near_the_reference),
      claim_test(the_weld_takes_its_time, "Length, turn and time of the weld: 0.4 m + 0.05π m + 0.15 m at 0.02 m/s",
                 "rounding; times to 1e-9")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
