/* Assembly modes of linkages for which the count is known. */
#include "support/support.h"

#include "kmech/modes.h"
#include "model/model.h"

static void expect(const char *name, const char *driver, double value, int count) {
  fixture f = fixture_open(name);
  int c;
  km_drive *drive;
  km_modes modes;
  km_error error = {0};
  assert_int_equal(km_model_find_coordinate(f.model, driver, &c, &error), KM_OK);
  assert_int_equal(km_drive_create(f.mechanism, f.state, c, true, &drive, &error), KM_OK);
  assert_int_equal(km_drive_to(drive, value).stop, KM_STOP_NONE);
  km_drive_free(drive);
  if (km_modes_find(f.mechanism, f.state, c, 300, 1, NULL, NULL, &modes, &error))
    fail_msg("%s", error.text);
  assert_int_equal(modes.count, count);
  assert_true(modes.isolated);
  for (int i = 0; i < f.model->coordinate_count; ++i) /* the first is the state's own */
    assert_near(modes.coordinates[i], km_state_coordinate(f.state, i), 1e-9);
  for (int i = 0; i < modes.count; ++i)
    assert_near(modes.coordinates[i * f.model->coordinate_count + c], value, 1e-12);
  km_modes_free(&modes);
  fixture_close(&f);
}

static void known_counts(void **state) {
  (void)state;
  expect("fourbar", "A", 1.0, 2);      /* open and crossed */
  expect("slider_crank", "A", 1.0, 2); /* the piston on either side */
  expect("klann", "A", 1.0, 4);        /* two dyads */
}

/* The file's pose of Peaucellier's linkage stands alone, but where two of its joints come together a pair of its bars swings about
 * them, and there are as many poses as are tried. */
static void where_bars_swing_freely(void **state) {
  (void)state;
  fixture f = fixture_open("peaucellier");
  km_modes modes;
  const km_sweep_plan plan = km_sweep_plan_default(f.model);
  assert_int_equal(km_modes_find(f.mechanism, f.state, plan.coordinate, 0, 1, NULL, NULL, &modes, NULL), KM_OK);
  assert_int_equal(modes.count, 1);
  assert_true(modes.isolated);
  km_modes_free(&modes);
  assert_int_equal(km_modes_find(f.mechanism, f.state, plan.coordinate, 200, 1, NULL, NULL, &modes, NULL), KM_OK);
  assert_true(modes.count > 50);
  assert_false(modes.isolated);
  km_modes_free(&modes);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(known_counts), cmocka_unit_test(where_bars_swing_freely)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
