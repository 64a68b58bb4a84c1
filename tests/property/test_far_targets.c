/* Excessive requests: targets thousands of turns away, arc lengths below rounding, and endless cycles. Each ends
 * with a status. */
#include "support/refusals.h"
#include "support/support.h"

#include "kmech/continuation.h"

#include "model/model.h"

#include <math.h>
#include <string.h>

/* A crank that turns around: a hopeless target is given up after 10000 steps of at most 0.3 rad, not after 200000. */
static void far_targets_are_given_up_early(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_driver_motion *drive;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, f.model->sweep.coordinate, false, &drive, NULL),
                   KM_OK);
  km_motion_end reach = km_driver_motion_move_to(drive, 1e9);
  double turned = fabs(reach.position) * km_model_coordinate_factor(f.model, f.model->sweep.coordinate);
  assert_int_equal(reach.stop, KM_STOP_MAX_STEPS);
  assert_true(turned > 100.0 && turned <= 10000 * 0.3 + 10.0);
  km_driver_motion_free(drive);
  fixture_close(&f);
}

/* No row is tried after the one that is not reached. */
static void a_sweep_that_gives_out_ends(void **state) {
  (void)state;
  static const double ranges[][2] = {{1.0, 1e12}, {-1e12, 1e12}};
  for (size_t i = 0; i < COUNT(ranges); ++i) {
    fixture f = fixture_open("fourbar");
    km_sweep_plan plan = km_sweep_plan_default(f.model);
    km_mobility_sweep sweep;
    km_error error = {.text = ""};
    plan.from = ranges[i][0];
    plan.to = ranges[i][1];
    plan.steps = 5;
    assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_DIVERGED);
    assert_int_equal(km_table_rows(sweep.motion.table), i == 0);
    assert_true(strstr(error.text, "the sweep stopped at ") == error.text);
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

static void arc_lengths_have_bounds(void **state) {
  (void)state;
  static const double wrong[] = {1e-320, 1e-8, 1001.0, 1e300, HUGE_VAL};
  fixture f = fixture_open("fourbar");
  for (size_t i = 0; i < COUNT(wrong); ++i) {
    km_sweep_plan plan = km_sweep_plan_default(f.model);
    km_mobility_sweep sweep;
    km_error error = {.text = ""};
    plan.arclength = wrong[i];
    plan.steps = 2;
    assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_USAGE);
    assert_true(strstr(error.text, "; expected one greater than 1e-08 and at most 1000") != NULL);
    km_mobility_sweep_free(&sweep);
  }
  fixture_close(&f);
}

/* The smallest valid step has its length in every row; a shorter advance doesn't move, and a longer one is refused. */
static void short_steps_end(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_mobility_sweep sweep;
  plan.arclength = 2e-8;
  plan.steps = 5;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  assert_int_equal(km_table_rows(sweep.motion.table), 6);
  for (size_t r = 0; r < 6; ++r)
    assert_near(km_table_row(sweep.motion.table, r)[1], 2e-8 * (double)r, 1e-13);
  km_mobility_sweep_free(&sweep);
  km_arc_motion *follow;
  assert_int_equal(km_arc_motion_create(f.mechanism, f.state, -1, 1.0, false, &follow, NULL), KM_OK);
  assert_int_equal(km_arc_motion_advance(follow, 1e-320), KM_OK);
  assert_near(km_arc_motion_length(follow), 0.0, 1e-13);
  assert_int_equal(km_arc_motion_advance(follow, 1e9), KM_USAGE);
  assert_int_equal(km_arc_motion_advance(follow, (double)NAN), KM_USAGE);
  km_arc_motion_free(follow);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(far_targets_are_given_up_early),
      cmocka_unit_test(a_sweep_that_gives_out_ends),
      cmocka_unit_test(arc_lengths_have_bounds),
      cmocka_unit_test(short_steps_end),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
