/* Public functions of effector kinematics in the model's units: pose, Jacobian, inverse kinematics. */
#include "arm/arm_arguments.h"
#include "arm/ik/ik_branches.h"

static km_status check(const km_arm *a, const double *q, const void *out, km_error *error) {
  km_status status = km_check_given(a && q && out, "arm, values or place for the result", error);
  return status ? status : km_check_arm_values(a, q, error);
}

/* Creates a workspace and updates it for q[n] in the model's units; own[n] are the values in the arm's units. */
static km_status create_space_at(const km_arm *a, const double *q, km_arm_space *space, double *own, km_error *error) {
  if (!km_arm_space_create(a, space))
    return km_fail(error, KM_MEMORY, "out of memory for an arm");
  for (int k = 0; k < a->n; ++k)
    own[k] = km_arm_from_units(a, k, q[k]);
  km_arm_update(a, space, own);
  return KM_OK;
}

km_status km_arm_place(const km_arm *a, const double *q, km_frame_pose *out, km_error *error) {
  km_arm_space space;
  double own[KM_ARM_MAX_JOINTS];
  km_status status = check(a, q, out, error);
  if (!status)
    status = create_space_at(a, q, &space, own, error);
  if (status)
    return status;
  km_pose pose = km_arm_to_model(a, &space.pose);
  km_arm_space_free(&space);
  km_pose_write(&pose, out);
  return KM_OK;
}

km_status km_arm_jacobian(const km_arm *a, const double *q, double *J, km_error *error) {
  km_arm_space space;
  double own[KM_ARM_MAX_JOINTS];
  km_status status = check(a, q, J, error);
  if (!status)
    status = create_space_at(a, q, &space, own, error);
  if (status)
    return status;
  km_arm_all_columns(a, &space, own, J);
  for (int k = 0; k < a->n; ++k)
    for (int r = 0; r < a->task_rows; ++r)
      J[k * a->task_rows + r] *= (r < 3 ? a->length : 1.0) / a->unit[k];
  km_arm_space_free(&space);
  return KM_OK;
}

km_status km_arm_solve(const km_arm *a, const km_frame_pose *pose, const double *near, unsigned long seed,
                       km_progress progress, void *context, double *q, km_error *error) {
  km_status status = check(a, near, q, error);
  if (!status)
    status = km_check_given(pose != NULL, "pose", error);
  if (!status)
    status = km_check_pose(pose, error);
  if (status)
    return status;
  double own[KM_ARM_MAX_JOINTS], found[KM_ARM_MAX_JOINTS];
  km_pose target = km_arm_pose_of(a, pose);
  for (int k = 0; k < a->n; ++k)
    own[k] = km_arm_from_units(a, k, near[k]);
  status = km_arm_nearest(a, &target, own, seed, progress, context, found, error);
  for (int k = 0; k < a->n && !status; ++k)
    q[k] = km_arm_to_units(a, k, found[k]);
  return status;
}
