/* Planar mechanisms are recognised anywhere in space, and their inherent redundant constraints are distinguished. */
#include "support/support.h"

#include "kinematics/body_poses.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"
#include "kmech/sweep.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A slider-crank whose plane has the normal (0, -sin t, cos t): the frames of its ground are turned by t about x. */
static fixture tilted_slider_crank(double t) {
  static const char format[] =
      "{\"fixed\": {\"frames\": [{\"name\": \"g\", \"T\": [3, -2, 5], \"R\": [[1, 0, 0], [0, %.17g, %.17g], [0, %.17g, "
      "%.17g]]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": ["
      "{\"name\": \"crank\", \"frames\": [{\"name\": \"e\", \"T\": [1, 0, 0]}]},"
      "{\"name\": \"rod\", \"frames\": [{\"name\": \"e\", \"T\": [3, 0, 0]}]}, {\"name\": \"piston\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"g\"], \"crank\"], "
      "\"initial_displacement\": 0.7},"
      "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"crank\", \"e\"], \"rod\"], "
      "\"initial_displacement\": -0.9},"
      "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"rod\", \"e\"], \"piston\"], "
      "\"initial_displacement\": 0.2},"
      "{\"name\": \"D\", \"type\": \"Tx\", \"body_frame_pairs\": [[\"fixed\", \"g\"], \"piston\"], "
      "\"initial_displacement\": 3.6}]}]}";
  char json[2000];
  snprintf(json, sizeof json, format, cos(t), -sin(t), sin(t), cos(t));
  return fixture_read(json);
}

static km_redundancies redundancies_of(fixture *f) {
  km_redundancies found;
  km_error error;
  if (km_redundancies_find(f->mechanism, f->state, NULL, NULL, &found, &error))
    fail_msg("%s", error.text);
  return found;
}

static void test_tilted_planes(void **unused) {
  (void)unused;
  randomness r = {77};
  for (int i = 0; i < 40; ++i) {
    double t = uniform(&r, -M_PI, M_PI), normal[3], loop[3], expected[3] = {0.0, -sin(t), cos(t)};
    fixture f = tilted_slider_crank(t);
    go_somewhere(&f, &r);
    km_poses_compute(f.mechanism, f.state);
    assert_true(km_mechanism_plane(f.mechanism, f.state, normal));
    assert_true(km_loop_plane(f.mechanism, f.state, 0, loop));
    double along = 0.0, apart = 0.0;
    for (int k = 0; k < 3; ++k) {
      along += normal[k] * expected[k];
      apart = fmax(apart, fabs(normal[k] - loop[k]));
    }
    assert_near(fabs(along), 1.0, 1e-12);
    assert_near(apart, 0.0, 1e-12);
    assert_true(fmax(normal[0], fmax(normal[1], normal[2])) >= -fmin(normal[0], fmin(normal[1], normal[2])) - 1e-9);
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(mobility.kutzbach_planar, 1);
    km_redundancies found = redundancies_of(&f);
    assert_int_equal(found.count, 3);
    for (int k = 0; k < found.count; ++k)
      assert_true(found.items[k].out_of_plane);
    km_redundancies_free(&found);
    fixture_close(&f);
  }
}

/* The planar models are recognised; each planar loop has three inherent redundant constraints, whatever else is
 * redundant. */
static void test_models(void **unused) {
  (void)unused;
  static const char *const planar[] = {"fourbar", "slider_crank", "klann",  "brake",   "scissor_lift", "toggle_press",
                                       "jansen",  "peaucellier",  "bonnet", "andrews", "a02"};
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    double normal[3];
    bool expected = false;
    int loops = 0, across = 0;
    for (size_t i = 0; i < sizeof planar / sizeof *planar; ++i)
      expected = expected || strcmp(*name, planar[i]) == 0;
    km_poses_compute(f.mechanism, f.state);
    bool found_plane = km_mechanism_plane(f.mechanism, f.state, normal);
    if (found_plane != expected)
      fail_msg("%s: planar %d", *name, found_plane);
    for (int l = 0; l < f.mechanism->topology.loop_count; ++l)
      loops += km_loop_plane(f.mechanism, f.state, l, normal);
    km_redundancies found = redundancies_of(&f);
    for (int i = 0; i < found.count; ++i)
      across += found.items[i].out_of_plane;
    if (across != 3 * loops)
      fail_msg("%s: %d constraints across the planes of %d loops", *name, across, loops);
    km_redundancies_free(&found);
    fixture_close(&f);
  }
}

/* A joint has its dead point at the pole of its mechanical advantage, also if there is a passive freedom. */
static void test_idle_freedoms_hide_no_toggle(void **unused) {
  (void)unused;
  fixture f = fixture_open("rssr");
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_mobility_sweep numbers;
  km_advantage_sweep leverage;
  km_port input, output;
  km_error error;
  assert_true(km_port_default(f.model, false, &input) && km_port_default(f.model, true, &output));
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &numbers, &error), KM_OK);
  assert_int_equal(numbers.motion.freedom, 2);
  assert_int_equal(numbers.motion.passive, 1);
  km_state_restart(f.state);
  assert_int_equal(km_assemble(f.mechanism, f.state, NULL, &error), KM_OK);
  assert_int_equal(km_advantage_sweep_run(f.mechanism, f.state, &plan, &input, &output, false, &leverage, &error),
                   KM_OK);
  assert_int_equal(numbers.toggle_count, 2);
  assert_int_equal(leverage.toggle_count, 2);
  for (int i = 0; i < 2; ++i) {
    assert_int_equal(numbers.toggles[i].coordinate, output.coordinate);
    assert_near(numbers.toggles[i].s, leverage.toggles[i].s, 1e-6); /* accuracy of the path with several freedoms */
  }
  km_mobility_sweep_free(&numbers);
  km_advantage_sweep_free(&leverage);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_tilted_planes),
      cmocka_unit_test(test_models),
      cmocka_unit_test(test_idle_freedoms_hide_no_toggle),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
