/* A program takes part in a run: forces by a function, inputs between steps, events, restarts (docs/theory.md 11.8).
 * The judges are the same laws built in, closed forms and the balance of energy. */
#include "support/moving.h"

#include "kmech/inspect.h"

#include <math.h>
#include <string.h>

/* A body on a slide along z, 2 kg, with a frame beside its axis. */
static const char slide[] =
    "{\"model_parameters\": {\"gravity\": [0, 0, -10]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"b\", "
    "\"mass\": 2, \"frames\": [{\"name\": \"tip\", \"translation\": [0.5, 0, 0]}]}], \"joints\": [{\"name\": \"J\", "
    "\"type\": \"Tz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}";

/* The slide with a controller of the position, whose reference is 1. */
static const char controlled[] =
    "{\"model_parameters\": {\"gravity\": [0, 0, 0]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"b\", "
    "\"mass\": 2}], \"joints\": [{\"name\": \"J\", \"type\": \"Tz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}], "
    "\"force_modules\": [{\"name\": \"c\", \"type\": \"pid\", \"input\": {\"joint\": \"J\"}, \"output\": {\"joint\": "
    "\"J\"}, \"reference\": 1, \"kp\": 8, \"kd\": 4}]}]}";

/* A run of a fixture with forces of a program. */
typedef struct program_run {
  fixture f;
  km_forces *forces;
  km_dynamics *dynamics;
  km_simulation *run;
} program_run;

static program_run start(const char *text, const km_user_forces *user, const km_simulation_def *def) {
  program_run p = {.f = fixture_read(text)};
  km_error error = {0};
  assert_int_equal(km_forces_create(p.f.mechanism, NULL, NULL, 0, &p.forces, NULL), KM_OK);
  if (user)
    assert_int_equal(km_forces_set_user(p.forces, user, NULL), KM_OK);
  assert_int_equal(km_dynamics_create(p.f.mechanism, p.forces, &p.dynamics, NULL), KM_OK);
  if (km_simulation_create(p.dynamics, p.f.state, def, &p.run, &error))
    fail_msg("%s", error.text);
  return p;
}

static void finish(program_run *p) {
  km_simulation_free(p->run);
  km_dynamics_free(p->dynamics);
  km_forces_free(p->forces);
  fixture_close(&p->f);
}

static km_simulation_def accurate(void) {
  km_simulation_def def = km_simulation_default();
  def.relative = def.absolute = 1e-11;
  return def;
}

/* Joint force −k q − c q̇ of a program. */
typedef struct spring_damper {
  int coordinate;
  double k, c;
} spring_damper;

static bool push_joint(void *context, const km_motion_sample *sample, double *joint, double (*wrenches)[6]) {
  const spring_damper *law = context;
  (void)wrenches;
  joint[law->coordinate] -= law->k * sample->q[law->coordinate] + law->c * sample->rate[law->coordinate];
  return true;
}

/* z̈ = g − (k z + c ż)/m: the closed form of a damped oscillation. */
static void test_joint_force(void **data) {
  (void)data;
  spring_damper law = {0, 50.0, 4.0};
  const km_simulation_def def = accurate();
  program_run p = start(slide, &(km_user_forces){.compute = push_joint, .context = &law}, &def);
  const double m = 2.0, rest = -10.0 * m / law.k, decay = law.c / (2.0 * m), w = sqrt(law.k / m - decay * decay);
  for (int i = 1; i <= 5; ++i) {
    double t = 0.3 * i;
    assert_int_equal(km_simulation_advance(p.run, t, NULL, NULL, NULL), KM_OK);
    double z = rest - rest * exp(-decay * t) * (cos(w * t) + decay / w * sin(w * t));
    assert_near(km_state_coordinate(p.f.state, 0), z, 1e-9);
  }
  /* the power of the program is motor work */
  km_energy e;
  assert_int_equal(km_dynamics_energy(p.dynamics, p.f.state, &e, NULL), KM_OK);
  km_simulation_figures figures = km_simulation_figures_of(p.run);
  assert_near(e.kinetic + e.potential, figures.motor_work, 1e-8);
  assert_near(figures.dissipated, 0.0, 1e-14);
  finish(&p);
}

/* A wrench that follows the frame's velocity: F = −c v at the frame, and its moment, which the slide bears. */
static bool push_frame(void *context, const km_motion_sample *sample, double *joint, double (*wrenches)[6]) {
  const double *c = context;
  (void)joint;
  wrenches[0][2] = -*c * sample->frames[0].velocity[2];
  wrenches[0][4] = 7.0;
  return true;
}

static void test_wrench(void **data) {
  (void)data;
  double c = 3.0;
  const km_simulation_def def = accurate();
  fixture f = fixture_read(slide);
  int tip;
  const char *names[] = {"b", "tip"};
  assert_int_equal(km_model_find_frame(f.model, names, 2, &tip, NULL), KM_OK);
  fixture_close(&f);
  program_run p =
      start(slide, &(km_user_forces){.compute = push_frame, .context = &c, .frames = &tip, .frame_count = 1}, &def);
  assert_int_equal(km_simulation_advance(p.run, 1.0, NULL, NULL, NULL), KM_OK);
  double speed = -10.0 * 2.0 / c * (1.0 - exp(-c / 2.0));
  assert_near(km_state_rate(p.f.state, 0), speed, 1e-9);
  finish(&p);
}

