/* Contacts against closed forms and conservation laws: penetration at rest, restitution, sliding, rolling, impact of
 * two discs, passages within a step, other frames and units. */
#include "support/moving.h"

#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "kmech/inspect.h"

#include <math.h>

/* Error of the run; error of its energy over the largest kinetic energy. */
static const double tolerance = 1e-10, balance = 1e-8;

/* Runs a model and checks its energy. */
static km_history run_fixture(fixture f, double until) {
  km_history h = history_of(&f, until, until / 10.0, tolerance, false);
  assert_at_most(h.energy_error, balance * h.energy_scale);
  fixture_close(&f);
  return h;
}

static km_history run(const char *text, double until) {
  return run_fixture(fixture_read(text), until);
}

/* A ball of 2 kg and radius 0.1 on a vertical slide above a floor; joint and contact follow, then gravity. */
#define BALL(joint, contact, gravity)                                                                                  \
  "{\"model_parameters\": {\"gravity\": [0, 0, " gravity "]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "         \
  "[{\"name\": \"b\", \"mass\": 2}], \"joints\": [{\"name\": \"Z\", \"type\": \"Tz\", \"body_frame_pairs\": "          \
  "[\"fixed\", \"b\"], " joint "}], \"force_modules\": [{\"name\": \"floor\", \"type\": \"contact\", \"input\": "      \
  "{\"body_frame_pair\": [\"fixed\", \"b\"]}, \"contact\": {\"shape\": \"point-plane\", \"radius\": 0.1, " contact     \
  "}}]}]}"

/* The ball rests where N = m g: δ = m g/k, and δ_0 (m g/(k δ_0))^(2/3) with Hertz's exponent. */
static void ball_at_rest(void **state) {
  (void)state;
  km_history h = run(BALL("\"initial_displacement\": 0.2", "\"stiffness\": 1e4, \"dissipation\": 20", "-10"), 0.8);
  assert_near(history_end(&h, "q.Z"), 0.1 - 20.0 / 1e4, 1e-9);
  km_history_free(&h);
  h = run(BALL("\"initial_displacement\": 0.2",
               "\"stiffness\": 1e4, \"dissipation\": 20, \"exponent\": 1.5, \"reference_depth\": 0.001", "-10"),
          0.8);
  assert_near(history_end(&h, "q.Z"), 0.1 - 0.001 * pow(2.0, 2.0 / 3.0), 1e-9);
  km_history_free(&h);
}

/* Speed u after an impact at speed v without gravity: φ(v) = φ(−u), φ(x) = x/c − ln(1 + c x)/c², the integral of
 * m x/(1 + c x) dx = −k δ^n dδ from 0 to 0. */
static double speed_after(double v, double c) {
  double low = 0.0, high = fmin(v, 1.0 / c), wanted = v / c - log1p(c * v) / (c * c);
  for (int i = 0; i < 200; ++i) {
    double u = 0.5 * (low + high), phi = -u / c - log1p(-c * u) / (c * c);
    *(phi < wanted ? &low : &high) = u;
  }
  return 0.5 * (low + high);
}

static void restitution(void **state) {
  (void)state;
  const char *const models[] = {
      BALL("\"initial_displacement\": 0.3, \"initial_velocity\": -1.5", "\"stiffness\": 2e4, \"dissipation\": 0.4",
           "0"),
      BALL("\"initial_displacement\": 0.3, \"initial_velocity\": -1.5",
           "\"stiffness\": 2e4, \"dissipation\": 0.4, \"exponent\": 1.5, \"reference_depth\": 0.01", "0")};
  for (size_t i = 0; i < 2; ++i) {
    km_history h = run(models[i], 0.5);
    assert_near(history_end(&h, "v.Z"), speed_after(1.5, 0.4), 2e-8);
    km_history_free(&h);
  }
  /* A ball without dissipation leaves with the speed of its arrival, after half a period in contact. */
  km_history h = run(BALL("\"initial_displacement\": 0.3, \"initial_velocity\": -1.5", "\"stiffness\": 2e4", "0"), 0.5);
  assert_near(history_end(&h, "v.Z"), 1.5, 2e-8);
  assert_near(history_end(&h, "q.Z"), 0.1 + 1.5 * (0.5 - 0.2 / 1.5 - M_PI / sqrt(1e4)), 1e-8);
  km_history_free(&h);
}

/* A block of 1 kg at rest in its penetration slides at 2 m/s with μ = 0.5: v = 2 − μ g t until the slip speed, and it
 * stops after 0.4 s near x = v²/(2 μ g); below the slip speed it creeps to a standstill. */
