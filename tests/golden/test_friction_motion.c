/* Friction by normal forces, in motions with closed forms or against independent sums. */
#include "support/moving.h"

#include "kmech/dynamics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A block of 2 kg on a slope of 30°: its weight's part along the slope less μ times the part across it, or nothing. */
static void test_incline(void **data) {
  (void)data;
  for (int sticks = 0; sticks < 2; ++sticks) {
    double mu = sticks ? 0.7 : 0.3, g = 9.81, time = 2.0;
    char text[1000];
    snprintf(
        text, sizeof text,
        "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"fixed\": {\"frames\": [{\"name\": \"slope\", \"R\": "
        "[[0.86602540378443865, 0, 0.5], [0, 1, 0], [-0.5, 0, 0.86602540378443865]]}]}, \"assemblies\": [{\"name\": "
        "\"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 2}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", "
        "\"body_frame_pairs\": [[\"fixed\", \"slope\"], [\"b\"]], \"friction\": {\"coefficient\": %g, "
        "\"stiction_velocity\": 1e-6}}]}]}",
        mu);
    fixture f = fixture_read(text);
    km_history h = history_of(&f, time, 0.5, 1e-9, false);
    double a = sticks ? 0.0 : g * (0.5 - mu * sqrt(0.75)), creep = 2e-6; /* the stiction speed times the time */
    assert_near(history_end(&h, "q.X"), 0.5 * a * time * time, creep);
    assert_near(history_end(&h, "v.X"), a * time, 1e-6);
    if (!sticks)
      assert_near(history_end(&h, "energy_dissipated"), mu * 2.0 * g * sqrt(0.75) * 0.5 * a * time * time, 1e-4);
    km_history_free(&h);
    fixture_close(&f);
  }
}

/* The angular acceleration of a point mass m at l with friction μ on a journal of radius r: m l² θ̈ = −m g l sin θ −
 * μ r N sgn ω, N the length of (m l θ̈ + m g sin θ, m l ω² + m g cos θ). */
static double swing(double q, double v) {
  const double m = 1.5, l = 0.8, g = 9.81, couple = 0.4 * 0.05;
  double a = -g / l * sin(q);
  for (int i = 0; i < 60; ++i) {
    double across = m * (l * a + g * sin(q)), along = m * (l * v * v + g * cos(q));
    a = -g / l * sin(q) - couple * sqrt(across * across + along * along) * (v > 0.0 ? 1.0 : -1.0) / (m * l * l);
  }
  return a;
}

/* A pendulum on a journal turns against its friction; an own Runge-Kutta of the equation above, while it goes one
 * way. */
static void test_journal(void **data) {
  (void)data;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", "
      "\"mass\": 1.5, \"center_of_mass\": [0, -0.8, 0]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", "
      "\"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": 9, \"friction\": {\"coefficient\": 0.4, \"radius\": "
      "0.05, \"stiction_velocity\": 1e-6}}]}]}");
  km_history h = history_of(&f, 1.0, 0.25, 1e-10, false);
  enum { STEPS = 20000 };
  double q = 0.0, v = 9.0, dt = 1.0 / STEPS;
  for (int i = 0; i < STEPS; ++i) {
    double a1 = swing(q, v), a2 = swing(q + 0.5 * dt * v, v + 0.5 * dt * a1);
    double a3 = swing(q + 0.5 * dt * v + 0.25 * dt * dt * a1, v + 0.5 * dt * a2);
    double a4 = swing(q + dt * v + 0.5 * dt * dt * a2, v + dt * a3);
    q += dt * v + dt * dt / 6.0 * (a1 + a2 + a3);
    v += dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  assert_true(v > 0.1); /* its rate has kept its sign */
  assert_near(history_end(&h, "q.A"), q, 1e-7);
  assert_near(history_end(&h, "v.A"), v, 1e-7);
  km_history_free(&h);
  fixture_close(&f);
}

#define FRICTION "\"friction\": {\"coefficient\": 0.2, \"radius\": 0.05, \"stiction_velocity\": 0.01}, "
static const char joint_b[] = "\"name\": \"B\"", joint_c[] = "\"name\": \"C\"";

static char *with_friction(void) {
  char *text = read_model_text("slider_crank"), *one = edited(text, NULL, joint_b, FRICTION "\"name\": \"B\"");
  char *both = edited(one, joint_b, joint_c, FRICTION "\"name\": \"C\"");
  km_free(one);
  km_free(text);
  return both;
}

/* Energy of a closed loop: friction and damper dissipate between two rows μ r N |v| + b v² at the reported
 * reactions, by Simpson's rule over three rows; nothing else is lost. */
