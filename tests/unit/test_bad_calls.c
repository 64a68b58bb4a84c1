/* Errors of complete calls, each with its text: numbers out of range, objects that don't belong together, cancelled
 * work. */
#include "support/refusals.h"

#include "kmech/build.h"
#include "kmech/dynamics.h"
#include "kmech/mechanism.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"
#include "model/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void expect(km_status status, km_status expected, const km_error *error, const char *words) {
  const told_text t = {"a call", words};
  assert_true(is_told(&t, status, expected, NULL, error));
}

static km_forces *forces_of(const fixture *f) {
  km_forces *forces;
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  return forces;
}

static bool stop(void *context, double done) {
  (void)context, (void)done;
  return false;
}

static void refuse_simulation(fixture *f, km_dynamics *d, km_simulation_def def, const char *words) {
  km_simulation *run = NULL;
  km_error e = {.text = ""};
  expect(km_simulation_create(d, f->state, &def, &run, &e), KM_USAGE, &e, words);
  assert_null(run);
}

static void simulations(void **state) {
  (void)state;
  fixture f = fixture_open("slider_crank");
  km_forces *forces = forces_of(&f);
  km_dynamics *d;
  km_simulation *run;
  km_error e = {.text = ""};
  assert_int_equal(km_dynamics_create(f.mechanism, forces, &d, &e), KM_OK);
  km_simulation_def right = km_simulation_default(), def = right;
  def.relative = 2.0;
  refuse_simulation(&f, d, def, "tolerances 2 and 1e-07; expected a relative one below 1");
  def = right;
  def.max_step = -1.0;
  refuse_simulation(&f, d, def, "longest step -1; expected 0 or a positive number");
  def = right;
  def.integrator = KM_INTEGRATOR_FIXED;
  refuse_simulation(&f, d, def, "no step is given; expected one for steps of fixed length");
  def = right;
  def.stabilisation = (km_stabilisation)9;
  refuse_simulation(&f, d, def, "stabilisation 9; expected one that exists");
  def = right;
  def.end = -1.0;
  refuse_simulation(&f, d, def, "end -1; expected a time from 0 on");
  const km_crossing crossing = {.value = HUGE_VAL};
  def = right;
  def.crossings = &crossing;
  def.crossing_count = 1;
  refuse_simulation(&f, d, def, "crossing at inf; expected a finite value");
  assert_int_equal(km_simulation_create(d, f.state, &right, &run, &e), KM_OK);
  expect(km_simulation_advance(run, -1.0, NULL, NULL, &e), KM_USAGE, &e, "time -1; expected one from 0 to inf");
  expect(km_simulation_advance(run, 1.0, stop, NULL, &e), KM_CANCELLED, &e, "cancelled at time");
  expect(km_dynamics_prescribe(d, 0, (double)NAN, 0.0, &e), KM_USAGE, &e, "for A; expected finite values");
  km_simulation_free(run);
  km_dynamics_free(d);
  km_forces_free(forces);
  fixture_close(&f);
}

static void runs(void **state) {
  (void)state;
  fixture f = fixture_open("slider_crank");
  km_forces *forces = forces_of(&f);
  km_history h;
  km_error e = {.text = ""};
  km_history_def def = km_history_default(f.model);
  def.every = 0.0;
  expect(km_history_run(f.mechanism, forces, f.state, &def, &h, &e), KM_USAGE, &e,
         "0 between rows; expected a positive time");
  def = km_history_default(f.model);
  def.progress = stop;
  expect(km_history_run(f.mechanism, forces, f.state, &def, &h, &e), KM_CANCELLED, &e, "cancelled at time");
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

static void inverse_runs(void **state) {
  (void)state;
  fixture f = fixture_open("klann");
  km_forces *forces = forces_of(&f);
  km_history h;
  km_error e = {.text = ""};
  const km_constant_rate rate = {0, 2.0};
  km_inverse_def inverse = {.rates = &rate, .rate_count = 1, .until = 0.0, .steps = 10};
  expect(km_inverse_run(f.mechanism, forces, f.state, &inverse, &h, &e), KM_USAGE, &e,
         "duration 0; expected a positive time");
  inverse.until = 1.0;
  inverse.steps = 0;
  expect(km_inverse_run(f.mechanism, forces, f.state, &inverse, &h, &e), KM_USAGE, &e,
         "0 steps; expected at least one");
  inverse.steps = 10;
  inverse.rate_count = 0;
  expect(km_inverse_run(f.mechanism, forces, f.state, &inverse, &h, &e), KM_USAGE, &e,
         "no motion is prescribed; expected a rate of a joint");
  inverse.rate_count = 1;
  inverse.progress = stop;
  expect(km_inverse_run(f.mechanism, forces, f.state, &inverse, &h, &e), KM_CANCELLED, &e, "cancelled at time");
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

/* Drives that can't be, and a search that is cancelled. */
static void drives_and_rest(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, 0, -9.81]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1, "
      "\"center_of_mass\": [1, 0, 0], \"moment_of_inertia\": {\"Ixx\": 1, \"Iyy\": 1, \"Izz\": 1}}], \"joints\": [{\"name\": \"S\", \"type\": \"spherical\", \"body_frame_pairs\": "
      "[\"fixed\", \"b\"]}]}]}");
  km_forces *forces = forces_of(&f);
  km_dynamics *d;
  km_error e = {.text = ""};
  assert_int_equal(km_dynamics_create(f.mechanism, forces, &d, &e), KM_OK);
  expect(km_dynamics_prescribe(d, 0, 0.0, 1.0, &e), KM_USAGE, &e, "joint \"S[0]\" is held, or a ball");
  expect(km_equilibrium_find(d, f.state, true, stop, NULL, &e), KM_CANCELLED, &e, "cancelled while settling");
  km_dynamics_free(d);
  km_forces_free(forces);
  fixture_close(&f);
}