/* A program's law in loops equals the damper of the model: the slider-crank. */
static void test_same_law_built_in(void **data) {
  (void)data;
  fixture own = fixture_open("slider_crank"), built_in = fixture_open("slider_crank");
  built_in.model->coordinates[0].damping = 0.02;
  spring_damper law = {0, 0.0, 0.02};
  const km_simulation_def def = accurate();
  km_forces *forces[2];
  km_dynamics *dynamics[2];
  km_simulation *run[2];
  fixture *f[2] = {&own, &built_in};
  for (int i = 0; i < 2; ++i) {
    assert_int_equal(km_forces_create(f[i]->mechanism, NULL, NULL, 0, &forces[i], NULL), KM_OK);
    if (i == 0)
      assert_int_equal(km_forces_set_user(forces[i], &(km_user_forces){.compute = push_joint, .context = &law}, NULL),
                       KM_OK);
    assert_int_equal(km_dynamics_create(f[i]->mechanism, forces[i], &dynamics[i], NULL), KM_OK);
    assert_int_equal(km_simulation_create(dynamics[i], f[i]->state, &def, &run[i], NULL), KM_OK);
    assert_int_equal(km_simulation_advance(run[i], 2.0, NULL, NULL, NULL), KM_OK);
  }
  /* in radians per coordinate unit, the same law */
  for (int c = 0; c < own.mechanism->coordinate_count; ++c)
    assert_near(km_state_coordinate(own.state, c), km_state_coordinate(built_in.state, c), 1e-8);
  for (int i = 0; i < 2; ++i) {
    km_simulation_free(run[i]);
    km_dynamics_free(dynamics[i]);
    km_forces_free(forces[i]);
    fixture_close(f[i]);
  }
}

static double height_over_floor(void *context, const km_motion_sample *sample) {
  const double *floor = context;
  return sample->q[0] - *floor;
}

/* A ball bounces: the program's event stops the run, reverses the velocity and restarts. Falls of height h last
 * √(2h/g); every bounce keeps e² of the height. */
static void test_bounces(void **data) {
  (void)data;
  double floor = -0.8;
  const double e = 0.9, g = 10.0;
  const km_crossing crossing = {.stops = true, .function = height_over_floor, .context = &floor};
  km_simulation_def def = accurate();
  def.crossings = &crossing;
  def.crossing_count = 1;
  program_run p = start(slide, NULL, &def);
  double speed = sqrt(2.0 * g * -floor), due = speed / g;
  for (int bounce = 0; bounce < 8; ++bounce) {
    assert_int_equal(km_simulation_advance(p.run, 100.0, NULL, NULL, NULL), KM_PARTIAL);
    assert_int_equal(km_simulation_crossing_count(p.run), bounce + 1);
    assert_near(km_simulation_crossing(p.run, bounce).time, due, 1e-8);
    assert_near(km_state_rate(p.f.state, 0), -speed, 1e-8);
    speed *= e;
    due += 2.0 * speed / g;
    assert_int_equal(km_state_set_rate(p.f.mechanism, p.f.state, 0, speed, NULL), KM_OK);
    assert_int_equal(km_simulation_restart(p.run, NULL), KM_OK);
  }
  finish(&p);
}

/* Fixed steps end exactly where they should, and inputs act from the step after they were set. */
static void check_inputs(km_integrator integrator, double tolerance) {
  km_simulation_def def = accurate();
  def.integrator = integrator;
  def.max_step = 1e-3;
  program_run p = start(controlled, NULL, &def);
  km_error error;
  /* m z̈ + 4 ż + 8 z = 8 r + F: decay 1, w = √3; from z = 0 at rest to z_end = r + F/8 */
  const double w = sqrt(3.0), inputs[3][2] = {{1.0, 0.0}, {NAN, 4.0}, {-0.5, 0.0}};
  double z0 = 0.0, v0 = 0.0;
  for (int k = 0; k < 3; ++k) {
    assert_int_equal(km_forces_set_reference(p.forces, 0, inputs[k][0], NULL), KM_OK);
    assert_int_equal(km_forces_set_joint_force(p.forces, 0, inputs[k][1], NULL), KM_OK);
    if (k > 0)
      assert_int_equal(km_simulation_restart(p.run, NULL), KM_OK);
    if (integrator == KM_INTEGRATOR_FIXED)
      for (int i = 0; i < 500; ++i)
        assert_int_equal(km_simulation_step(p.run, NULL), KM_OK);
    else
      assert_int_equal(km_simulation_advance(p.run, 0.5 * (k + 1), NULL, NULL, NULL), KM_OK);
    assert_true(p.f.state->time == 0.5 * (k + 1));
    double end = (isnan(inputs[k][0]) ? 1.0 : inputs[k][0]) + inputs[k][1] / 8.0, a = z0 - end, b = (v0 + a) / w;
    double decay = exp(-0.5), cosine = cos(0.5 * w), sine = sin(0.5 * w);
    z0 = end + decay * (a * cosine + b * sine);
    v0 = decay * ((b * w - a) * cosine - (a * w + b) * sine);
    assert_near(km_state_coordinate(p.f.state, 0), z0, tolerance);
    assert_near(km_state_rate(p.f.state, 0), v0, tolerance);
  }
  assert_int_equal(km_forces_set_reference(p.forces, 1, 0.0, &error), KM_USAGE);
  assert_int_equal(km_forces_set_reference(p.forces, 0, HUGE_VAL, &error), KM_USAGE);
  assert_int_equal(km_forces_set_joint_force(p.forces, 0, NAN, &error), KM_USAGE);
  assert_int_equal(km_forces_set_joint_force(p.forces, 1, 0.0, &error), KM_USAGE);
  assert_int_equal(km_forces_set_load(p.forces, 0, &(km_load){0}, &error), KM_USAGE);
  finish(&p);
}

