/* Simulations with a known end: published benchmarks, closed forms, laws of conservation. */
#include "support/moving.h"

#include "kmech/dynamics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Andrews' squeezing mechanism at 0.03 s (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, VII.7; the
 * digits are those of the test set for IVP solvers), and its first accelerations. */
static void test_andrews(void **data) {
  (void)data;
  static const struct {
    const char *column;
    double value;
  } published[] = {{"q.beta", 15.81077119629904},   {"q.Theta", -15.75637105984298}, {"q.gamma", 0.04082224013073101},
                   {"q.phi", -0.5347301163226948},  {"q.delta", 0.5244099658805304}, {"q.Omega", 0.5347301163226948},
                   {"q.epsilon", 1.048080741042263}};
  fixture f = fixture_open("andrews");
  km_history h = history_of(&f, 0.03, 0.03, 1e-12, false);
  for (size_t i = 0; i < sizeof published / sizeof *published; ++i)
    assert_near(history_end(&h, published[i].column), published[i].value, 1e-8);
  assert_near(km_table_row(h.table, 0)[km_table_find(h.table, "a.beta")], 14222.4439199541, 1e-8 * 14222.0);
  assert_near(km_table_row(h.table, 0)[km_table_find(h.table, "a.Theta")], -10666.8329399656, 1e-8 * 10666.0);
  km_history_free(&h);
  fixture_close(&f);
}

/* θ̈ = c cos θ from (π/2, −1) by Runge-Kutta of order 4 with steps so short that they err by 1e-12. */
static double reduced_angle(double c, double time) {
  enum { STEPS = 400000 };
  double q = 0.5 * M_PI, v = -1.0, h = time / STEPS;
  for (int i = 0; i < STEPS; ++i) {
    double a1 = c * cos(q), a2 = c * cos(q + 0.5 * h * v);
    double a3 = c * cos(q + 0.5 * h * (v + 0.5 * h * a1)), a4 = c * cos(q + h * (v + 0.5 * h * a2));
    q += h * v + h * h / 6.0 * (a1 + a2 + a3);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return q;
}

/* IFToMM's A02 with two windows: 3 θ̈ = −3.5 g cos θ, through ten folds, where the rank drops. */
static void test_a02(void **data) {
  (void)data;
  fixture f = fixture_open("a02");
  km_history h = history_of(&f, 10.0, 0.1, 1e-10, false);
  assert_near(history_end(&h, "q.A0"), reduced_angle(-3.5 * 9.81 / 3.0, 10.0) - 0.5 * M_PI, 1e-6);
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  assert_at_most(h.worst_loop, 1e-12);
  km_history_free(&h);
  fixture_close(&f);
}

/* IFToMM's A01: 1 kg on a massless bar of 1 m, let go level. Half a swing takes 2 K(sin 45°)/√g, with K(k) =
 * π/(2 M(1, √(1 − k²))), M the arithmetic-geometric mean; then it stands level on the other side. */
static void test_a01(void **data) {
  (void)data;
  enum { HALVES = 8 };
  double a = 1.0, b = sqrt(0.5);
  for (int i = 0; i < 8; ++i) {
    double mean = 0.5 * (a + b);
    b = sqrt(a * b);
    a = mean;
  }
  double half = M_PI / (a * sqrt(9.81));
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"bar\", \"mass\": 1, \"center_of_mass\": [1, 0, 0]}], \"joints\": [{\"name\": "
      "\"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"bar\"], "
      "\"initial_displacement\": 3.141592653589793}]}]}");
  km_history h = history_of(&f, HALVES * half, half, 1e-11, false);
  int q = km_table_find(h.table, "q.A"), v = km_table_find(h.table, "v.A");
  for (size_t r = 1; r <= HALVES; ++r) {
    assert_near(km_table_row(h.table, r)[q], r % 2 ? 2.0 * M_PI : M_PI, 1e-9);
    assert_near(km_table_row(h.table, r)[v], 0.0, 1e-8);
  }
  assert_at_most(h.energy_error, 1e-9 * h.energy_scale + 1e-9);
  km_history_free(&h);
  fixture_close(&f);
}

static const char oscillator[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 2}], \"joints\": [{\"name\": \"X\", "
    "\"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_displacement\": 0.5, \"damping\": 0.8}], "
    "\"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": \"X\"}, "
    "\"coefficients\": [[0, -18]]}]}]}";