static void sliding_block(void **state) {
  (void)state;
  static const char text[] =
      "{\"model_parameters\": {\"gravity\": [0, 0, -10]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"c\"}, {\"name\": \"b\", \"mass\": 1}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": "
      "[\"fixed\", \"c\"], \"initial_velocity\": 2}, {\"name\": \"Z\", \"type\": \"Tz\", \"body_frame_pairs\": [\"c\", "
      "\"b\"], \"initial_displacement\": -1e-4}], \"force_modules\": [{\"name\": \"floor\", \"type\": \"contact\", "
      "\"input\": {\"body_frame_pair\": [\"fixed\", \"b\"]}, \"contact\": {\"shape\": \"point-plane\", \"stiffness\": 1e5, "
      "\"friction\": 0.5, \"slip_speed\": 1e-3}}]}]}";
  km_history h = run(text, 0.3);
  assert_near(history_end(&h, "v.X"), 2.0 - 5.0 * 0.3, 1e-9);
  assert_near(history_end(&h, "q.X"), 2.0 * 0.3 - 2.5 * 0.09, 1e-9);
  assert_near(history_end(&h, "energy_dissipated"), 2.0 - 0.125, 1e-9);
  km_history_free(&h);
  h = run(text, 0.6);
  assert_true(fabs(history_end(&h, "v.X")) < 1e-6);
  assert_near(history_end(&h, "q.X"), 0.4, 1e-3 * 0.4);
  km_history_free(&h);
}

/* A disc slides on a line without spin at 3 m/s. The moment of momentum about the contact stays: it rolls with
 * v = ω s, v = 3 m s²/(m s² + I), s = r − δ/2. */
static void rolling_disc(void **state) {
  (void)state;
  const double s = 0.2 - 0.5 * 1e-4;
  km_history h = run(
      "{\"model_parameters\": {\"gravity\": [0, -10, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"b\", \"mass\": 1, \"moment_of_inertia\": {\"Izz\": 0.02}}], \"joints\": [{\"name\": \"P\", \"type\": "
      "\"planar\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_displacement\": [0, 0.1999, 0], "
      "\"initial_velocity\": [3, 0, 0]}], \"force_modules\": [{\"name\": \"floor\", \"type\": \"contact\", \"input\": "
      "{\"body_frame_pair\": [\"fixed\", \"b\"]}, \"contact\": {\"shape\": \"circle-line\", \"radius\": 0.2, "
      "\"stiffness\": 1e5, \"friction\": 0.5, \"slip_speed\": 0.01}}]}]}",
      0.5);
  const double v = 3.0 * s * s / (s * s + 0.02);
  assert_near(history_end(&h, "v.P[0]"), v, 1e-7);
  assert_near(history_end(&h, "v.P[2]"), -v / s, 1e-6);
  km_history_free(&h);
}

/* Equal discs on a line exchange their velocities; one at a third of the mass rebounds. */
static void impact_of_discs(void **state) {
  (void)state;
  static const double masses[] = {1.0, 3.0};
  for (size_t i = 0; i < 2; ++i) {
    km_text text = {0};
    km_text_format(
        &text,
        "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"p\", \"mass\": 1}, {\"name\": \"q\", \"mass\": %g}], "
        "\"joints\": [{\"name\": \"P\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"p\"], \"initial_velocity\": "
        "2}, {\"name\": \"Q\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"q\"], \"initial_displacement\": "
        "0.6}], \"force_modules\": [{\"name\": \"touch\", \"type\": \"contact\", \"input\": {\"body_frame_pair\": [\"p\", "
        "\"q\"]}, \"contact\": {\"shape\": \"circle-circle\", \"radius\": 0.2, \"parent_radius\": 0.1, \"stiffness\": "
        "1e4}}]}]}",
        masses[i]);
    km_history h = run(text.data, 0.5);
    assert_near(history_end(&h, "v.P"), 2.0 * (1.0 - masses[i]) / (1.0 + masses[i]), 2e-8);
    assert_near(history_end(&h, "v.Q"), 4.0 / (1.0 + masses[i]), 2e-8);
    km_history_free(&h);
    km_text_free(&text);
  }
}

/* A pin with clearance c = R − r moves to and fro in its hole: a contact with linear stiffness lasts π √(m/k) and
 * reverses the rate. */
