/* Stiff motions: against closed forms, against the other method, and how much work they take. */
#include "support/moving.h"

#include "kmech/dynamics.h"

#include <stdio.h>

static km_history run_by(fixture *f, double until, double tolerance, km_integrator integrator, km_stabilisation how) {
  km_forces *forces;
  km_history out;
  km_error error = {0};
  km_history_def def = km_history_default(f->model);
  def.until = until;
  def.every = until / 10.0;
  def.simulation.relative = def.simulation.absolute = tolerance;
  def.simulation.integrator = integrator;
  def.simulation.stabilisation = how;
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f->mechanism, forces, f->state, &def, &out, &error), KM_OK);
  km_forces_free(forces);
  return out;
}

static km_history run(fixture *f, double until, double tolerance, km_integrator integrator) {
  return run_by(f, until, tolerance, integrator, KM_STABILISE_PROJECT);
}

static const char damped[] =
    "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1}], \"joints\": [{\"name\": \"X\", "
    "\"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_displacement\": 1, \"damping\": 100000}], "
    "\"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": \"X\"}, "
    "\"coefficients\": [[0, -20000]]}]}]}";

/* ẍ + 1e5 ẋ + 2e4 x = 0 from rest: x = (λ₁ e^(λ₂ t) − λ₂ e^(λ₁ t))/(λ₁ − λ₂), λ₁ ≈ −1e5, λ₂ ≈ −0.2. Adams' method,
 * whose steps can't be longer than about 2e-5, would need a million evaluations. */
static void test_damped(void **data) {
  (void)data;
  fixture f = fixture_read(damped);
  km_history h = run(&f, 10.0, 1e-9, KM_INTEGRATOR_ADAMS);
  double root = sqrt(1e10 / 4.0 - 2e4), fast = -5e4 - root, slow = 2e4 / fast;
  int q = km_table_find(h.table, "q.X");
  for (size_t r = 1; r < km_table_rows(h.table); ++r) {
    const double *row = km_table_row(h.table, r);
    assert_near(row[q], (fast * exp(slow * row[0]) - slow * exp(fast * row[0])) / (fast - slow), 1e-8);
  }
  assert_true(h.figures.stiff);
  assert_true(h.figures.evaluations < 5000);
  km_history_free(&h);
  fixture_close(&f);
}

/* IFToMM's A05, the stiff flyball governor: a shaft, two rods of 1 m hinged 5 cm beside its axis with 5 kg at their
 * ends, a slider of 3 kg, and between its sides and the rods' middles springs of 8e5 N/m with dampers of 4e4 N s/m;
 * bodies are boxes of 3000 kg/m³ (L. Tagliapietra and others, MBS benchmarks in OpenSim,
 * help/benchmarks/A05_FlyballGovernor; the hinges' places are those of EXUDYN's test model). */
static const double offset = 0.05, spring = 8e5, damper = 4e4, rest = 0.5, slider = 3.0, spin = 2.0 * M_PI;
static const double rod = 5.3, middle = (0.3 * 0.5 + 5.0) / 5.3; /* mass, and where its centre is */

static double rod_inertia(void) {
  return 0.3 * (1.0 + 1e-4) / 12.0 + 0.3 * (middle - 0.5) * (middle - 0.5) + 5.0 * (1.0 - middle) * (1.0 - middle);
}