/* 2 ẍ + 0.8 ẋ + 18 x = 0: x = x₀ e^(−0.2 t) (cos ωt + 0.2/ω sin ωt), ω² = 9 − 0.04. */
static void test_oscillator(void **data) {
  (void)data;
  fixture f = fixture_read(oscillator);
  km_history h = history_of(&f, 4.0, 0.1, 1e-11, false);
  double w = sqrt(9.0 - 0.04);
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    const double *row = km_table_row(h.table, r);
    double t = row[0], exact = 0.5 * exp(-0.2 * t) * (cos(w * t) + 0.2 / w * sin(w * t));
    assert_near(row[km_table_find(h.table, "q.X")], exact, 1e-9);
  }
  km_history_free(&h);
  fixture_close(&f);
}

static const char floating[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1.5, \"center_of_mass\": [0.2, 0.1, "
    "-0.3], \"moment_of_inertia\": {\"Ixx\": 0.02, \"Iyy\": 0.03, \"Izz\": 0.045, \"Ixy\": 0.002}}], \"joints\": "
    "[{\"name\": \"F\", \"type\": \"float\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": [0.3, -0.2, "
    "0.1, 2, 3, -1]}]}]}";

/* A free body keeps its energy, and its centre of mass goes straight on. */
static void test_free_body(void **data) {
  (void)data;
  fixture f = fixture_read(floating);
  km_history h = history_of(&f, 3.0, 0.05, 1e-11, false);
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  fixture_close(&f);
  km_history_free(&h);
}

/* A prescribed crank: the work of its drive is all the energy that comes in, and the rate is the law's. */
static void test_prescribed(void **data) {
  (void)data;
  char *text = read_model_text("slider_crank"), *end = strstr(text, "\"name\": \"A\"");
  assert_non_null(end);
  char *with = (char *)malloc(strlen(text) + 200);
  size_t head = (size_t)(end - text);
  memcpy(with, text, head);
  strcpy(with + head, "\"prescribed\": {\"polynomial\": [5.3311, 2.5, 0.4]}, ");
  strcat(with, end);
  fixture f = fixture_read(with);
  km_history h = history_of(&f, 4.0, 0.05, 1e-10, false);
  assert_near(history_end(&h, "q.A"), 5.3311 + 2.5 * 4.0 + 0.4 * 16.0, 1e-12);
  assert_near(history_end(&h, "v.A"), 2.5 + 0.8 * 4.0, 1e-12);
  assert_near(history_end(&h, "a.A"), 0.8, 1e-12);
  assert_at_most(h.energy_error, 1e-7 * h.energy_scale);
  assert_true(km_table_find(h.table, "f.A") >= 0);
  km_history_free(&h);
  fixture_close(&f);
  free(with);
  km_free(text);
}

static const char rubbing[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 2}], \"joints\": [{\"name\": \"X\", "
    "\"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": 3, \"friction\": {\"torque\": 4, "
    "\"stiction_velocity\": 1e-6}}]}]}";

/* 4 N stop 2 kg at 3 m/s after 1.5 s and 2.25 m; the friction has taken 9 N m. */
static void test_constant_friction(void **data) {
  (void)data;
  fixture f = fixture_read(rubbing);
  km_history h = history_of(&f, 1.0, 0.5, 1e-10, false);
  assert_near(history_end(&h, "v.X"), 1.0, 1e-8);
  assert_near(history_end(&h, "q.X"), 2.0, 1e-8);
  assert_near(history_end(&h, "energy_dissipated"), 8.0, 1e-6);
  km_history_free(&h);
  fixture_close(&f);
}

static const char stopped[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1}], \"joints\": [{\"name\": \"X\", "
    "\"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": 1, \"limits\": [-10, 1], \"stop\": "
    "{\"stiffness\": 400}}]}]}";

/* A stop without damping throws the body back as fast as it came, after half a period of √(m/k). */
static void test_stop(void **data) {
  (void)data;
  fixture f = fixture_read(stopped);
  km_history h = history_of(&f, 2.0, 0.5, 1e-10, false);
  assert_near(history_end(&h, "v.X"), -1.0, 1e-6);
  assert_near(history_end(&h, "q.X"), 1.0 - (1.0 - M_PI / 20.0), 1e-6);
  km_history_free(&h);
  fixture_close(&f);
}

