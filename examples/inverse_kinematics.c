/* Moves an arm's effector by 0.05 length units upwards: the nearest pose, and how many branches reach it. */
#include <kmech/kmech.h>
#include <stdio.h>

int main(int argc, char **argv) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_arm *arm = NULL;
  km_ik_solutions branches = {0};
  km_frame_pose pose;
  km_error error;
  int frame;
  double here[32], q[32];
  if (argc != 4) {
    fprintf(stderr, "usage: inverse_kinematics ARM.json BODY FRAME\n");
    return 2;
  }
  const char *const names[2] = {argv[2], argv[3]};
  km_status status = km_model_read_file(argv[1], NULL, &model, &error);
  if (!status)
    status = km_model_find_frame(model, names, 2, &frame, &error);
  if (!status)
    status = km_mechanism_compile(model, NULL, 0, &mechanism, &error);
  if (!status)
    status = km_state_create(mechanism, &state, &error);
  if (!status)
    status = km_arm_create(mechanism, state, frame, KM_TASK_POSE, &arm, &error);
  for (int k = 0; k < km_arm_coordinates(arm); ++k)
    here[k] = km_state_coordinate(state, km_arm_coordinate(arm, k));
  if (!status)
    status = km_arm_place(arm, here, &pose, &error);
  pose.p[2] += 0.05;
  if (!status)
    status = km_arm_solve(arm, &pose, here, 1, NULL, NULL, q, &error);
  for (int k = 0; k < km_arm_coordinates(arm) && !status; ++k)
    printf("%-4s %9.5f -> %9.5f\n", km_model_coordinate_label(model, km_arm_coordinate(arm, k)), here[k], q[k]);
  if (!status)
    status = km_ik_solutions_find(arm, &pose, 1, NULL, NULL, &branches, &error);
  if (!status)
    printf("%d branches, %d with poses within the limits\n", branches.count, branches.within);
  if (status)
    fprintf(stderr, "%s\n", error.text);
  km_ik_solutions_free(&branches);
  km_arm_free(arm);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return status ? 1 : 0;
}
