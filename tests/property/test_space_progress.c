/* Progress of searches in configuration spaces: one course from 0 to 1, which never falls. */
#include "support/support.h"

#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/space.h"
#include "kmech/volume.h"

/* Reports of a search. */
typedef struct course {
  double last, largest_step;
  int calls, values; /* values: different ones */
} course;

static bool note(void *context, double done) {
  course *c = context;
  assert_true(done >= c->last && done <= 1.0);
  c->values += done > c->last;
  c->largest_step = fmax(c->largest_step, done - c->last);
  c->last = done;
  ++c->calls;
  return true;
}

static bool stop_at(void *context, double done) {
  const double *end = context;
  return done < *end;
}

static void a_stage_reports_its_share(void **state) {
  (void)state;
  course c = {0};
  km_progress_stage stage = {.progress = note, .context = &c};
  const double done[] = {0.0, 0.5, 1.0, 0.25, -3.0, 7.0};
  for (int k = 1; k <= 4; ++k) {
    km_progress_stage_next(&stage, 0.25 * k);
    for (size_t i = 0; i < sizeof done / sizeof *done; ++i) {
      assert_true(km_progress_stage_report(&stage, done[i]));
      double expected = 0.25 * (k - 1 + (i == 0 ? 0.0 : i == 1 ? 0.5 : 1.0));
      assert_true(fabs(c.last - expected) <= 1e-15);
    }
  }
  assert_int_equal(c.calls, 24);
  double end = 0.6;
  stage = (km_progress_stage){.progress = stop_at, .context = &end, .to = 0.5};
  assert_true(km_progress_stage_report(&stage, 1.0));
  km_progress_stage_next(&stage, 0.7);
  assert_false(km_progress_stage_report(&stage, 1.0));
}

/* Modes, then the map, as stages of one work. */
static course map_course(const char *name, int steps, bool within_limits) {
  fixture f = fixture_open(name);
  course c = {0};
  km_all_modes modes;
  km_space_map map;
  km_error error;
  int drivers[2] = {fixture_coordinate(&f, "A"), fixture_coordinate(&f, "E")}, frame;
  assert_int_equal(km_model_find_frame(f.model, (const char *const[]){"rod1", "P"}, 2, &frame, &error), KM_OK);
  const km_space_map_def def = {.axis = {{drivers[0], -3.1, 3.1, steps}, {drivers[1], -3.1, 3.1, steps}},
                                .has_point = true,
                                .frame = frame,
                                .point_name = "rod1/P",
                                .within_limits = within_limits};
  assert_int_equal(km_space_map_find(f.mechanism, f.state, &def, 1, note, &c, &modes, &map, &error), KM_OK);
  assert_false(map.is_stopped);
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  double end = 0.5; /* the modes end at 0.1 and stay complete */
  assert_int_equal(km_space_map_find(f.mechanism, f.state, &def, 1, stop_at, &end, &modes, &map, &error), KM_CANCELLED);
  assert_true(map.is_stopped && map.cells && modes.is_complete);
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  fixture_close(&f);
  return c;
}

/* Sheets, curves and aspects: no share of the work passes without a report. */
static void maps(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    course c = map_course(i == 0 ? "five_bar" : "wrist", 60, i == 0);
    assert_true(c.last > 0.9 && c.values > 30 && c.largest_step < 0.3);
  }
}

/* The search over the complex numbers reports its work, and circuits their modes. */
static void modes_and_circuits(void **state) {
  (void)state;
  static const char *const names[] = {"scissor_lift", "jansen"};
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
    fixture f = fixture_open(names[i]);
    course c = {0};
    km_all_modes modes;
    km_mode_circuits circuits;
    int driver = km_model_sweep_coordinate(f.model);
    const km_all_modes_def def = {.locked = &driver, .locked_count = 1, .seed = 1};
    assert_true(driver >= 0);
    assert_int_equal(km_modes_and_circuits_find(f.mechanism, f.state, &def, note, &c, &modes, &circuits, NULL), KM_OK);
    assert_true(c.values > 10 && c.last > 0.8);
    km_mode_circuits_free(&circuits);
    km_all_modes_free(&modes);
    fixture_close(&f);
  }
}

static void turning(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  course c = {0};
  km_turning found;
  char file[] = MODELS_DIR "/fourbar.json";
  const km_turning_def def = {
      .driver = fixture_coordinate(&f, "A"), .file = file, .path = "crank.end.x", .from = 0.05, .to = 0.6, .seed = 1};
  km_error error;
  if (km_turning_find(f.mechanism, f.state, &def, note, &c, &found, &error))
    fail_msg("%s", error.text);
  assert_true(c.last > 0.75 && c.values > 20);
  km_turning_free(&found);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_stage_reports_its_share), cmocka_unit_test(maps),
                                     cmocka_unit_test(modes_and_circuits), cmocka_unit_test(turning)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
