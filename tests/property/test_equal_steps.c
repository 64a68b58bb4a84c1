/* Steps of a driver that are as long as each other are predicted by nine poses. The poses are those of other steps,
 * and mostly need no correction. */
#include "support/support.h"

#include "continuation/driver_motion.h"
#include "kinematics/loop_equations.h"

#include <math.h>

typedef struct way {
  const char *model, *driver;
  double length;  /* displacement of the driver, in radians or the model's length */
  int steps;      /* all of the same length */
  double at_once; /* least part of them that needs no correction */
} way;

/* A model with a drive of one of its joints. */
typedef struct machine {
  fixture f;
  km_driver_motion *drive;
  double from;
} machine;

static machine open_machine(const way *of) {
  machine m = {.f = fixture_open(of->model)};
  int c;
  km_error error;
  if (km_assemble(m.f.mechanism, m.f.state, NULL, &error) ||
      km_model_find_coordinate(m.f.model, of->driver, &c, &error) ||
      km_driver_motion_create(m.f.mechanism, m.f.state, c, true, &m.drive, &error))
    fail_msg("%s", error.text);
  m.from = km_state_coordinate(m.f.state, c);
  return m;
}

static void close_machine(machine *m) {
  km_driver_motion_free(m->drive);
  fixture_close(&m->f);
}

/* True if the last step ended at its prediction. The driver has its exact value. */
static bool at_once(const km_driver_motion *d) {
  const km_step_history *course = &d->c.history;
  for (int k = 0; k < km_driver_motion_substructure(d)->columns; ++k)
    if (k != d->c.column && !(fabs(course->last_move[k] - d->c.move[k]) <= 1e-14))
      return false;
  return true;
}

static double residual_of(const machine *m) {
  return km_loops_residual(m->f.mechanism, m->f.state, km_driver_motion_substructure(m->drive));
}

/* Closing ends with errors of 1e-12 rms over the rows and steps below 1e-12, or with a step of Newton below 1e-9,
 * whose rest is its square: the poses of two ways differ by twice that, times what many loops add up to. */
static void poses_are_those_of_uneven_steps(void **state) {
  (void)state;
  static const way ways[] = {{"slider_crank", "A", 4.0 * M_PI, 400, 0.9}, {"slider_crank", "A", -4.0 * M_PI, 800, 0.9},
                             {"slider_crank", "A", 4.0 * M_PI, 30, 0.0},  {"klann", "A", 4.0 * M_PI, 800, 0.3},
                             {"excavator", "M", 0.5, 200, 0.7},           {"bennett", "A", 2.0 * M_PI, 300, 0.5}};
  for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
    machine even = open_machine(&ways[i]), uneven = open_machine(&ways[i]);
    const km_mechanism *m = even.f.mechanism;
    int found = 0;
    for (int row = 1; row <= ways[i].steps; ++row) {
      double step = ways[i].length / ways[i].steps, target = even.from + row * step;
      assert_int_equal(km_driver_motion_move_to(even.drive, target).stop, KM_STOP_NONE);
      found += at_once(even.drive);
      assert_int_equal(km_driver_motion_move_to(uneven.drive, target - (row % 2 ? 0.37 : 0.61) * step).stop,
                       KM_STOP_NONE);
      assert_int_equal(km_driver_motion_move_to(uneven.drive, target).stop, KM_STOP_NONE);
      assert_at_most(residual_of(&even), 1e-12 * sqrt(6.0) * 10.0);
      for (int c = 0; c < m->coordinate_count; ++c)
        assert_near(even.f.state->q[c] / m->unit[c], uneven.f.state->q[c] / m->unit[c], 2e-11);
    }
    if (found < ways[i].at_once * ways[i].steps)
      fail_msg("%s: %d of %d steps end where they were predicted", ways[i].model, found, ways[i].steps);
    close_machine(&even);
    close_machine(&uneven);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {claim_test(
      poses_are_those_of_uneven_steps, "Poses of equal steps, predicted by nine poses, are those of uneven ones",
      "the thresholds of closing the loops")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
