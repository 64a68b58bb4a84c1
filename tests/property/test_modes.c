/* Assembly modes of linkages for which the count is known. */
#include "support/support.h"

#include "kmech/mechanism.h"
#include "model/model.h"

static void expect(const char *name, const char *driver, double value, int count) {
  fixture f = fixture_open(name);
  int c;
  km_driver_motion *drive;
  km_modes modes;
  km_error error = {0};
  assert_int_equal(km_model_find_coordinate(f.model, driver, &c, &error), KM_OK);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, c, true, &drive, &error), KM_OK);
  assert_int_equal(km_driver_motion_move_to(drive, value).stop, KM_STOP_NONE);
  km_driver_motion_free(drive);
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

/* The file's pose of Peaucellier's linkage stands alone, but where two of its joints come together a pair of its bars
 * swings about them, and there are as many poses as are tried. */
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

static int count_modes(const char *json, const char *driver, int starts, km_modes *modes) {
  fixture f = fixture_read(json);
  km_error error = {0};
  int c = -1;
  if (driver)
    assert_int_equal(km_model_find_coordinate(f.model, driver, &c, &error), KM_OK);
  if (km_modes_find(f.mechanism, f.state, c, starts, 1, NULL, NULL, modes, &error))
    fail_msg("%s", error.text);
  int count = modes->count;
  const km_modes numbers = *modes;
  km_modes_free(modes);
  *modes = numbers;
  modes->coordinates = NULL;
  fixture_close(&f);
  return count;
}

/* A lid on a planar strut: the strut's length is never negative, and its limits hold. */
static const char *const lid =
    "{\"fixed\": {\"frames\": [{\"name\": \"f\", \"T\": [0.2, -0.5]}]},"
    " \"assemblies\": [{\"name\": \"l\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"lid\", \"frames\": [{\"name\": \"e\", \"T\": [1, 0.1]}]}],"
    " \"joints\": [{\"name\": \"H\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"lid\"], \"at\": [0, 0]}],"
    " \"struts\": [{\"name\": \"g\", \"from\": \"fixed/f\", \"to\": \"lid/e\", \"planar\": true}]}]}";

static void a_strut_has_one_length(void **state) {
  (void)state;
  km_modes modes;
  assert_int_equal(count_modes(lid, "H", 100, &modes), 1);
  /* With a fixed length, the lid is on either side of the line between the pins. */
  assert_int_equal(count_modes(lid, "g", 100, &modes), 2);
}

/* Two bars between fixed pins, a structure: the knee is on either side. A limit leaves one of them. */
static void structures_need_no_driver(void **state) {
  (void)state;
  km_modes modes;
  const char *bars =
      "{\"fixed\": {\"frames\": [{\"name\": \"pin\", \"T\": [1, 0]}]}, \"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\","
      " \"bodies\": [{\"name\": \"p\"}, {\"name\": \"q\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"p\"], \"at\": [0, 0]},"
      "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"p\", \"q\"], \"at\": [0.4, 0.6]},"
      "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"q\"], \"at\": [1, 0]}]}]}";
  assert_int_equal(count_modes(bars, NULL, 100, &modes), 2);
  char *limited = edited(bars, "\"A\"", "\"at\": [0, 0]", "\"at\": [0, 0], \"limits\": [-0.5, 0.5]");
  assert_int_equal(count_modes(limited, NULL, 100, &modes), 1);
  assert_int_equal(modes.outside, 1);
  assert_true(modes.closed > 50);
  assert_int_equal(modes.once, 0);
  km_free(limited);
}

/* The platform's legs are a ball, a slide and a universal joint each, as struts or as bodies: spins of a leg and the
 * second representation of its universal joint are no modes of their own. Upright, its six legs fixed, the file's
 * configuration and its mirror image close. */
static void legs_as_bodies_have_the_modes_of_struts(void **state) {
  (void)state;
  km_text legs[2] = {{0}, {0}};
  for (int bodies = 0; bodies < 2; ++bodies) {
    km_text_add(
        &legs[bodies],
        "{\"fixed\": {\"frames\": [{\"name\": \"f\", \"T\": [0.3, 0, 0]}]}, \"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"arm\", \"frames\": [{\"name\": \"e\", \"T\": [0.1, 0.2, 0.9]}]}");
    if (bodies)
      km_text_add(&legs[bodies], ", {\"name\": \"rod\"}, {\"name\": \"sleeve\"}");
    km_text_add(
        &legs[bodies],
        "], \"joints\": [{\"name\": \"H\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"arm\"], \"at\": [0, 0, 0], \"axis\": [0.2, 1, 0.1]}");
    if (bodies)
      km_text_add(
          &legs[bodies],
          ", {\"name\": \"g:from\", \"type\": \"spherical\", \"bodies\": [\"fixed\", \"rod\"], \"at\": [0.3, 0, 0]},"
          "{\"name\": \"g\", \"type\": \"prismatic\", \"bodies\": [\"rod\", \"sleeve\"], \"at\": [0.3, 0, 0], \"axis\": [-0.2, 0.2, 0.9]},"
          "{\"name\": \"g:to\", \"type\": \"universal\", \"bodies\": [\"sleeve\", \"arm\"], \"at\": [0.1, 0.2, 0.9], \"axis\": [0, 1, 0]}]}]}");
    else
      km_text_add(&legs[bodies], "], \"struts\": [{\"name\": \"g\", \"from\": \"fixed/f\", \"to\": \"arm/e\"}]}]}");
    km_modes modes;
    assert_int_equal(count_modes(legs[bodies].data, "g", 200, &modes), 2);
    km_text_free(&legs[bodies]);
  }
}

/* A spherical four-bar, all frames at its centre: open and crossed, although every link has all its joints at one
 * point. */
static void spherical_linkages_have_two(void **state) {
  (void)state;
  km_modes modes;
  const char *const bars =
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"p\"}, {\"name\": \"q\"}, {\"name\": \"r\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"p\"], \"at\": [0, 0, 0], \"axis\": [0, 0, 1]},"
      "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"p\", \"q\"], \"at\": [0, 0, 0], \"axis\": [0.5, 0.2, 1]},"
      "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"q\", \"r\"], \"at\": [0, 0, 0], \"axis\": [0.9, 0.8, 0.7]},"
      "{\"name\": \"D\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"r\"], \"at\": [0, 0, 0], \"axis\": [1, 0.1, 0.3]}]}]}";
  assert_int_equal(count_modes(bars, "A", 200, &modes), 2);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(known_counts),
                                     cmocka_unit_test(where_bars_swing_freely),
                                     cmocka_unit_test(a_strut_has_one_length),
                                     cmocka_unit_test(structures_need_no_driver),
                                     cmocka_unit_test(legs_as_bodies_have_the_modes_of_struts),
                                     cmocka_unit_test(spherical_linkages_have_two)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