static const char has_rotation[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": "
    "1, \"Izz\": 1}}], \"joints\": [{\"name\": \"S\", \"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"b\"], "
    "\"initial_velocity\": [0.6, 0, 0.8], \"limits\": [0, 0.5], \"stop\": {\"stiffness\": 400}}]}]}";

/* The stop of a ball joint reverses the body after half a period of √(I/k), whatever the times of rows. */
static void test_ball_stop(void **data) {
  (void)data;
  for (int rows = 1; rows <= 8; rows *= 8) {
    fixture f = fixture_read(has_rotation);
    km_history h = history_of(&f, 1.0, 1.0 / rows, 1e-10, false);
    assert_near(history_end(&h, "v.S[0]"), -0.6, 1e-6);
    assert_near(history_end(&h, "v.S[2]"), -0.8, 1e-6);
    assert_near(history_end(&h, "q.S[2]"), 0.8 * (0.5 - (0.5 - M_PI / 20.0)), 1e-6);
    assert_at_most(h.energy_error, 1e-7 * h.energy_scale);
    km_history_free(&h);
    fixture_close(&f);
  }
}

static const char screwed[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1, \"moment_of_inertia\": {\"Ixx\": 2, \"Iyy\": "
    "3, \"Izz\": 2.5}}], \"joints\": [{\"name\": \"S\", \"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"b\"], "
    "\"initial_displacement\": [0.1, 0, 0.2], \"initial_velocity\": [1, 2, 3]}], \"force_modules\": [{\"name\": \"s\", \"type\": "
    "\"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": \"S[0]\"}, \"coefficients\": [[0, -4]]}]}]}";

/* A law on one coordinate of a ball has no potential: what it gives is work. */
static void test_law_on_ball(void **data) {
  (void)data;
  fixture f = fixture_read(screwed);
  km_history h = history_of(&f, 2.0, 0.5, 1e-10, false);
  assert_near(history_end(&h, "energy_potential"), 0.0, 0.0);
  assert_at_most(h.energy_error, 1e-7 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

static const char remote[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1}, {\"name\": \"c\", \"mass\": 0.5}], "
    "\"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": 1}, {\"name\": "
    "\"Y\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"c\"]}], \"force_modules\": [{\"name\": \"s\", \"type\": "
    "\"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": \"X\"}, \"output\": {\"type\": \"joint\", \"joint\": \"Y\"}, "
    "\"coefficients\": [[0, 3]]}]}]}";

/* A law that measures x = t and pushes y elsewhere with 3x stores nothing: what it gives, m ẏ²/2 with ẏ = 3t²/(2m),
 * is work. */
static void test_remote_spring(void **data) {
  (void)data;
  fixture f = fixture_read(remote);
  km_history h = history_of(&f, 2.0, 0.5, 1e-10, false);
  assert_near(history_end(&h, "v.Y"), 12.0, 1e-7);
  assert_near(history_end(&h, "energy_potential"), 0.0, 0.0);
  assert_near(history_end(&h, "motor_work"), 36.0, 1e-6);
  assert_at_most(h.energy_error, 1e-7 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

static const char damped_stop[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1}], \"joints\": [{\"name\": \"X\", "
    "\"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": 1, \"limits\": [-10, 1], \"stop\": "
    "{\"stiffness\": 10000, \"damping\": 20}}]}]}";

/* The push k x + b v ends where v̇ of x = v₀/ω' e^(−ζωt) sin ω't is 0, at tan ω't = −2ζωω'/(ω'² − ζ²ω²). The body
 * flies on freely at the speed v₁ that it has then: the stop has taken m (v₀² − v₁²)/2. */
static void test_damped_stop(void **data) {
  (void)data;
  const double w = 100.0, decay = 10.0, turning = sqrt(w * w - decay * decay);
  const double angle = M_PI - atan(2.0 * decay * turning / (turning * turning - decay * decay));
  const double left = exp(-decay * angle / turning) * (cos(angle) - decay / turning * sin(angle));
  const double taken = 0.5 * (1.0 - left * left);
  for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-2) {
    fixture f = fixture_read(damped_stop);
    km_history h = history_of(&f, 3.0, 0.5, tolerance, false);
    assert_near(history_end(&h, "v.X"), left, 10.0 * tolerance);
    assert_near(history_end(&h, "energy_dissipated"), taken, 10.0 * tolerance);
    assert_at_most(h.energy_error, 10.0 * tolerance * h.energy_scale);
    km_history_free(&h);
    fixture_close(&f);
  }
}

/* A wheel of 20 kg at rest on its tyre (height 0.3 m less 20 · 9.81 / 200 000), with a speed and a spin. */
static char *wheel_text(double speed, double spin) {
  char *text = (char *)malloc(2000);
  assert_non_null(text);
  snprintf(
      text, 2000,
      "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"x\"}, {\"name\": \"z\"}, {\"name\": \"wheel\", \"mass\": 20, \"moment_of_inertia\": {\"Ixx\": 0.5, \"Iyy\": 0.9, "
      "\"Izz\": 0.5}}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"x\"], "
      "\"initial_velocity\": %.17g}, {\"name\": \"Z\", \"type\": \"Tz\", \"body_frame_pairs\": [\"x\", \"z\"], "
      "\"initial_displacement\": %.17g}, {\"name\": \"Y\", \"type\": \"Ry\", \"body_frame_pairs\": [\"z\", \"wheel\"], "
      "\"initial_velocity\": %.17g}], \"force_modules\": [{\"name\": \"t\", \"type\": \"fiala_tire\", \"input\": {\"type\": "
      "\"frame\", \"body_frame_pair\": [\"fixed\", \"wheel\"]}, \"tire\": {\"unloaded_radius\": 0.3, \"vertical_stiffness\": "
      "200000, \"vertical_damping\": 2000, \"longitudinal_stiffness\": 50000, \"lateral_stiffness\": 40000, "
      "\"friction_peak\": 1, \"friction_sliding\": 0.9, \"relaxation_length_x\": 0.05, \"relaxation_length_y\": 0.15}}]}]}",
      speed, 0.3 - 20.0 * 9.81 / 200000.0, spin);
  return text;
}

/* A wheel that rolls goes on as it is; one that spins too fast drives itself on until it rolls. The road's force
 * changes speed and spin together: m v r + I ω stays, r the height of the axle. */
static void test_tire(void **data) {
  (void)data;
  const double r = 0.3 - 20.0 * 9.81 / 200000.0;
  const double spins[2] = {5.0 / r, 20.0};
  for (int i = 0; i < 2; ++i) {
    char *text = wheel_text(5.0, spins[i]);
    fixture f = fixture_read(text);
    km_history h = history_of(&f, 2.0, 0.5, 1e-9, false);
    double v = history_end(&h, "v.X"), w = history_end(&h, "v.Y");
    assert_near(history_end(&h, "q.Z"), r, 1e-6);
    assert_near(v, r * w, 1e-5);
    assert_near(20.0 * v * r + 0.9 * w, 20.0 * 5.0 * r + 0.9 * spins[i], 1e-5);
    assert_at_most(h.energy_error, 1e-6 * h.energy_scale);
    if (i == 0)
      assert_near(v, 5.0, 1e-6);
    km_history_free(&h);
    fixture_close(&f);
    free(text);
  }
}

/* A wheel that is carried forwards at 10 m/s and sideways at `aside`, 20 kg on it: the carriage bears what the tyre
 * pushes sideways, and how much it turns about the upright. */
static char *carried_text(double aside) {
  char *text = (char *)malloc(2500);
  assert_non_null(text);
  snprintf(
      text, 2500,
      "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"x\"}, {\"name\": \"y\"}, {\"name\": \"z\"}, {\"name\": \"wheel\", \"mass\": 20, \"moment_of_inertia\": {\"Ixx\": "
      "0.5, \"Iyy\": 0.9, \"Izz\": 0.5}}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": "
      "[\"fixed\", \"x\"], \"prescribed\": {\"polynomial\": [0, 10]}}, {\"name\": \"Y\", \"type\": \"Ty\", "
      "\"body_frame_pairs\": [\"x\", \"y\"], \"prescribed\": {\"polynomial\": [0, %.17g]}}, {\"name\": \"Z\", \"type\": "
      "\"Tz\", \"body_frame_pairs\": [\"y\", \"z\"], \"initial_displacement\": 0.299019}, {\"name\": \"S\", \"type\": "
      "\"Ry\", \"body_frame_pairs\": [\"z\", \"wheel\"], \"initial_velocity\": 33.4}], \"force_modules\": [{\"name\": \"t\", "
      "\"type\": \"fiala_tire\", \"input\": {\"type\": \"frame\", \"body_frame_pair\": [\"fixed\", \"wheel\"]}, \"tire\": "
      "{\"unloaded_radius\": 0.3, \"vertical_stiffness\": 200000, \"vertical_damping\": 2000, \"longitudinal_stiffness\": "
      "50000, \"lateral_stiffness\": 4000, \"friction_peak\": 1, \"friction_sliding\": 0.9, \"relaxation_length_x\": 0.05, "
      "\"relaxation_length_y\": 0.15}}]}]}",
      aside);
  return text;
}

/* Fiala: F_y = −μ F_z (1 − H³) sgn α with H = 1 − C_α |tan α|/(3 μ F_z), and −μ F_z beyond tan α = 3 μ F_z/C_α; μ by
 * the slip. The lateral slip is stationary after a few times 0.15 m. */
static void test_tire_sideways(void **data) {
  (void)data;
  static const double sides[] = {0.5, -0.5, 1.2, 3.0};
  for (size_t i = 0; i < sizeof sides / sizeof *sides; ++i) {
    char *text = carried_text(sides[i]);
    fixture f = fixture_read(text);
    km_history h = history_of(&f, 2.0, 0.5, 1e-8, false);
    double tangent = sides[i] / 10.0, mu = 1.0 - 0.1 * fabs(tangent), most = mu * 20.0 * 9.81;
    double H = fmax(0.0, 1.0 - 4000.0 * fabs(tangent) / (3.0 * most));
    assert_near(history_end(&h, "f.Y"), copysign(most * (1.0 - H * H * H), sides[i]), 1e-4 * most);
    km_history_free(&h);
    fixture_close(&f);
    free(text);
  }
}

/* A crossing is located to the integrator's accuracy, and one that stops ends the run there, with any rows. Returns
 * when. */
static double check_crossings(double every) {
  fixture f = fixture_read(oscillator);
  km_forces *forces;
  km_history h;
  km_error error = {0};
  const km_crossing crossings[] = {{.value = 0.0}, {.value = -0.4, .stops = true}, {.value = -0.3, .stops = true}};
  km_history_def def = km_history_default(f.model);
  def.until = 4.0;
  def.every = every;
  def.simulation.relative = def.simulation.absolute = 1e-11;
  def.simulation.crossings = crossings;
  def.simulation.crossing_count = 3;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f.mechanism, forces, f.state, &def, &h, &error), KM_PARTIAL);
  double w = sqrt(9.0 - 0.04);
  assert_int_equal(h.crossing_count, 2);
  assert_int_equal(h.crossings[1].crossing, 2);
  assert_near(h.crossings[0].time, (M_PI - atan(w / 0.2)) / w, 1e-8);
  assert_int_equal(h.crossings[0].sense, -1);
  assert_near(history_end(&h, "q.X"), -0.3, 1e-9);
  double end = km_table_row(h.table, km_table_rows(h.table) - 1)[0];
  assert_near(end, h.crossings[1].time, 1e-12);
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
  return end;
}

/* A falling body passes several values within one step; each stopping event ends the run there, and later events
 * occur when the run continues. */
static void test_stops_in_one_step(void **data) {
  (void)data;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, 0, -10]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"b\", "
      "\"mass\": 1}], \"joints\": [{\"name\": \"J\", \"type\": \"Tz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}");
  const km_crossing crossings[] = {
      {.value = -5.5}, {.value = -5.3, .stops = true}, {.value = -5.6, .stops = true}, {.value = -5.8}};
  km_forces *forces;
  km_dynamics *dynamics;
  km_simulation *run;
  km_simulation_def def = km_simulation_default();
  def.crossings = crossings;
  def.crossing_count = 4;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_dynamics_create(f.mechanism, forces, &dynamics, NULL), KM_OK);
  assert_int_equal(km_simulation_create(dynamics, f.state, &def, &run, NULL), KM_OK);
  static const km_status ends[] = {KM_PARTIAL, KM_PARTIAL, KM_OK};
  static const int met[] = {1, 3, 4}, order[] = {1, 0, 2, 3};
  static const double heights[] = {-5.3, -5.6, -11.25};
  for (int i = 0; i < 3; ++i) {
    assert_int_equal(km_simulation_advance(run, 1.5, NULL, NULL, NULL), ends[i]);
    assert_int_equal(km_simulation_crossing_count(run), met[i]);
    assert_near(km_state_coordinate(f.state, 0), heights[i], 1e-6);
  }
  for (int i = 0; i < 4; ++i) {
    km_crossing_met one = km_simulation_crossing(run, i);
    assert_int_equal(one.crossing, order[i]);
    assert_near(one.time, sqrt(-crossings[order[i]].value / 5.0), 1e-7);
  }
  km_simulation_free(run);
  km_dynamics_free(dynamics);
  km_forces_free(forces);
  fixture_close(&f);
}