static void test_loop(void **data) {
  (void)data;
  char *text = with_friction();
  fixture f = fixture_read(text);
  const double dt = 0.002;
  km_history h = history_of(&f, 1.0, dt, 1e-9, true);
  assert_at_most(h.energy_error, 1e-7 * h.energy_scale);
  size_t rows = km_table_rows(h.table);
  double power[3] = {0}, sum = 0.0;
  for (size_t r = 0; r < rows; ++r) {
    double slide = history_entry(&h, r, "v.B"), turn = history_entry(&h, r, "v.C");
    /* B slides along its own z axis, C turns about its own x axis. */
    double press = hypot(history_entry(&h, r, "r.B.fx"), history_entry(&h, r, "r.B.fy"));
    double journal = hypot(history_entry(&h, r, "r.C.fy"), history_entry(&h, r, "r.C.fz"));
    double x = fmin(fabs(slide) / 0.01, 1.0), y = fmin(0.05 * fabs(turn) / 0.01, 1.0);
    power[r % 3] =
        0.2 * press * x * (2.0 - x) * fabs(slide) + 0.2 * 0.05 * journal * y * (2.0 - y) * fabs(turn) + slide * slide;
    if (r % 2 == 0 && r > 0)
      sum += dt / 3.0 * (power[r % 3] + 4.0 * power[(r + 2) % 3] + power[(r + 1) % 3]);
  }
  assert_near(sum, history_end(&h, "energy_dissipated"), 2e-4 * sum);
  assert_true(sum > 0.1);
  km_history_free(&h);
  fixture_close(&f);
  free(text);
}

/* The drive of a motion bears the friction: a wheel of weight m g on a journal needs μ r m g. */
static void test_drive(void **data) {
  (void)data;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"b\", \"mass\": 4}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", "
      "\"body_frame_pairs\": [\"fixed\", \"b\"], \"friction\": {\"coefficient\": 0.25, \"radius\": 0.1}}]}]}");
  km_forces *forces;
  km_history h;
  const km_constant_rate rate = {0, 3.0};
  const km_inverse_def def = {.rates = &rate, .rate_count = 1, .until = 1.0, .steps = 4};
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_inverse_run(f.mechanism, forces, f.state, &def, &h, NULL), KM_OK);
  assert_near(history_end(&h, "f.A"), 0.25 * 0.1 * 4.0 * 9.81, 1e-12);
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

/* A nut of mass m on a vertical thread, turned at a constant rate up and down: m g r tan(φ ± λ). */
static void test_thread(void **data) {
  (void)data;
  static const double slopes[] = {0.05, 0.3, 1.0, 2.0};
  for (int i = 0; i < 8; ++i) {
    double r = 0.02, slope = slopes[i / 2], mu = 0.2, sense = i % 2 ? -1.0 : 1.0, phi = atan(mu), lambda = atan(slope);
    char text[600];
    snprintf(
        text, sizeof text,
        "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
        "[{\"name\": \"b\", \"mass\": 4, \"moment_of_inertia\": {\"Izz\": 1}}], \"joints\": [{\"name\": \"S\", \"type\": "
        "\"screw\", \"pitch\": %.17g, \"body_frame_pairs\": [\"fixed\", \"b\"], \"friction\": {\"coefficient\": %g, "
        "\"radius\": %g}}]}]}",
        2.0 * M_PI * r * slope, mu, r);
    fixture f = fixture_read(text);
    km_forces *forces;
    km_history h;
    const km_constant_rate rate = {0, 5.0 * sense};
    const km_inverse_def def = {.rates = &rate, .rate_count = 1, .until = 1.0, .steps = 4};
    assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
    assert_int_equal(km_inverse_run(f.mechanism, forces, f.state, &def, &h, NULL), KM_OK);
    assert_near(history_end(&h, "f.S"), 4.0 * 9.81 * r * tan(lambda + sense * phi), 1e-11);
    km_history_free(&h);
    km_forces_free(forces);
    fixture_close(&f);
  }
}

/* A turntable under its weight on a collar: μ m g r takes it from 1 rad/s to rest in J / (μ m g r) seconds. */
static void test_collar(void **data) {
  (void)data;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"b\", \"mass\": 100, \"moment_of_inertia\": {\"Izz\": 1}}], \"joints\": [{\"name\": \"A\", \"type\": "
      "\"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": 1, \"friction\": {\"coefficient\": 0.1, "
      "\"radius\": 0.05}}]}]}");
  km_forces *forces;
  km_history h;
  km_history_def def = km_history_default(f.model);
  def.until = 0.1;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f.mechanism, forces, f.state, &def, &h, NULL), KM_OK);
  assert_near(history_end(&h, "v.A"), 1.0 - 0.1 * 0.1 * 100.0 * 9.81 * 0.05, 1e-6);
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(test_incline, "A block on a slope slides with g (sin α − μ cos α), or sticks",
                 "the speed below which friction sticks, times the time"),
      claim_test(test_journal, "A pendulum on a journal with friction by its load, against its own equation",
                 "1e-7: steps of 1e-10 add up over the run"),
      cmocka_unit_test(test_loop),
      cmocka_unit_test(test_drive),
      cmocka_unit_test(test_thread),
      cmocka_unit_test(test_collar)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
