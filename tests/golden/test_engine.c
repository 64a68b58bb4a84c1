/* models/engine: one gas force in statics, inverse dynamics and a run, against the slider-crank's closed form and
 * sums of F dP. */
#include "support/support.h"

#include "kmech/dynamics.h"
#include "kmech/mobility.h"
#include "kmech/statics.h"

static const double crank = 40.0, rod = 140.0;

/* Gas force at a crank angle in degrees: the model's table, joined by lines, with a period of 720. */
static double gas(double angle) {
  static const double rows[][2] = {{0, 9000},  {12, 20000}, {30, 13000}, {60, 5200},  {100, 2300}, {150, 1200},
                                   {200, 200}, {540, 0},    {660, 1500}, {700, 6000}, {720, 9000}};
  double u = angle - 720.0 * floor(angle / 720.0);
  int i = 0;
  while (u > rows[i + 1][0])
    ++i;
  return rows[i][1] + (rows[i + 1][1] - rows[i][1]) * (u - rows[i][0]) / (rows[i + 1][0] - rows[i][0]);
}

/* Height of the piston's pin above the crank's axis: r cos A + √(l² − r² sin² A). */
static double height(double angle) {
  double a = angle * M_PI / 180.0;
  return crank * cos(a) + sqrt(rod * rod - crank * crank * sin(a) * sin(a));
}

/* Work of the gas from the angle 0, by the trapezoidal rule in parts of 0.01°; its error is below 1e-8 of the sum of
 * all parts. */
static double gas_work(double to) {
  double work = 0.0;
  long parts = (long)ceil(to / 0.01);
  for (long i = 0; i < parts; ++i) {
    double a = to * (double)i / (double)parts, b = to * (double)(i + 1) / (double)parts;
    work -= 0.5 * (gas(a) + gas(b)) * (height(b) - height(a));
  }
  return work;
}

typedef struct engine {
  fixture f;
  km_forces *forces;
  int a; /* coordinate of the crank */
} engine;

static engine engine_open(void) {
  engine e = {.f = fixture_open("engine")};
  assert_int_equal(km_model_find_coordinate(e.f.model, "A", &e.a, NULL), KM_OK);
  assert_int_equal(km_forces_create_own(e.f.mechanism, &e.forces, NULL), KM_OK);
  return e;
}

static void engine_close(engine *e) {
  km_forces_free(e->forces);
  fixture_close(&e->f);
}

/* The holding torque of massless links: F dP/dA, dP/dA = −r sin A − r² sin A cos A / √(l² − r² sin² A). */
static void statics_hold_the_gas(void **state) {
  (void)state;
  engine e = engine_open();
  km_statics statics;
  km_mobility mobility;
  static const double weightless[3] = {0, 0, 0};
  km_load load = km_model_load_at(e.f.model, 0);
  km_forces *forces;
  assert_int_equal(km_forces_create(e.f.mechanism, weightless, &load, 1, &forces, NULL), KM_OK);
  assert_int_equal(km_statics_create(e.f.mechanism, &e.a, 1, KM_AXES_JOINT, &statics, NULL), KM_OK);
  for (int i = -20; i < 90; ++i) {
    assert_int_equal(km_state_set_coordinate(e.f.mechanism, e.f.state, e.a, 17.3 * i, NULL), KM_OK);
    assert_int_equal(km_assemble(e.f.mechanism, e.f.state, NULL, NULL), KM_OK);
    double angle = km_state_coordinate(e.f.state, e.a), a = angle * M_PI / 180.0;
    double slope =
        -crank * sin(a) - crank * crank * sin(a) * cos(a) / sqrt(rod * rod - crank * crank * sin(a) * sin(a));
    assert_int_equal(km_mobility_compute(e.f.mechanism, e.f.state, &mobility), KM_OK);
    assert_int_equal(km_statics_compute(e.f.mechanism, e.f.state, forces, &statics), KM_OK);
    assert_near(statics.actuator_forces[0], gas(angle) * slope, 1e-8 * 20000.0 * crank);
  }
  km_statics_free(&statics);
  km_forces_free(forces);
  engine_close(&e);
}

/* All kinetic and potential energies return after a cycle at constant speed: the drive takes the work of the gas. */
static void inverse_dynamics_takes_the_work(void **state) {
  (void)state;
  engine e = engine_open();
  const km_constant_rate rate = {.coordinate = e.a, .rate = 18000.0}; /* degrees per second: 3000 rpm */
  km_inverse_def def = {.until = 0.04, .steps = 7200, .rates = &rate, .rate_count = 1};
  km_history h;
  assert_int_equal(km_inverse_run(e.f.mechanism, e.forces, e.f.state, &def, &h, NULL), KM_OK);
  int f = km_table_find(h.table, "f.A");
  double work = 0.0;
  for (size_t r = 0; r + 1 < km_table_rows(h.table); ++r) /* the trapezoidal rule, in steps of 0.1° */
    work += 0.5 * (km_table_row(h.table, r)[f] + km_table_row(h.table, r + 1)[f]) * 0.1 * M_PI / 180.0;
  assert_near(-work, gas_work(720.0), 1e-5 * gas_work(200.0));
  km_history_free(&h);
  engine_close(&e);
}

/* The motor work of a run is that of the gas up to the crank's angle. */
static void a_run_gains_the_work(void **state) {
  (void)state;
  engine e = engine_open();
  km_history_def def = km_history_default(e.f.model);
  km_history h;
  def.until = 0.05;
  def.every = 0.001;
  def.simulation.relative = def.simulation.absolute = 1e-10;
  assert_int_equal(km_state_set_rate(e.f.mechanism, e.f.state, e.a, 18000.0, NULL), KM_OK);
  assert_int_equal(km_history_run(e.f.mechanism, e.forces, e.f.state, &def, &h, NULL), KM_OK);
  int q = km_table_find(h.table, "q.A"), w = km_table_find(h.table, "motor_work");
  size_t last = km_table_rows(h.table) - 1;
  assert_true(km_table_row(h.table, last)[q] > 720.0);
  for (size_t r = 0; r <= last; r += 5)
    assert_near(km_table_row(h.table, r)[w], gas_work(km_table_row(h.table, r)[q]), 1e-7 * gas_work(200.0));
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  km_history_free(&h);
  engine_close(&e);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(statics_hold_the_gas),
                                     cmocka_unit_test(inverse_dynamics_takes_the_work),
                                     cmocka_unit_test(a_run_gains_the_work)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