static fixture governor(void) {
  char text[4096];
  double I = rod_inertia();
  snprintf(
      text, sizeof text,
      "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": ["
      "{\"name\": \"shaft\", \"mass\": 0.3, \"moment_of_inertia\": {\"Ixx\": 0.025, \"Iyy\": 0.025, \"Izz\": 5e-6}, "
      "\"frames\": [{\"name\": \"A\", \"T\": [0.05, 0, 1]}, {\"name\": \"B\", \"T\": [-0.05, 0, 1], \"R\": "
      "[[-1, 0, 0], [0, -1, 0], [0, 0, 1]]}]},"
      "{\"name\": \"slider\", \"mass\": 3, \"moment_of_inertia\": {\"Ixx\": 0.005, \"Iyy\": 0.005, \"Izz\": 0.005}, "
      "\"frames\": [{\"name\": \"E\", \"T\": [0.05, 0, 0]}, {\"name\": \"F\", \"T\": [-0.05, 0, 0]}]},"
      "{\"name\": \"ac\", \"mass\": %.17g, \"center_of_mass\": [%.17g, 0, 0], \"moment_of_inertia\": {\"Ixx\": 5e-6, "
      "\"Iyy\": %.17g, \"Izz\": %.17g}, \"frames\": [{\"name\": \"middle\", \"T\": [0.5, 0, 0]}]},"
      "{\"name\": \"bd\", \"mass\": %.17g, \"center_of_mass\": [%.17g, 0, 0], \"moment_of_inertia\": {\"Ixx\": 5e-6, "
      "\"Iyy\": %.17g, \"Izz\": %.17g}, \"frames\": [{\"name\": \"middle\", \"T\": [0.5, 0, 0]}]}], \"joints\": ["
      "{\"name\": \"P\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"shaft\"], \"initial_velocity\": %.17g},"
      "{\"name\": \"S\", \"type\": \"Tz\", \"body_frame_pairs\": [\"shaft\", \"slider\"], \"initial_displacement\": 0.5},"
      "{\"name\": \"A\", \"type\": \"Ry\", \"body_frame_pairs\": [[\"shaft\", \"A\"], [\"ac\"]], \"initial_displacement\": "
      "%.17g},"
      "{\"name\": \"B\", \"type\": \"Ry\", \"body_frame_pairs\": [[\"shaft\", \"B\"], [\"bd\"]], \"initial_displacement\": "
      "%.17g}], \"force_modules\": ["
      "{\"name\": \"s1\", \"type\": \"stiffness\", \"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"slider\", "
      "\"E\"], [\"ac\", \"middle\"]]}, \"coefficients\": [[4e5, -8e5]]},"
      "{\"name\": \"d1\", \"type\": \"damping\", \"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"slider\", \"E\"], "
      "[\"ac\", \"middle\"]]}, \"coefficients\": [[0, -4e4]]},"
      "{\"name\": \"s2\", \"type\": \"stiffness\", \"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"slider\", "
      "\"F\"], [\"bd\", \"middle\"]]}, \"coefficients\": [[4e5, -8e5]]},"
      "{\"name\": \"d2\", \"type\": \"damping\", \"input\": {\"type\": \"frame\", \"body_frame_pair\": [[\"slider\", \"F\"], "
      "[\"bd\", \"middle\"]]}, \"coefficients\": [[0, -4e4]]}]}]}",
      rod, middle, I, I, rod, middle, I, I, spin, M_PI / 6.0, M_PI / 6.0);
  return fixture_read(text);
}

/* The moment of inertia about the shaft's axis, and its derivative by the rods' angle b below the horizontal. */
static double about_shaft(double b, double *slope) {
  double reach = offset + middle * cos(b), I = rod_inertia();
  *slope = -4.0 * rod * reach * middle * sin(b) + 4.0 * (5e-6 - I) * sin(b) * cos(b);
  return 5e-6 + 0.005 + 2.0 * (rod * reach * reach + 5e-6 * sin(b) * sin(b) + I * cos(b) * cos(b));
}

/* Both rods alike: x = (b, ḃ, s, ṡ) by Lagrange's equations with the momentum of the spin, which nothing changes. */
static void reduced(const double x[4], double momentum, double out[4]) {
  double b = x[0], slope, J = about_shaft(b, &slope), turn = momentum / J;
  double dx = 0.5 * cos(b), dz = 1.0 - 0.5 * sin(b) - x[2], length = hypot(dx, dz);
  double by_b = (-0.5 * sin(b) * dx - 0.5 * cos(b) * dz) / length, by_s = -dz / length;
  double force = -spring * (length - rest) - damper * (by_b * x[1] + by_s * x[3]);
  double hinge = rod * middle * middle + rod_inertia();
  out[0] = x[1];
  out[1] = (0.25 * slope * turn * turn + rod * 9.81 * middle * cos(b) + force * by_b) / hinge;
  out[2] = x[3];
  out[3] = -9.81 + 2.0 * force * by_s / slider;
}

/* Runge-Kutta of order 4; h times the dampers' rate of 1e4/s is 0.02, so that it errs by 1e-9 of what is fast. */
static void go_reduced(double x[4], double momentum, double time) {
  enum { STEPS_A_SECOND = 500000 };
  int steps = (int)lround(time * STEPS_A_SECOND);
  double h = time / steps, k[4][4], at[4];
  for (int i = 0; i < steps; ++i) {
    for (int stage = 0; stage < 4; ++stage) {
      double by = stage == 0 ? 0.0 : stage == 3 ? h : 0.5 * h;
      for (int c = 0; c < 4; ++c)
        at[c] = x[c] + (stage ? by * k[stage - 1][c] : 0.0);
      reduced(at, momentum, k[stage]);
    }
    for (int c = 0; c < 4; ++c)
      x[c] += h / 6.0 * (k[0][c] + 2.0 * k[1][c] + 2.0 * k[2][c] + k[3][c]);
  }
}

static void test_governor(void **data) {
  (void)data;
  fixture f = governor();
  km_history h = run(&f, 2.0, 1e-9, KM_INTEGRATOR_ADAMS);
  double slope, x[4] = {M_PI / 6.0, 0.0, 0.5, 0.0}, momentum = spin * about_shaft(x[0], &slope);
  int A = km_table_find(h.table, "q.A"), B = km_table_find(h.table, "q.B"), S = km_table_find(h.table, "q.S");
  for (size_t r = 1; r < km_table_rows(h.table); ++r) {
    const double *row = km_table_row(h.table, r);
    go_reduced(x, momentum, row[0] - km_table_row(h.table, r - 1)[0]);
    assert_near(row[A], x[0], 1e-7);
    assert_near(row[B], x[0], 1e-7);
    assert_near(row[S], x[2], 1e-7);
  }
  assert_true(h.figures.stiff);
  assert_true(h.figures.evaluations < 10000);
  km_history_free(&h);
  fixture_close(&f);
}

/* Rows of two runs, scaled by the larger of 1 and the value. */
static double apart(const km_history *a, const km_history *b) {
  double most = 0.0;
  assert_int_equal(km_table_rows(a->table), km_table_rows(b->table));
  for (size_t r = 0; r < km_table_rows(a->table); ++r)
    for (size_t c = 1; c < km_table_columns(a->table); ++c) {
      const char *name = km_table_name(a->table, c);
      double x = km_table_row(a->table, r)[c], y = km_table_row(b->table, r)[c];
      if ((name[0] == 'q' || name[0] == 'v') && name[1] == '.')
        most = fabs(x - y) / fmax(1.0, fabs(x)) <= most ? most : fabs(x - y) / fmax(1.0, fabs(x));
    }
  return most;
}

/* A ball and a slide under a spring and a damper, which swing about a slanted direction. */
static const char swinging[] =
    "{\"model_parameters\": {\"gravity\": [0.4, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
    "\"arm\", \"mass\": 0.2, \"center_of_mass\": [0.3, 0, 0], \"moment_of_inertia\": {\"Ixx\": 0.001, \"Iyy\": 0.002, "
    "\"Izz\": 0.0025}}, {\"name\": \"bob\", \"mass\": 1.5, \"moment_of_inertia\": {\"Ixx\": 0.01, \"Iyy\": 0.012, \"Izz\": "
    "0.015}}], \"joints\": [{\"name\": \"B\", \"type\": \"spherical\", \"body_frame_pairs\": [\"fixed\", \"arm\"], "
    "\"initial_displacement\": [0.2, 0.3, -0.1], \"initial_velocity\": [0, 1, 2], \"damping\": [0.1, 0.1, 0.1]}, "
    "{\"name\": \"S\", \"type\": \"Tx\", \"body_frame_pairs\": [\"arm\", \"bob\"], \"initial_displacement\": 0.5, "
    "\"damping\": 3}], \"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\", "
    "\"joint\": \"S\"}, \"coefficients\": [[200, -400]]}]}]}";

/* BDF with its own matrices, Adams' method without any: one motion, of trees, balls, loops and tyres. */
static void test_methods_agree(void **data) {
  (void)data;
  static const struct {
    const char *model;
    double until, apart; /* error of the less accurate one */
  } runs[] = {{NULL, 2.0, 3e-8},
              {"slider_crank", 2.0, 3e-8},
              {"governor", 1.0, 3e-8},
              {"excavator", 0.5, 3e-8},
              {"vehicle_circle", 0.3, 1e-5}};
  for (size_t i = 0; i < sizeof runs / sizeof *runs; ++i) {
    fixture f = runs[i].model ? fixture_open(runs[i].model) : fixture_read(swinging);
    fixture g = runs[i].model ? fixture_open(runs[i].model) : fixture_read(swinging);
    km_history adams = run(&f, runs[i].until, 1e-9, KM_INTEGRATOR_ADAMS);
    km_history bdf = run(&g, runs[i].until, 1e-9, KM_INTEGRATOR_BDF);
    assert_true(bdf.figures.stiff);
    assert_at_most(apart(&adams, &bdf), runs[i].apart);
    km_history_free(&adams);
    km_history_free(&bdf);
    fixture_close(&f);
    fixture_close(&g);
  }
}

/* Loops that are held by feeding their errors back, from the first short steps on: to the tolerance the same motion. */
static void test_feeding_back(void **data) {
  (void)data;
  static const km_integrator integrators[] = {KM_INTEGRATOR_ADAMS, KM_INTEGRATOR_BDF};
  fixture f = fixture_open("slider_crank");
  km_history closed = run(&f, 1.0, 1e-9, KM_INTEGRATOR_ADAMS);
  for (int i = 0; i < 2; ++i) {
    fixture g = fixture_open("slider_crank");
    km_history fed = run_by(&g, 1.0, 1e-9, integrators[i], KM_STABILISE_BAUMGARTE);
    assert_at_most(fed.worst_loop, 1e-8);
    assert_at_most(apart(&closed, &fed), 1e-7);
    km_history_free(&fed);
    fixture_close(&g);
  }
  km_history_free(&closed);
  fixture_close(&f);
}

/* A motion that isn't stiff stays with the method of high orders, whatever the tolerance. */
static void test_not_stiff(void **data) {
  (void)data;
  static const double tolerances[] = {1e-3, 1e-5, 1e-7, 1e-10};
  for (size_t i = 0; i < sizeof tolerances / sizeof *tolerances; ++i) {
    fixture f = fixture_open("klann");
    km_history h = run(&f, 5.0, tolerances[i], KM_INTEGRATOR_ADAMS);
    assert_false(h.figures.stiff);
    km_history_free(&h);
    fixture_close(&f);
  }
}

/* The wheels turn at 1400 rad/s against their slip, lightly damped. */
static void test_vehicle(void **data) {
  (void)data;
  fixture f = fixture_open("vehicle_circle");
  km_history h = run(&f, 20.0, 1e-4, KM_INTEGRATOR_ADAMS);
  assert_true(h.figures.stiff);
  assert_true(h.figures.evaluations < 6000); /* Adams' method alone: 80 000 */
  assert_at_most(h.energy_error, 1e-4 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_damped),
      claim_test(test_governor, "IFToMM A05: the stiff flyball governor, against Lagrange's equations of its own",
                 "1e-7: steps of 1e-9 add up over the run"),
      cmocka_unit_test(test_methods_agree),
      cmocka_unit_test(test_feeding_back),
      cmocka_unit_test(test_not_stiff),
      cmocka_unit_test(test_vehicle)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