static void test_crossings(void **data) {
  (void)data;
  const double end = check_crossings(0.5);
  for (double every = 0.3; every > 1e-3; every *= 0.4)
    assert_near(check_crossings(every), end, 1e-8);
}

/* 2 ẍ + 0.8 ẋ + 18 x = 0 has the eigenvalues −0.2 ± i ω, ω² = 9 − 0.04. */
static void test_linearised_oscillator(void **data) {
  (void)data;
  fixture f = fixture_read(oscillator);
  moving m = moving_of(f);
  km_linear l;
  assert_int_equal(km_equilibrium_find(m.dynamics, f.state, false, NULL, NULL, NULL), KM_OK);
  assert_near(km_state_coordinate(f.state, 0), 0.0, 1e-10);
  assert_int_equal(km_linearise(m.dynamics, f.state, &l, NULL), KM_OK);
  assert_int_equal(l.freedom, 1);
  for (int k = 0; k < 2; ++k) {
    assert_near(l.real[k], -0.2, 1e-8);
    assert_near(fabs(l.imaginary[k]), sqrt(9.0 - 0.04), 1e-8);
  }
  assert_near(l.B[1], 0.5, 1e-8);
  assert_int_equal(km_linear_stability(&l), KM_STABLE);
  /* The real and the imaginary part a quarter of a swing apart, from and to the pose. */
  km_table *motion = NULL;
  assert_int_equal(km_linear_motion(m.dynamics, f.state, &l, 1, 5, &motion, NULL), KM_OK);
  int q = km_table_find(motion, "q.X");
  double a = 0.25;
  for (int r = 0; r < 5; ++r) {
    assert_near(km_table_row(motion, (size_t)r)[0], 90.0 * r, 1e-12);
    assert_near(km_table_row(motion, (size_t)r)[q], a * (r % 2 ? (r - 2) * l.modes[3] : (1 - r % 4) * l.modes[2]),
                1e-9);
  }
  assert_near(km_state_coordinate(f.state, 0), 0.0, 1e-10);
  km_table_free(motion);
  km_linear_free(&l);
  moving_close(&m);
}

