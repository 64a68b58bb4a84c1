/* Judges what the library makes of a model's text: answers are laws' answers, refusals have words. */
#include "judge.h"

#include "kmech/dynamics.h"
#include "kmech/statics.h"
#include "kmech/sweep.h"
#include "kmech/transfer.h"

#include <stdlib.h>
#include <string.h>

void fuzz_refusal(km_status status, const km_error *error) {
  if (status != KM_MODEL && status != KM_DIVERGED && status != KM_USAGE)
    fuzz_fail("a status that no bad model may give");
  if (!error->text[0] || memchr(error->text, '\0', sizeof error->text) == NULL)
    fuzz_fail("a refusal without words");
}

/* Laws that hold at every pose of every mechanism. */
static void check_mobility(const km_model *model, const km_state *state, const km_mobility *mobility) {
  int coordinates = km_model_coordinate_count(model);
  double sum = 0.0;
  for (int c = 0; c < coordinates; ++c) {
    double number = km_mobility_number(state, c);
    if (!(number >= -1e-9 && number <= 1.0 + 1e-9))
      fuzz_fail("a mobility number outside 0 ... 1");
    sum += number;
  }
  if (mobility->mobility < 0 || mobility->mobility > coordinates || mobility->redundant_constraints < 0)
    fuzz_fail("an impossible mobility");
  if (!(sum - mobility->mobility < 1e-6 && sum - mobility->mobility > -1e-6))
    fuzz_fail("the mobility numbers don't add up to the mobility");
}

static void sweep(const km_model *model, const km_mechanism *mechanism, km_state *state, size_t choice) {
  km_sweep_plan plan = km_sweep_plan_default(model);
  km_mobility_sweep result = {0};
  km_error error = {0};
  int coordinates = km_model_coordinate_count(model);
  if (plan.coordinate < 0 && coordinates > 0) {
    plan.coordinate = (int)(choice % (size_t)coordinates);
    plan.from = -1.0;
    plan.to = 1.0;
  }
  plan.steps = 4;
  if (plan.coordinate < 0 || !(plan.from > -1e3 && plan.from < 1e3 && plan.to > -1e3 && plan.to < 1e3))
    return; /* a billion turns take their time */
  for (int c = 0; c < coordinates; ++c)
    if (!(km_state_coordinate(state, c) > -1e4 && km_state_coordinate(state, c) < 1e4))
      return; /* so do angles that have lost the digits which closing needs */
  km_status status = km_mobility_sweep_run(mechanism, state, &plan, &result, &error);
  if (status && status != KM_PARTIAL && status != KM_NO_RESULT)
    fuzz_refusal(status, &error);
  int residual = result.motion.table ? km_table_find(result.motion.table, "residual") : -1;
  for (size_t r = 0; residual >= 0 && r < km_table_rows(result.motion.table); ++r) {
    const double *row = km_table_row(result.motion.table, r);
    for (size_t k = 0; k < km_table_columns(result.motion.table); ++k)
      if (!(row[k] == row[k]))
        fuzz_fail("a row of a sweep has a value that isn't a number");
    if (!(row[residual] < 0.1))
      fuzz_fail("a row of a sweep is open");
  }
  km_mobility_sweep_free(&result);
}

/* Forces of any model balance if all joints are actuators. */
static void balance(const km_model *model, const km_mechanism *mechanism, km_state *state, size_t choice) {
  enum { MOST_LOADS = 16 };
  km_load loads[MOST_LOADS];
  int count = km_model_load_count(model), coordinates = km_model_coordinate_count(model);
  km_forces *forces = NULL;
  km_statics statics;
  km_error error = {0};
  for (int i = 0; i < count && i < MOST_LOADS; ++i)
    loads[i] = km_model_load_at(model, i);
  km_status status = km_forces_create(mechanism, NULL, loads, count < MOST_LOADS ? count : MOST_LOADS, &forces, &error);
  if (status)
    fuzz_refusal(status, &error);
  int one = coordinates ? (int)(choice % (size_t)coordinates) : 0;
  bool alone = coordinates > 0 && choice % 3 == 0;
  status = status ? status : km_statics_create(mechanism, alone ? &one : NULL, 1, KM_AXES_JOINT, &statics, &error);
  if (!status) {
    km_statics_compute(mechanism, state, forces, &statics);
    if (!statics.held && !alone)
      fuzz_fail("all joints together can't hold the mechanism");
    if (statics.degree < 0 || statics.direction_count < 0 || statics.direction_count > coordinates)
      fuzz_fail("an impossible balance");
  } else if (forces) {
    fuzz_refusal(status, &error);
  }
  if (forces)
    km_statics_free(&statics);
  km_forces_free(forces);
}

