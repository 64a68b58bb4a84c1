/* Stiff motions: against closed forms, against the other method, and how much work they take. */
#include "support/moving.h"

#include "kmech/history.h"

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

/* ẍ + 1e5 ẋ + 2e4 x = 0 from rest: x = (λ₁ e^(λ₂ t) − λ₂ e^(λ₁ t))/(λ₁ − λ₂), λ₁ ≈ −1e5, λ₂ ≈ −0.2. Adams' method, whose
 * steps can't be longer than about 2e-5, would need a million evaluations. */
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
    double until, apart; /* what the less accurate of both errs by */
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
    assert_true(apart(&adams, &bdf) < runs[i].apart);
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
    assert_true(fed.worst_loop < 1e-8);
    assert_true(apart(&closed, &fed) < 1e-7);
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
  assert_true(h.energy_error <= 1e-4 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_damped), cmocka_unit_test(test_methods_agree),
                                     cmocka_unit_test(test_feeding_back), cmocka_unit_test(test_not_stiff),
                                     cmocka_unit_test(test_vehicle)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