/* A file that is only large. */
static void large_files(void **state) {
  (void)state;
  char path[] = "/tmp/large-XXXXXX";
  km_model *model;
  km_error e = {.text = ""};
  int file = mkstemp(path);
  assert_true(file >= 0 && ftruncate(file, (off_t)1 << 33) == 0);
  close(file);
  km_status status = km_model_read_file(path, NULL, &model, &e);
  unlink(path);
  expect(status, KM_IO, &e, "MiB; expected a model file");
}

/* Objects of two mechanisms. */
static void strangers(void **state) {
  (void)state;
  fixture f = fixture_open("slider_crank"), g = fixture_open("klann");
  km_forces *forces = forces_of(&g), *own = forces_of(&f);
  km_dynamics *d = NULL, *of_g;
  km_linear linear;
  km_table *motion;
  km_error e = {.text = ""};
  expect(km_dynamics_create(f.mechanism, forces, &d, &e), KM_USAGE, &e, "the forces are those of another mechanism");
  assert_int_equal(km_dynamics_create(f.mechanism, own, &d, &e), KM_OK);
  assert_int_equal(km_dynamics_create(g.mechanism, forces, &of_g, &e), KM_OK);
  assert_int_equal(km_linearise(d, f.state, &linear, &e), KM_OK);
  expect(km_linear_motion(of_g, g.state, &linear, 0, 9, &motion, &e), KM_USAGE, &e,
         "linearised equations of 4 coordinates; expected those of the mechanism's 7");
  expect(km_linear_motion(d, f.state, &linear, 7, 9, &motion, &e), KM_USAGE, &e, "eigenvalue 7; expected one of 2");
  for (int c = 0; c < 8; ++c) /* the mode of no pose: what follows the independent coordinate goes the wrong way */
    linear.modes[c] *= c % 4 == linear.independent[0] ? 1.0 : -1.0;
  expect(km_linear_motion(d, f.state, &linear, 0, 9, &motion, &e), KM_DIVERGED, &e,
         "the loops can't be closed along the mode; the pose can be a dead point");
  km_linear_free(&linear);
  km_dynamics_free(d);
  km_dynamics_free(of_g);
  km_forces_free(forces);
  km_forces_free(own);
  fixture_close(&f);
  fixture_close(&g);
}

static void ends_and_actuators(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_transfer *lever;
  km_statics statics;
  km_error e = {.text = ""};
  const km_port joint = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "A"};
  const km_port odd = {.kind = (km_port_kind)7, .name = "x"}, still = {.kind = KM_PORT_POINT, .name = "x"};
  expect(km_transfer_create(f.mechanism, &joint, &odd, &lever, &e), KM_USAGE, &e,
         "the output is neither a joint nor a point");
  expect(km_transfer_create(f.mechanism, &still, &joint, &lever, &e), KM_USAGE, &e,
         "the input is a point without a direction");
  const int twice[2] = {1, 1};
  expect(km_statics_create(f.mechanism, twice, 2, KM_AXES_JOINT, &statics, &e), KM_USAGE, &e,
         "actuator \"B\" is named twice; expected each joint once");
  km_statics_free(&statics);
  fixture_close(&f);
}

static void sweeps(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_mobility_sweep sweep;
  km_error e = {.text = ""};
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.to = HUGE_VAL;
  expect(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &e), KM_USAGE, &e,
         "a range from 0 to inf; expected finite values");
  plan = km_sweep_plan_default(f.model);
  plan.steps = -1;
  expect(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &e), KM_USAGE, &e, "-1 steps; expected 0 to");
  fixture_close(&f);
}

