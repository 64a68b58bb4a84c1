/* Path synthesis: the study of a published problem ends at a linkage that is nearer to the points than the published
 * one. The linkage is judged by its own closed form. */
#include "support/designs.h"

#include "kmech/base.h"

#include <math.h>

/* Sum of the squared distances from the path, mm²: Cabrera, Simon and Prado, Mechanism and Machine Theory 37 (2002),
 * case 1. */
static const double published = 0.0262;

/* The linkage's numbers in the order of the study's parameters. */
enum { CRANK_X, CRANK_Y, ROCKER_X, ROCKER_Y, CRANK, COUPLER, ROCKER, POINT_X, POINT_Y, NUMBERS };

/* The coupler's point at a crank angle, with the coupler's end on the left of the way from the crank's to the
 * rocker's pivot, as the study's model has it. */
static void point_at(const double *n, double angle, double *x, double *y) {
  double bx = n[CRANK_X] + n[CRANK] * cos(angle), by = n[CRANK_Y] + n[CRANK] * sin(angle);
  double dx = n[ROCKER_X] - bx, dy = n[ROCKER_Y] - by, d = hypot(dx, dy);
  double turn = acos((n[COUPLER] * n[COUPLER] + d * d - n[ROCKER] * n[ROCKER]) / (2.0 * n[COUPLER] * d));
  double b = atan2(dy, dx) + turn;
  *x = bx + n[POINT_X] * cos(b) - n[POINT_Y] * sin(b);
  *y = by + n[POINT_X] * sin(b) + n[POINT_Y] * cos(b);
}

/* The samples lie less than 0.01 mm apart: they leave less than 6 · 0.005² mm². */
static double sum_of_squares(const double *n) {
  enum { SAMPLES = 20000 };
  double sum = 0.0;
  for (int k = 0; k < 6; ++k) {
    double least = HUGE_VAL;
    for (int i = 0; i < SAMPLES; ++i) {
      double x, y;
      point_at(n, 2.0 * M_PI * i / SAMPLES, &x, &y);
      assert_true(isfinite(x) && isfinite(y));
      least = fmin(least, (x - 20.0) * (x - 20.0) + (y - 20.0 - 5.0 * k) * (y - 20.0 - 5.0 * k));
    }
    sum += least;
  }
  return sum;
}

static void nearer_than_published(void **state) {
  (void)state;
  km_design_study_def def = km_design_study_default();
  km_design_study *study;
  km_error error = {.text = ""};
  km_text text = {0};
  double values[NUMBERS];
  assert_int_equal(km_file_read(STUDIES_DIR "/path_synthesis/study.json", &text, &error), KM_OK);
  km_messages *messages = km_messages_create();
  if (km_design_study_read(text.data, text.size, messages, &def, &error))
    fail_msg("%s", error.text);
  def.model = STUDIES_DIR "/path_synthesis/linkage.json";
  if (km_design_study_open(&def, NULL, false, &study, &error) || km_design_study_run(study, 1, NULL, NULL, &error))
    fail_msg("%s", error.text);
  int best = km_design_study_best(study);
  assert_true(best > 0);
  assert_int_equal(def.parameter_count, NUMBERS);
  assert_int_equal(km_design_study_values(study, best, values, &error), KM_OK);
  km_design_result r = designs_result(study, best);
  double sum = sum_of_squares(values);
  assert_at_most(sum, published);
  /* The figure takes chords of 0.6 mm at most for the path, whose radius is above 20 mm: c² / (8 r) off it. */
  assert_near(r.figures[0], sqrt(sum / 6.0), 0.6 * 0.6 / (8.0 * 20.0));
  km_design_study_free(study);
  km_design_study_def_free(&def);
  km_messages_free(messages);
  km_text_free(&text);
}

int main(void) {
  const struct CMUnitTest tests[] = {claim_test(
      nearer_than_published, "Path synthesis: Σd² from six points, mm², below that of Cabrera, Simon and Prado (2002)",
      "what they reached")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
