/* Drives a joint upwards until it stops, and prints where and why. */
#include <kmech/kmech.h>
#include <stdio.h>

static void tell(const km_model *model, int joint, const km_motion_end *reach) {
  const char *label = km_model_coordinate_label(model, joint), *unit = km_model_coordinate_unit(model, joint);
  switch (reach->stop) {
  case KM_STOP_TOGGLE:
    printf("%s toggles at %.9g %s\n", label, reach->position, unit);
    break;
  case KM_STOP_LIMIT:
    printf("%s stops at %.9g %s: %s is at its limit\n", label, reach->position, unit,
           km_model_coordinate_label(model, reach->coordinate));
    break;
  default:
    printf("%s goes on past %.9g %s\n", label, reach->position, unit);
  }
}

int main(int argc, char **argv) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_driver_motion *drive = NULL;
  km_error error;
  int joint;
  if (argc != 3) {
    fprintf(stderr, "usage: toggle MODEL.json JOINT\n");
    return 2;
  }
  km_status status = km_model_read_file(argv[1], NULL, &model, &error);
  if (!status)
    status = km_model_find_coordinate(model, argv[2], &joint, &error);
  if (!status)
    status = km_mechanism_compile(model, NULL, 0, &mechanism, &error);
  if (!status)
    status = km_state_create(mechanism, &state, &error);
  if (!status)
    status = km_assemble(mechanism, state, NULL, &error);
  if (!status)
    status = km_driver_motion_create(mechanism, state, joint, false, &drive, &error);
  if (!status) {
    km_motion_end reach = km_driver_motion_move_to(drive, km_state_coordinate(state, joint) + 1000.0);
    tell(model, joint, &reach);
  } else {
    fprintf(stderr, "%s\n", error.text);
  }
  km_driver_motion_free(drive);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return status ? 1 : 0;
}
