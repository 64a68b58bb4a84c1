/* Two dead points of one joint between the same two rows of a sweep: a slide that follows a cubic of another one
 * stands where the slope of that is 0. */
#include "support/motion_families.h"
#include "support/support.h"

#include "kmech/sweep.h"
#include "sweep/events/event_location.h"

#include <stdio.h>

/* y = x³/3 - e x: the rate of y is x² - e. */
static fixture open_cubic(double e) {
  char text[1024];
  snprintf(
      text, sizeof text,
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"one\"}, {\"name\": \"other\"}], "
      "\"joints\": [{\"name\": \"x\", \"type\": \"prismatic\", \"bodies\": [\"fixed\", \"one\"], \"at\": [0, 0], "
      "\"axis\": [1, 0]}, {\"name\": \"y\", \"type\": \"prismatic\", \"bodies\": [\"fixed\", \"other\"], \"at\": [0, 1], "
      "\"axis\": [1, 0]}], \"couplings\": [{\"name\": \"c\", \"joints\": [\"y\", \"x\"], \"polynomial\": "
      "[0, %.17g, 0, 0.33333333333333331]}]}]}",
      -e);
  return fixture_read(text);
}

static km_mobility_sweep swept(const fixture *f, km_sweep_plan plan) {
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f->mechanism, f->state, &plan, &sweep, NULL), KM_OK);
  return sweep;
}

/* By a driver, forth and back, in the order of the sweep; by few rows and by many. */
static void two_between_two_rows(void **state) {
  (void)state;
  static const double widths[] = {0.2, 0.05, 1e-2, 1e-3};
  static const int steps[] = {3, 4, 7, 12, 50, 1000};
  for (size_t i = 0; i < sizeof widths / sizeof *widths; ++i)
    for (size_t k = 0; k < sizeof steps / sizeof *steps; ++k)
      for (double sense = 1.0; sense >= -1.0; sense -= 2.0) {
        fixture f = open_cubic(widths[i] * widths[i]);
        km_mobility_sweep sweep =
            swept(&f, (km_sweep_plan){.from = -1.0 * sense, .to = 1.3 * sense, .steps = steps[k], .direction = -1});
        assert_int_equal(sweep.toggle_count, 2);
        for (int t = 0; t < 2; ++t) {
          assert_int_equal(sweep.toggles[t].coordinate, 1);
          assert_near(sweep.toggles[t].s, sense * (t ? widths[i] : -widths[i]), 1e-11 / widths[i]);
        }
        km_mobility_sweep_free(&sweep);
        fixture_close(&f);
      }
}

/* A slope that stays above 0 is no dead point, however near it comes; one that touches 0 is one. */
static void near_and_at_zero(void **state) {
  (void)state;
  for (double least = 1e-7; least < 1.0; least *= 10.0) {
    fixture f = open_cubic(-least);
    km_mobility_sweep sweep = swept(&f, (km_sweep_plan){.from = -1.0, .to = 1.3, .steps = 7, .direction = -1});
    assert_int_equal(sweep.toggle_count, 0);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
  fixture f = open_cubic(0.0);
  km_mobility_sweep sweep = swept(&f, (km_sweep_plan){.from = -1.0, .to = 1.3, .steps = 7, .direction = -1});
  assert_int_equal(sweep.toggle_count, 1);
  assert_near(sweep.toggles[0].s, 0.0, sqrt(1e-9));
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* Arc length at which x reaches a value, ∫ √(1 + (x² − e)²) dx by the midpoint rule. */
static void along_the_arc(void **state) {
  (void)state;
  const double width = 0.01, e = width * width;
  enum { PARTS = 200000 };
  for (double step = 0.04; step < 0.5; step *= 2.0) {
    fixture f = open_cubic(e);
    km_driver_motion *drive;
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, true, &drive, NULL), KM_OK);
    assert_int_equal(km_driver_motion_move_to(drive, -1.0).stop, KM_STOP_NONE);
    km_driver_motion_free(drive);
    km_sweep_plan plan = {.arclength = step, .steps = (int)(2.2 / step), .direction = 0, .sign = 1.0};
    km_mobility_sweep sweep = swept(&f, plan);
    double size = f.mechanism->unit[0], arc = 0.0, expected[2];
    for (int t = 0, i = 0; t < 2; ++t) {
      const double to = t ? width : -width;
      for (; - 1.0 + (i + 1) * (1.0 + width) / PARTS <= to + 1e-12; ++i) {
        double x = -1.0 + (i + 0.5) * (1.0 + width) / PARTS, slope = x * x - e;
        arc += sqrt(1.0 + slope * slope) * (1.0 + width) / PARTS / size;
      }
      expected[t] = arc;
    }
    assert_int_equal(sweep.toggle_count, 2);
    for (int t = 0; t < 2; ++t)
      assert_near(sweep.toggles[t].s, expected[t], 2.0 / PARTS);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

static void of_random_linkages(void **state) {
  (void)state;
  /* Two between two rows, between two steps, and about a row. */
  static const uint64_t seeds[] = {9, 16, 6454};
  for (uint64_t seed = 1; seed <= 300; ++seed)
    assert_true(family_dead_points(seed));
  for (size_t i = 0; i < sizeof seeds / sizeof *seeds; ++i)
    assert_true(family_dead_points(seeds[i]));
}

/* The parabola through three places, however they lie. */
static void dips_are_shown(void **state) {
  (void)state;
  const double s[3] = {-1.0, 0.2, 1.0}, equal[3] = {0.0, 1.0, 2.0};
  for (double at = -0.9; at < 1.0; at += 0.1) {
    double n[3];
    for (int i = 0; i < 3; ++i)
      n[i] = -((s[i] - at) * (s[i] - at) - 1e-12);
    bool same_sign = n[0] * n[1] > 0.0 && n[1] * n[2] > 0.0;
    assert_int_equal(!isnan(km_event_lowest_point(s, n)), same_sign);
    if (same_sign)
      assert_near(km_event_lowest_point(s, n), at, 1e-12);
    for (int i = 0; i < 3; ++i)
      n[i] -= 10.0;
    assert_true(isnan(km_event_lowest_point(s, n)));
  }
  assert_true(isnan(km_event_lowest_point(equal, (double[3]){3, 2, 1})));
  assert_true(isnan(km_event_lowest_point(equal, (double[3]){1, 2, 1})));
  assert_true(isnan(km_event_lowest_point(equal, (double[3]){1, NAN, 1})));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(two_between_two_rows), cmocka_unit_test(near_and_at_zero),
                                     cmocka_unit_test(along_the_arc), cmocka_unit_test(of_random_linkages),
                                     cmocka_unit_test(dips_are_shown)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
