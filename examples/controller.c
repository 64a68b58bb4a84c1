/* A controller in C: a motor on the crank of a four-bar keeps 2 rad/s by a force function of its own. */
#include "fourbar.h"

/* torque = gain (wanted − rate of the crank) */
typedef struct controller {
  double wanted, gain;
} controller;

static bool drive(void *context, const km_motion_sample *sample, double *joint_forces, double (*wrenches)[6]) {
  const controller *c = context;
  (void)wrenches;
  joint_forces[0] = c->gain * (c->wanted - sample->rate[0]);
  return true;
}

static km_status give_masses(km_model *model, km_error *error) {
  const double center[3] = {0.5, 0.0, 0.0}, inertia[6] = {0.1, 0.1, 0.1, 0.0, 0.0, 0.0};
  km_status status = KM_OK;
  for (int body = 1; body <= 3 && !status; ++body)
    status = km_model_set_mass(model, body, 1.0, center, inertia, error);
  return status;
}

int main(void) {
  controller speed = {.wanted = 2.0, .gain = 500.0};
  const km_user_forces user = {.compute = drive, .context = &speed};
  const double no_gravity[3] = {0.0, 0.0, 0.0};
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_forces *forces = NULL;
  km_history motion = {0};
  km_error error;
  km_status status = fourbar_open(3.0, &model, &error);
  status = status ? status : give_masses(model, &error);
  status = status ? status : km_mechanism_compile(model, NULL, 0, &mechanism, &error);
  status = status ? status : km_state_create(mechanism, &state, &error);
  status = status ? status : km_assemble(mechanism, state, NULL, &error);
  status = status ? status : km_forces_create(mechanism, no_gravity, NULL, 0, &forces, &error);
  status = status ? status : km_forces_set_user(forces, &user, &error);
  km_history_def def = km_history_default(model);
  def.until = 3.0;
  status = status ? status : km_history_run(mechanism, forces, state, &def, &motion, &error);
  if (status)
    fprintf(stderr, "%s\n", error.text);
  else
    printf("after 3 s the crank turns at %.3f rad/s\n",
           km_table_row(motion.table, km_table_rows(motion.table) - 1)[km_table_find(motion.table, "v.A")]);
  km_history_free(&motion);
  km_forces_free(forces);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return status ? 1 : 0;
}