/* The stability of a configuration that isn't at rest is undefined; a free body, and one that falls equally
 * everywhere, have eigenvalues of 0, which differences of large accelerations don't hide. Rates are projected on the
 * loops. */
static void test_what_is_not_at_rest(void **data) {
  (void)data;
  fixture f = fixture_open("bennett");
  moving m = moving_of(f);
  km_linear l;
  assert_int_equal(km_linearise(m.dynamics, f.state, &l, NULL), KM_OK);
  assert_true(l.residual > 1.0);
  assert_int_equal(km_linear_stability(&l), KM_NOT_AT_REST);
  km_linear_free(&l);
  moving_close(&m);
  static const char thrown[] =
      "{\"model_parameters\": {\"gravity\": [0, 0, %g]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", "
      "\"mass\": 2, \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 1}}], \"joints\": [{\"name\": \"F\", \"type\": "
      "\"float\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_velocity\": [1, 2, 3, 0, 0, 1]}]}]}";
  for (double gravity = 0.0; gravity >= -1000.0; gravity = gravity < 0.0 ? gravity * 10.0 : -10.0) {
    char text[sizeof thrown + 32];
    snprintf(text, sizeof text, thrown, gravity);
    f = fixture_read(text);
    m = moving_of(f);
    assert_int_equal(km_linearise(m.dynamics, f.state, &l, NULL), KM_OK);
    assert_int_equal(km_linear_stability(&l), gravity < 0.0 ? KM_NOT_AT_REST : KM_INDIFFERENT);
    for (int k = 0; k < 2 * l.freedom; ++k)
      assert_int_equal(km_linear_kind_of(&l, k), KM_LINEAR_ZERO);
    km_linear_free(&l);
    moving_close(&m);
  }
}

