/* Curves against closed forms: rises with their published peak factors, splines, periods, steps. */
#include "support/support.h"

#include "model/curve/curve.h"

/* Largest |s''| of the rises: 2π, 10/√3, 8π/(2 + π) (Norton, Cam Design and Manufacturing Handbook). */
static const double peak_acceleration[KM_RISES] = {2.0 * M_PI, 5.7735026918962576, 4.8880960398254166};
static const double peak_rate[KM_RISES] = {2.0, 1.875, 2.0};

/* S' = s, s' and s'' by central differences; their error is about h² s⁗/6 ≤ 1e-10 · 2000/6. */
static void rises_are_derivatives(void **state) {
  (void)state;
  const double h = 1e-5;
  for (int r = 0; r < KM_RISES; ++r) {
    double at[4], before[4], after[4], largest = 0.0, fastest = 0.0;
    for (int i = 1; i < 1000; ++i) {
      double z = i / 1000.0;
      km_rise_at((km_rise)r, z, at);
      km_rise_at((km_rise)r, z - h, before);
      km_rise_at((km_rise)r, z + h, after);
      for (int k = 0; k < 3; ++k) /* jumps of the jerk change s'' by at most h · 61 in a difference */
        assert_near((after[k] - before[k]) / (2.0 * h), at[k + 1], k == 2 ? 1e-3 : 1e-6);
      largest = fmax(largest, fabs(at[3]));
      fastest = fmax(fastest, at[2]);
    }
    assert_near(largest, peak_acceleration[r], 1e-4); /* sampled to 1e-3 of z about a smooth maximum */
    assert_near(fastest, peak_rate[r], 1e-12);
  }
}

static void rises_go_from_rest_to_rest(void **state) {
  (void)state;
  for (int r = 0; r < KM_RISES; ++r) {
    double at[4], mirrored[4];
    km_rise_at((km_rise)r, 0.0, at);
    for (int k = 0; k < 4; ++k)
      assert_at_most(at[k], 1e-15);
    km_rise_at((km_rise)r, 1.0, at);
    const double end[4] = {0.5, 1.0, 0.0, 0.0};
    for (int k = 0; k < 4; ++k)
      assert_near(at[k], end[k], 4e-15);
    for (int i = 0; i <= 50; ++i) {
      km_rise_at((km_rise)r, i / 100.0, at);
      km_rise_at((km_rise)r, 1.0 - i / 100.0, mirrored);
      assert_near(mirrored[1], 1.0 - at[1], 1e-14);
    }
    assert_int_equal(km_rise_find(km_rise_word((km_rise)r)), r);
  }
  assert_int_equal(km_rise_find("parabolic"), -1);
}

/* The value, slope and curvature of a sine from n rows a period. A periodic cubic spline on a uniform grid has errors
 * of about h⁴/384 · 4 of the value and h² /12 of the second derivative (de Boor, A Practical Guide to Splines). */
static void periodic_splines_follow_sines(void **state) {
  (void)state;
  enum { ROWS = 64 };
  double rows[2 * ROWS];
  const double period = 3.0, w = 2.0 * M_PI / period, h = period / ROWS * w;
  km_arena arena = {0};
  km_law_curve f;
  for (int i = 0; i < ROWS; ++i) {
    rows[2 * i] = 0.5 + i * period / ROWS;
    rows[2 * i + 1] = sin(w * rows[2 * i]);
  }
  assert_int_equal(km_curve_from_rows(rows, ROWS, true, period, &arena, &f), KM_CURVE_OK);
  for (int i = -300; i < 700; ++i) {
    double x = 0.0173 * i, at[3], later[3];
    km_curve_at(&f, x, at);
    km_curve_at(&f, x + 2.0 * period, later);
    assert_near(at[0], sin(w * x), 4.0 * h * h * h * h / 384.0);
    assert_near(at[1], w * cos(w * x), w * h * h * h / 12.0);
    assert_near(at[2], -w * w * sin(w * x), w * w * h * h / 8.0);
    for (int k = 0; k < 3; ++k)
      assert_near(later[k], at[k], 1e-11);
  }
  km_arena_free(&arena);
}

/* Lines: rows are met, between them the mean, outside them the ends; with a period the closing line. */
static void lines_join_rows(void **state) {
  (void)state;
  static const double rows[] = {0.0, 1.0, 1.0, 3.0, 3.0, -1.0};
  km_arena arena = {0};
  km_law_curve f, p;
  assert_int_equal(km_curve_from_rows(rows, 3, false, 0.0, &arena, &f), KM_CURVE_OK);
  assert_int_equal(km_curve_from_rows(rows, 3, false, 4.0, &arena, &p), KM_CURVE_OK);
  static const double expected[][3] = {/* x, without and with a period */
                                       {-0.5, 1.0, 0.0}, {0.0, 1.0, 1.0},   {0.5, 2.0, 2.0},  {1.0, 3.0, 3.0},
                                       {2.0, 1.0, 1.0},  {3.0, -1.0, -1.0}, {3.5, -1.0, 0.0}, {4.5, -1.0, 2.0}};
  for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
    assert_near(km_curve_value(&f, expected[i][0]), expected[i][1], 1e-15);
    assert_near(km_curve_value(&p, expected[i][0]), expected[i][2], 1e-14);
  }
  km_arena_free(&arena);
}

