/* Mechanical advantage of a four-bar's crank over its rocker, and how fast the coupler's tip moves with the crank. */
#include "fourbar.h"

static void tell(const km_mechanism *mechanism, km_state *state, km_transfer *lever, int tip) {
  km_mobility mobility;
  km_advantage advantage;
  double twist[6], rate;
  km_poses_compute(mechanism, state);
  if (km_mobility_compute(mechanism, state, &mobility) || km_transfer_compute(mechanism, state, lever, &advantage))
    return;
  rate = advantage.input_rate;
  printf("mobility %d, mechanical advantage %.6f (%s)\n", mobility.mobility, advantage.value,
         km_advantage_state_name(advantage.state));
  if (km_frame_twist(mechanism, state, tip, km_transfer_rates(lever), twist, NULL) == KM_OK)
    printf("the coupler's tip moves by (%.6f, %.6f) per radian of the crank\n", twist[0] / rate, twist[1] / rate);
}

int main(void) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_transfer *lever = NULL;
  km_error error;
  int tip;
  const char *const names[2] = {"coupler", "tip"};
  const km_port input = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "A"};
  const km_port output = {.kind = KM_PORT_JOINT, .coordinate = 3, .name = "D"};
  km_status status = fourbar_open(3.0, &model, &error);
  if (!status)
    status = km_model_find_frame(model, names, 2, &tip, &error);
  if (!status)
    status = km_mechanism_compile(model, NULL, 0, &mechanism, &error);
  if (!status)
    status = km_state_create(mechanism, &state, &error);
  if (!status)
    status = km_assemble(mechanism, state, NULL, &error);
  if (!status)
    status = km_transfer_create(mechanism, &input, &output, &lever, &error);
  if (status)
    fprintf(stderr, "%s\n", error.text);
  else
    tell(mechanism, state, lever, tip);
  km_transfer_free(lever);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return status ? 1 : 0;
}