/* The rate of one joint alone leads to the same equations as all rates that the loops make of it. */
static void test_rates_keep_the_loops(void **data) {
  (void)data;
  km_linear l[2];
  double projected[16];
  for (int i = 0; i < 2; ++i) {
    fixture f = fixture_open("fourbar");
    moving m = moving_of(f);
    const int count = f.mechanism->coordinate_count;
    for (int c = 0; c < count; ++c)
      f.state->rate[c] = i ? projected[c] : c == 0;
    assert_int_equal(km_linearise(m.dynamics, f.state, &l[i], NULL), KM_OK);
    memcpy(projected, f.state->rate, (size_t)count * sizeof *projected);
    moving_close(&m);
  }
  assert_int_equal(l[0].freedom, 1);
  assert_true(fabs(l[0].A[3]) > 1e-3); /* the motion is curved */
  for (int k = 0; k < 4; ++k)
    assert_near(l[0].A[k], l[1].A[k], 1e-8 * fabs(l[1].A[k]) + 1e-9);
  km_linear_free(&l[0]);
  km_linear_free(&l[1]);
}

/* Every row of a mode's motion closes the loops, and the independent coordinate grows or dies by its factor over
 * four time constants. */
static void assert_mode_keeps_loops(moving *m, fixture f, const km_linear *l, int k) {
  km_table *motion = NULL;
  assert_int_equal(km_linear_motion(m->dynamics, f.state, l, k, 9, &motion, NULL), KM_OK);
  size_t first = km_table_span(motion, "q.").first;
  int lead = l->independent[0];
  double rest = km_state_coordinate(f.state, lead), most = 0.0;
  for (size_t r = 0; r < 9; ++r)
    most = fmax(most, fabs(km_table_row(motion, r)[first + (size_t)lead] - rest));
  assert_true(most > 1e-3);
  for (size_t r = 0; r < 9; ++r) {
    const double *row = km_table_row(motion, r);
    double along = l->real[k] < 0.0 ? (double)r : 8.0 - (double)r;
    assert_near(fabs(row[first + (size_t)lead] - rest), most * exp(-0.5 * along), 1e-9);
    km_assembly evidence;
    km_state *state;
    assert_int_equal(km_state_create(f.mechanism, &state, NULL), KM_OK);
    assert_int_equal(km_state_set_coordinates(f.mechanism, state, row + first, NULL), KM_OK);
    assert_int_equal(km_assemble(f.mechanism, state, &evidence, NULL), KM_OK);
    assert_int_equal(evidence.iterations, 0);
    km_state_free(state);
  }
  km_table_free(motion);
}

