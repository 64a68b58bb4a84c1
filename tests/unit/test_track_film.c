/* The film of a track: its frames are rows of the track, its stops are at the rows that they name. */
#include "report/document/track_film.h"

#include "arm/tracking/joint_course.h"
#include "support/arms.h"
#include "support/shown.h"

#include <math.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

static void frames_are_rows(void **state) {
  (void)state;
  opened_study o = study_open("panda_limit");
  km_track *track = track_of(o.study, 1, 1);
  const km_tracks all = {o.study, "panda_limit", "panda", &track, 1};
  const size_t rows = km_table_rows(track->table);
  const km_motion_stop stops[2] = {{0.0, "first"}, {(double)(rows - 1), "last"}};
  km_arena arena = {0};
  km_track_film film = {.films = {NULL}};
  km_error error = {0};
  assert_int_equal(km_track_film_make(&all, stops, 2, &arena, &film, &error), KM_OK);
  const size_t frames = film.drawing.pose_count;
  assert_true(frames > 1 && frames <= 100 && frames <= rows);
  assert_int_equal(film.arm.frame_count, frames);
  assert_int_equal(film.curves.frame_count, frames);
  assert_true(film.page.values[0] == shown_cell(track->table, 0, "", "s"));
  assert_true(film.page.values[frames - 1] == shown_cell(track->table, rows - 1, "", "s"));
  for (size_t f = 1; f < frames; ++f)
    assert_true(film.page.values[f] > film.page.values[f - 1]);
  assert_true(film.page.stops[0].pose == 0.0);
  assert_near(film.page.stops[1].pose, (double)(frames - 1), 1e-9);
  km_track_film_close(&film);
  km_arena_free(&arena);
  km_track_free(track);
  km_study_free(o.study);
  fixture_close(&o.f);
}

/* Margin and rate of a joint against an evaluation of their definitions over the rows. */
static void courses_are_extremes(void **state) {
  (void)state;
  opened_study o = study_open("panda_limit");
  km_track *track = track_of(o.study, 1, 1);
  double least = HUGE_VAL;
  for (int k = 0; k < track->arm->n; ++k) {
    const km_joint_course course = km_joint_course_find(track, k);
    const char *label = km_arm_label(track->arm, k);
    const double low = km_arm_to_units(track->arm, k, track->arm->low[k]),
                 high = km_arm_to_units(track->arm, k, track->arm->high[k]);
    double margin = HUGE_VAL, rate = 0.0;
    for (size_t r = 0; r < km_table_rows(track->table); ++r) {
      const double q = shown_cell(track->table, r, "q.", label);
      margin = fmin(margin, fmin(q - low, high - q) / (0.5 * (high - low)));
      rate = fmax(rate, fabs(shown_cell(track->table, r, "v.", label)));
    }
    assert_near(course.margin, margin, 1e-12);
    assert_true(course.rate == rate);
    least = fmin(least, margin);
  }
  assert_near(km_joint_course_find(track, km_limiting_joint(track)).margin, least, 1e-12);
  km_track_free(track);
  km_study_free(o.study);
  fixture_close(&o.f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(frames_are_rows), cmocka_unit_test(courses_are_extremes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