static void test_inputs(void **data) {
  (void)data;
  check_inputs(KM_INTEGRATOR_FIXED, 1e-11); /* Runge-Kutta's error of order h⁴ */
  check_inputs(KM_INTEGRATOR_ADAMS, 1e-9);
  check_inputs(KM_INTEGRATOR_BDF, 1e-7);
}

static bool stop_later(void *context, const km_motion_sample *sample, double *joint, double (*wrenches)[6]) {
  (void)context;
  (void)joint;
  (void)wrenches;
  return sample->time < 0.25;
}

/* A program stops the run from its function; missing functions and late calls are refused. */
static void test_errors(void **data) {
  (void)data;
  km_error error;
  const km_simulation_def def = accurate();
  program_run p = start(slide, &(km_user_forces){.compute = stop_later}, &def);
  assert_int_equal(km_simulation_advance(p.run, 1.0, NULL, NULL, &error), KM_CANCELLED);
  assert_string_equal(error.text, "the program's force function stopped the run");
  assert_true(p.f.state->time < 0.25);
  assert_int_equal(km_forces_set_user(p.forces, &(km_user_forces){.compute = stop_later}, &error), KM_USAGE);
  assert_int_equal(km_forces_set_user(p.forces, &(km_user_forces){0}, &error), KM_USAGE);
  assert_int_equal(km_simulation_step(NULL, &error), KM_USAGE);
  assert_int_equal(km_simulation_restart(NULL, &error), KM_USAGE);
  finish(&p);
  km_forces *forces;
  fixture f = fixture_read(slide);
  const int none = 99;
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(
      km_forces_set_user(forces, &(km_user_forces){.compute = stop_later, .frames = &none, .frame_count = 1}, &error),
      KM_USAGE);
  km_forces_free(forces);
  fixture_close(&f);
}

/* A slide at 2 m/s passes its limit of 1 m in the third step of 0.25 s; a stop without damping reflects it. */
static void limits_of_a_session(void **state) {
  (void)state;
  fixture f =
      fixture_read("{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1}], \"joints\": "
                   "[{\"name\": \"X\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"], "
                   "\"initial_velocity\": 2, \"limits\": [-5, 1]}]}]}");
  km_session_def def = km_session_default(f.model);
  km_session *session;
  def.step = 0.25;
  assert_int_equal(km_session_create(f.mechanism, f.state, &def, &session, NULL), KM_OK);
  assert_int_equal(km_session_step(session, 2, NULL), KM_OK);
  assert_int_equal(km_session_limit_count(session), 0);
  assert_int_equal(km_session_limit(session, 0).coordinate, -1);
  assert_int_equal(km_session_step(session, 2, NULL), KM_OK);
  assert_int_equal(km_session_limit_count(session), 1);
  const km_passed_limit passed = km_session_limit(session, 0);
  assert_int_equal(passed.coordinate, 0);
  assert_true(passed.upper);
  assert_near(passed.limit, 1.0, 0.0);
  assert_near(passed.time, 0.75, 1e-12);
  assert_near(passed.beyond, 1.0, 1e-12);
  km_session_free(session);
  def.step = 1e-3;
  def.limit_stop[0] = 400.0;
  assert_int_equal(km_session_create(f.mechanism, f.state, &def, &session, NULL), KM_OK);
  assert_int_equal(km_session_step(session, 1000, NULL), KM_OK);
  assert_int_equal(km_session_limit_count(session), 0);
  assert_near(km_state_rate(km_session_state(session), 0), -2.0, 1e-3); /* steps don't end where the stop begins */
  km_session_free(session);
  def.limit_stop[0] = -1.0;
  assert_int_equal(km_session_create(f.mechanism, f.state, &def, &session, NULL), KM_USAGE);
  assert_null(session);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_joint_force), cmocka_unit_test(test_wrench), cmocka_unit_test(test_same_law_built_in),
      cmocka_unit_test(test_bounces),     cmocka_unit_test(test_inputs), cmocka_unit_test(limits_of_a_session),
      cmocka_unit_test(test_errors)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