static void lever(const km_model *model, const km_mechanism *mechanism, km_state *state, size_t choice) {
  int coordinates = km_model_coordinate_count(model);
  km_transfer *made;
  km_advantage a;
  km_error error = {0};
  if (coordinates < 2)
    return;
  km_port from = {.kind = KM_PORT_JOINT, .coordinate = (int)(choice % (size_t)coordinates), .name = "in"};
  km_port to = {.kind = KM_PORT_JOINT, .coordinate = (int)(choice / 5 % (size_t)coordinates), .name = "out"};
  km_status status = km_transfer_create(mechanism, &from, &to, &made, &error);
  if (status) {
    fuzz_refusal(status, &error);
    return;
  }
  km_transfer_compute(mechanism, state, made, &a);
  bool number = a.value == a.value;
  if (number != (a.state != KM_ADVANTAGE_UNDEFINED))
    fuzz_fail("an advantage and its state don't agree");
  km_transfer_free(made);
}

/* Long runs end here: stiff ones take as many steps as they like. */
static bool few_steps(void *context, double done) {
  enum { MOST_STEPS = 60 };
  int *steps = context;
  (void)done;
  return ++*steps < MOST_STEPS;
}

/* Some steps of the motion, and the equations about where they led. */
static void move(const km_model *model, const km_mechanism *mechanism, km_state *state, size_t choice) {
  km_forces *forces = NULL;
  km_dynamics *dynamics = NULL;
  km_simulation *run = NULL;
  km_linear linear = {0};
  km_error error = {0};
  int steps = 0;
  km_simulation_def def = km_simulation_default();
  def.integrator = choice % 5 == 0 ? KM_INTEGRATOR_BDF : choice % 5 == 1 ? KM_INTEGRATOR_FIXED : KM_INTEGRATOR_ADAMS;
  def.stabilisation = choice % 3 == 0 ? KM_STABILISE_BAUMGARTE : KM_STABILISE_PROJECT;
  def.max_step = choice % 5 == 1 ? 1e-3 : 0.0;
  km_status status = km_forces_create(mechanism, NULL, NULL, 0, &forces, &error);
  if (!status)
    status = km_dynamics_create(mechanism, forces, &dynamics, &error);
  if (!status)
    status = km_simulation_create(dynamics, state, &def, &run, &error);
  if (!status)
    status = km_simulation_advance(run, km_simulation_figures_of(run).time + 1.0, few_steps, &steps, &error);
  for (int c = 0; c < km_model_coordinate_count(model) && (!status || status == KM_CANCELLED); ++c)
    if (!(km_state_coordinate(state, c) == km_state_coordinate(state, c)))
      fuzz_fail("a motion leads to a coordinate that isn't a number");
  if (!status || status == KM_CANCELLED)
    status = km_linearise(dynamics, state, &linear, &error);
  if (status)
    fuzz_refusal(status, &error);
  km_linear_free(&linear);
  km_simulation_free(run);
  km_dynamics_free(dynamics);
  km_forces_free(forces);
}

static bool assemble(const km_model *model, size_t choice) {
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_assembly evidence;
  km_mobility mobility;
  km_error error = {0};
  int coordinates = km_model_coordinate_count(model);
  km_hold hold = {coordinates ? (int)(choice / 7 % (size_t)coordinates) : 0, 0.0};
  bool held = coordinates > 0 && choice % 7 == 0;
  km_status status = km_mechanism_compile(model, &hold, held, &mechanism, &error);
  if (!status)
    status = km_state_create(mechanism, &state, &error);
  if (!status)
    status = km_assemble(mechanism, state, &evidence, &error);
  if (status) {
    fuzz_refusal(status, &error);
  } else {
    if (!(evidence.residual < 0.1))
      fuzz_fail("loops that are said to be closed have a large residual");
    km_poses_compute(mechanism, state);
    fuzz_closed(model, mechanism, state, evidence.residual);
    km_mobility_compute(mechanism, state, &mobility);
    check_mobility(model, state, &mobility);
    balance(model, mechanism, state, choice);
    lever(model, mechanism, state, choice);
    sweep(model, mechanism, state, choice);
    if (choice % 4 == 0)
      move(model, mechanism, state, choice / 4);
  }
  km_state_free(state);
  km_mechanism_free(mechanism);
  return !status;
}

char *fuzz_exact(const void *bytes, size_t size) {
  char *copy = malloc(size ? size : 1);
  if (!copy)
    exit(2);
  if (size)
    memcpy(copy, bytes, size);
  return copy;
}

int fuzz_model(const void *bytes, size_t size, size_t choice) {
  km_model *model = NULL;
  km_error error = {0};
  km_messages *messages = km_messages_create();
  char *exact = fuzz_exact(bytes, size);
  int depth = 0;
  if (!messages)
    exit(2);
  km_status status = km_model_read(exact, size, messages, &model, &error);
  if (status) {
    fuzz_refusal(status, &error);
    if (model || km_messages_errors(messages) == 0)
      fuzz_fail("a refusal leaves a model, or no message");
  } else {
    depth = 1 + assemble(model, choice);
  }
  km_model_free(model);
  km_messages_free(messages);
  free(exact);
  return depth;
}