static void pin_in_a_hole(void **state) {
  (void)state;
  const double clearance = 0.2, mass = 2.0, stiffness = 1e4;
  km_history h = run(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"pin\", \"mass\": 2}], \"joints\": [{\"name\": \"X\", "
      "\"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"pin\"], \"initial_velocity\": 1}], \"force_modules\": "
      "[{\"name\": \"hole\", \"type\": \"contact\", \"input\": {\"body_frame_pair\": [\"fixed\", \"pin\"]}, "
      "\"contact\": {\"shape\": \"circle-in-circle\", \"radius\": 0.1, \"parent_radius\": 0.3, \"stiffness\": 1e4}}]}]}",
      1.0);
  const double touch = M_PI * sqrt(mass / stiffness), second = clearance + touch + 2.0 * clearance;
  const double t = 1.0 - second - touch; /* since the second wall */
  assert_true(t > 0.0);
  assert_near(history_end(&h, "v.X"), 1.0, 1e-7);
  assert_near(history_end(&h, "q.X"), t - clearance, 1e-7);
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  km_history_free(&h);
}

/* A disc that flies past another one touches it for 3 ms in a flight whose steps would be as long as the run: its
 * path is bent, and the momentum across it is that of the other disc. */
static void short_touch(void **state) {
  (void)state;
  km_history h = run(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"p\", \"mass\": 2}, {\"name\": \"q\", \"mass\": 1, "
      "\"moment_of_inertia\": {\"Izz\": 1}}], \"joints\": [{\"name\": \"P\", \"type\": \"Ty\", \"body_frame_pairs\": "
      "[\"fixed\", \"p\"]}, {\"name\": \"Q\", \"type\": \"planar\", \"body_frame_pairs\": [\"fixed\", \"q\"], "
      "\"initial_displacement\": [-50, 0.299, 0], \"initial_velocity\": [10, 0, 0]}], \"force_modules\": [{\"name\": "
      "\"touch\", \"type\": \"contact\", \"input\": {\"body_frame_pair\": [\"p\", \"q\"]}, \"contact\": {\"shape\": "
      "\"circle-circle\", \"radius\": 0.2, \"parent_radius\": 0.1, \"stiffness\": 1e5}}]}]}",
      10.0);
  assert_true(history_end(&h, "v.Q[1]") > 0.01);
  assert_near(2.0 * history_end(&h, "v.P") + history_end(&h, "v.Q[1]"), 0.0, 1e-9);
  km_history_free(&h);
}

/* A planar disc with slip and dissipation on a line in a frame that is turned and far away. */
static const char tilted[] =
    "{\"model_parameters\": {\"gravity\": [%s]}, \"fixed\": {\"frames\": [{\"name\": \"f\", \"T\": [%s], \"R\": %s}]}, "
    "\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1, \"moment_of_inertia\": {\"Izz\": "
    "0.02}}], \"joints\": [{\"name\": \"P\", \"type\": \"planar\", \"body_frame_pairs\": [\"fixed/f\", \"b\"], "
    "\"initial_displacement\": [0, 0.3, 0], \"initial_velocity\": [3, 0, 5]}], \"force_modules\": [{\"name\": \"floor\", "
    "\"type\": \"contact\", \"input\": {\"body_frame_pair\": [\"fixed/f\", \"b\"]}, \"contact\": {\"shape\": "
    "\"circle-line\", \"radius\": 0.2, \"stiffness\": 1e4, \"dissipation\": 0.5, \"friction\": 0.3, \"slip_speed\": "
    "0.05}}]}]}";

static void assert_same_end(const km_history *a, const km_history *b, double length, double angle) {
  static const char *const columns[] = {"q.P[0]", "q.P[1]", "q.P[2]"};
  for (size_t i = 0; i < 3; ++i)
    assert_near(history_end(a, columns[i]), history_end(b, columns[i]) * (i < 2 ? length : angle), 1e-7);
}

static void frames_and_units_dont_matter(void **state) {
  (void)state;
  km_text straight = {0}, turned = {0};
  km_text_format(&straight, tilted, "0, -10, 0", "0, 0, 0", "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]");
  km_text_format(&turned, tilted, "0, 0, -10", "30, -20, 5", "[[0, 0, 1], [1, 0, 0], [0, 1, 0]]");
  km_history a = run(straight.data, 1.0), b = run(turned.data, 1.0);
  assert_same_end(&a, &b, 1.0, 1.0);
  fixture f = fixture_read(straight.data);
  km_history c = run_fixture(fixture_in_units(&f, "degrees", "millimeters", "grams", "milliseconds"), 1000.0);
  assert_same_end(&a, &c, 1e-3, M_PI / 180.0);
  km_history_free(&a);
  km_history_free(&b);
  km_history_free(&c);
  km_text_free(&straight);
  km_text_free(&turned);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ball_at_rest),
      cmocka_unit_test(restitution),
      cmocka_unit_test(sliding_block),
      cmocka_unit_test(rolling_disc),
      cmocka_unit_test(impact_of_discs),
      cmocka_unit_test(pin_in_a_hole),
      cmocka_unit_test(short_touch),
      cmocka_unit_test(frames_and_units_dont_matter),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