/* A02 upright diverges with √(3.5 g / 3); at its stable rest it oscillates with the same frequency. */
static void test_linearised_a02(void **data) {
  (void)data;
  fixture f = fixture_open("a02");
  moving m = moving_of(f);
  km_linear l;
  double rate = sqrt(3.5 * 9.81 / 3.0);
  f.state->rate[0] = 0.0;
  assert_int_equal(km_equilibrium_find(m.dynamics, f.state, false, NULL, NULL, NULL), KM_OK);
  assert_int_equal(km_linearise(m.dynamics, f.state, &l, NULL), KM_OK);
  assert_int_equal(km_linear_stability(&l), KM_UNSTABLE);
  assert_near(fmax(l.real[0], l.real[1]), rate, 1e-7);
  for (int k = 0; k < 2; ++k)
    assert_mode_keeps_loops(&m, f, &l, k);
  km_linear_free(&l);
  moving_close(&m);
}

/* The drive's work over a turn is the change of the energies; the ground bears weights and shaking forces. */
static void test_inverse(void **data) {
  (void)data;
  fixture f = fixture_open("klann");
  km_forces *forces;
  km_history h;
  km_error error = {0};
  const km_constant_rate rate = {0, 2.0};
  const km_inverse_def def = {
      .rates = &rate, .rate_count = 1, .until = 1.0, .steps = 4000, .reactions = true, .axes = KM_AXES_FIXED};
  for (int b = 1; b < f.model->body_count; ++b)
    assert_int_equal(km_model_set_mass(f.model, b, 1.0 + b, NULL, NULL, NULL), KM_OK);
  f.model->gravity = (km_vec3){0, -9.81, 0};
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_inverse_run(f.mechanism, forces, f.state, &def, &h, &error), KM_OK);
  const km_table *t = h.table;
  const char *label = f.model->coordinates[0].label;
  char name[80];
  snprintf(name, sizeof name, "f.%s", label);
  int force = km_table_find(t, name), kinetic = km_table_find(t, "energy_kinetic"),
      potential = km_table_find(t, "energy_potential");
  size_t rows = km_table_rows(t);
  double work = 0.0, largest = 0.0, v = 2.0 * km_model_coordinate_factor(f.model, 0);
  for (size_t r = 0; r + 1 < rows; ++r) {
    const double *a = km_table_row(t, r), *b = km_table_row(t, r + 1);
    work += 0.5 * (b[0] - a[0]) * (a[force] + b[force]) * v; /* errs by dt²/12 of the force's second derivative */
    double change = b[kinetic] + b[potential] - km_table_row(t, 0)[kinetic];
    largest = fmax(largest, fabs(change));
    assert_near(work, change, 1e-5 * fmax(largest, 1.0));
  }
  double weight = 0.0;
  for (int b = 1; b < f.model->body_count; ++b)
    weight += 9.81 * (1.0 + b);
  for (size_t r = 0; r < rows; r += 500) {
    const double *row = km_table_row(t, r);
    double ground = 0.0;
    for (int j = 0; j < f.model->joint_count; ++j) {
      const km_model_joint *joint = &f.model->joints[j];
      snprintf(name, sizeof name, "r.%s.fy", joint->label);
      if (f.model->frames[joint->frame[0]].body == 0)
        ground += row[km_table_find(t, name)];
      else if (f.model->frames[joint->frame[1]].body == 0)
        ground -= row[km_table_find(t, name)];
    }
    assert_near(ground, weight - row[km_table_find(t, "shaking.fy")], 1e-8 * weight);
  }
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(test_andrews,
                 "Andrews' squeezing mechanism at 0.03 s, IFToMM A03 (Hairer and Wanner II, VII.7; IVP test set)",
                 "1e-8: steps of 1e-12 add up over the run"),
      claim_test(test_a01, "IFToMM A01: a pendulum turns where the elliptic integral says, 8 half swings",
                 "1e-9: steps of 1e-11 add up over the run"),
      claim_test(test_a02, "IFToMM A02: two windows through ten folds, against their reduced equation",
                 "1e-6: steps of 1e-10 add up, and folds pass rounding on"),
      claim_test(test_oscillator, "A damped oscillator in closed form", "1e-9: steps of 1e-11 add up over the run"),
      cmocka_unit_test(test_ball_stop),
      cmocka_unit_test(test_law_on_ball),
      cmocka_unit_test(test_remote_spring),
      claim_test(test_free_body, "A free body keeps its energy", "1e-8 of it: steps of 1e-11 add up over the run"),
      claim_test(test_prescribed, "A prescribed crank moves by its law, and its work is all the energy that comes in",
                 "1e-7 of the energy: steps of 1e-10 add up over the run"),
      cmocka_unit_test(test_crossings),
      cmocka_unit_test(test_stops_in_one_step),
      claim_test(test_constant_friction, "Constant friction stops a block where m v²/2 = F s",
                 "the speed below which friction sticks, 1e-6"),
      cmocka_unit_test(test_stop),
      cmocka_unit_test(test_damped_stop),
      claim_test(test_tire, "A wheel that spins rolls: m v r + I ω stays (thesis 7.4.1)",
                 "steps of 1e-9, over the tyre's stiffness"),
      claim_test(test_tire_sideways, "Fiala's side force, below and above the angle where it slides (thesis 7.4.1)",
                 "1e-4 of the force: what the relaxation has left after 2 s"),
      cmocka_unit_test(test_what_is_not_at_rest),
      cmocka_unit_test(test_rates_keep_the_loops),
      claim_test(test_linearised_oscillator, "Eigenvalues of a damped oscillator", "differences of forces err by 1e-8"),
      claim_test(test_linearised_a02, "IFToMM A02 upright grows with √(3.5 g/3)", "differences of forces err by 1e-8"),
      claim_test(test_inverse,
                 "The drive's work over a turn is the change of energy; the ground bears weight and shaking force",
                 "the trapezoidal rule over 4000 rows; 1e-8 of the weight")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