/* A branch point of two motions, where a parallelogram's links are collinear: there is no fifth direction. */
static void branches(void **state) {
  (void)state;
  fixture f = parallelogram(0.5);
  km_mobility_sweep sweep;
  km_error e = {.text = ""};
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.arclength = 0.2;
  plan.steps = 50;
  plan.branch = 9;
  expect(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &e), KM_USAGE, &e, "branch 9: 2 motions meet at");
  assert_non_null(strstr(e.text, "expected at most 3"));
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

/* A polygon of hinges, one more than singular values are found of. */
static void many_singular_values(void **state) {
  (void)state;
  enum { HINGES = KM_MAX_SINGULAR + 1 };
  km_text text = {0};
  km_mobility_sweep sweep;
  km_error e = {.text = ""};
  km_text_add(
      &text,
      "{\"model_parameters\": {\"version\": \"1.1\"}, \"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", "
      "\"bodies\": [");
  for (int i = 1; i < HINGES; ++i)
    km_text_format(&text, "%s{\"name\": \"%d\"}", i > 1 ? ", " : "", i);
  km_text_add(&text, "], \"joints\": [");
  for (int i = 0; i < HINGES; ++i)
    km_text_format(
        &text,
        "%s{\"name\": \"J%d\", \"type\": \"revolute\", \"bodies\": [\"%.*d%s\", \"%.*d%s\"], \"at\": [%.17g, %.17g]}",
        i ? ", " : "", i, i > 0, i, i ? "" : "fixed", i + 1 < HINGES, (i + 1) % HINGES, i + 1 < HINGES ? "" : "fixed",
        cos(2.0 * M_PI * i / HINGES), sin(2.0 * M_PI * i / HINGES));
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  plan.coordinate = 0;
  plan.from = 0.0;
  plan.to = 0.1;
  plan.steps = 1;
  plan.singularities = true;
  expect(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &e), KM_USAGE, &e,
         "singular values of substructure 1, which has 301 coordinates; expected at most 300");
  km_mobility_sweep_free(&sweep);
  km_text_free(&text);
  fixture_close(&f);
}

static void poses(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_modes modes;
  km_mechanism *held;
  km_state *of_held;
  const km_hold still = {0, 0.3};
  km_error e = {.text = ""};
  int pose;
  double values[4] = {0.0, (double)NAN, 0.0, 0.0};
  const km_hold endless = {0, HUGE_VAL};
  expect(km_state_set_coordinates(f.mechanism, f.state, values, &e), KM_USAGE, &e, "for B; expected a finite value");
  expect(km_modes_find(f.mechanism, f.state, 0, -1, 1, NULL, NULL, &modes, &e), KM_USAGE, &e,
         "-1 starts; expected 0 to");
  expect(km_mechanism_compile(f.model, &endless, 1, &held, &e), KM_USAGE, &e, "joint \"A\" can't be held at inf");
  expect(km_state_set_time(f.mechanism, f.state, HUGE_VAL, &e), KM_USAGE, &e, "time inf; expected a finite value");
  expect(km_state_set_rate(f.mechanism, f.state, 0, HUGE_VAL, &e), KM_USAGE, &e, "inf for A; expected a finite value");
  assert_int_equal(km_mechanism_compile(f.model, &still, 1, &held, &e), KM_OK);
  assert_int_equal(km_state_create(held, &of_held, &e), KM_OK);
  expect(km_state_set_rate(held, of_held, 0, 1.0, &e), KM_USAGE, &e,
         "joint \"A\" is held; expected one that is free to move");
  expect(km_modes_find(held, of_held, 0, 1, 1, NULL, NULL, &modes, &e), KM_USAGE, &e,
         "joint \"A\" can't be the driver of assembly modes");
  expect(km_state_move_to(held, of_held, &still, 1, &e), KM_USAGE, &e,
         "\"A\" is held; expected a joint that is free to move");
  km_state_free(of_held);
  km_mechanism_free(held);
  expect(km_model_weigh_meshes(NULL, &e), KM_USAGE, &e, "found no model");
  expect(km_model_find_pose(f.model, "home", &pose, &e), KM_USAGE, &e, "\"home\" names no pose: the model names none");
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(simulations),
                                     cmocka_unit_test(runs),
                                     cmocka_unit_test(inverse_runs),
                                     cmocka_unit_test(strangers),
                                     cmocka_unit_test(ends_and_actuators),
                                     cmocka_unit_test(drives_and_rest),
                                     cmocka_unit_test(large_files),
                                     cmocka_unit_test(sweeps),
                                     cmocka_unit_test(branches),
                                     cmocka_unit_test(many_singular_values),
                                     cmocka_unit_test(poses)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