static void faulty_rows_are_refused(void **state) {
  (void)state;
  static const double rows[] = {0.0, 1.0, 1.0, 3.0, 2.0, 2.0};
  km_arena arena = {0};
  km_law_curve f;
  assert_int_equal(km_curve_from_rows(rows, 3, true, 1.5, &arena, &f), KM_CURVE_TOO_LONG);
  assert_int_equal(km_curve_from_rows(rows, 3, true, 2.0, &arena, &f), KM_CURVE_OPEN);
  assert_int_equal(km_curve_from_rows(rows, 1, true, 2.0, &arena, &f), KM_CURVE_OK);
  assert_near(km_curve_value(&f, 7.3), 1.0, 0.0);
  km_arena_free(&arena);
}

/* Start to the rate 2 in 1, on for 3, stop in 0.5; then a rise of −4 in 2 and a dwell: the value after each part is the
 * area below the rate, and the rate is continuous. The net change repeats after a period of 8. */
static void segments_add_up(void **state) {
  (void)state;
  static const km_motion_segment parts[] = {
      {.kind = KM_SEGMENT_RATE, .rise = KM_RISE_TRAPEZOID, .duration = 1.0, .rate = 2.0},
      {.kind = KM_SEGMENT_KEEP, .duration = 3.0},
      {.kind = KM_SEGMENT_RATE, .rise = KM_RISE_345, .duration = 0.5, .rate = 0.0},
      {.kind = KM_SEGMENT_RISE, .rise = KM_RISE_CYCLOIDAL, .duration = 2.0, .by = -4.0}};
  static const double ends[][3] = {{0.0, 5.0, 0.0}, {1.0, 6.0, 2.0}, {4.0, 12.0, 2.0}, {4.5, 12.5, 0.0},
                                   {6.5, 8.5, 0.0}, {8.0, 8.5, 0.0}, {9.0, 9.5, 2.0},  {-3.5, 9.0, 0.0}};
  km_arena arena = {0};
  km_law_curve f;
  int at;
  assert_int_equal(km_curve_from_segments(parts, 4, 5.0, 8.0, &arena, &f, &at), KM_CURVE_OK);
  for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) {
    double motion[3], before[3], after[3], h = 1e-6;
    km_curve_at(&f, ends[i][0], motion);
    km_curve_at(&f, ends[i][0] - h, before);
    km_curve_at(&f, ends[i][0] + h, after);
    assert_near(motion[0], ends[i][1], 1e-13);
    assert_near(motion[1], ends[i][2], 1e-13);
    assert_near(before[1], after[1], 1e-4);                     /* 2 h times the largest acceleration, 10 */
    assert_near(after[0] - before[0], 2e-6 * motion[1], 1e-11); /* h² times it, and rounding */
  }
  assert_int_equal(km_curve_from_segments(parts, 4, 5.0, 6.0, &arena, &f, &at), KM_CURVE_TOO_LONG);
  assert_int_equal(km_curve_from_segments(parts, 2, 5.0, 6.0, &arena, &f, &at), KM_CURVE_MOVING);
  const km_motion_segment moving[] = {parts[0], parts[3]};
  assert_int_equal(km_curve_from_segments(moving, 2, 5.0, 0.0, &arena, &f, &at), KM_CURVE_MOVING);
  assert_int_equal(at, 1);
  km_arena_free(&arena);
}

static void steps_go_from_value_to_value(void **state) {
  (void)state;
  km_arena arena = {0};
  km_law_curve jump, ramp;
  assert_int_equal(km_curve_from_step(2.0, 0.0, 1.0, 4.0, &arena, &jump), KM_CURVE_OK);
  assert_int_equal(km_curve_from_step(2.0, 0.5, 1.0, 4.0, &arena, &ramp), KM_CURVE_OK);
  static const double expected[][3] = {{-9.0, 1.0, 1.0}, {1.999, 1.0, 1.0}, {2.0, 4.0, 1.0},
                                       {2.25, 4.0, 2.5}, {2.5, 4.0, 4.0},   {99.0, 4.0, 4.0}};
  for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
    assert_near(km_curve_value(&jump, expected[i][0]), expected[i][1], 0.0);
    assert_near(km_curve_value(&ramp, expected[i][0]), expected[i][2], 1e-15);
  }
  km_arena_free(&arena);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rises_are_derivatives),         cmocka_unit_test(rises_go_from_rest_to_rest),
      cmocka_unit_test(periodic_splines_follow_sines), cmocka_unit_test(lines_join_rows),
      cmocka_unit_test(faulty_rows_are_refused),       cmocka_unit_test(segments_add_up),
      cmocka_unit_test(steps_go_from_value_to_value)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
