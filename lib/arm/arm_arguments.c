/* Argument checks of the public functions of arms. */
#include "arm/arm_arguments.h"

#include "model/path_study/method_settings.h"

km_status km_check_arm_values(const km_arm *a, const double *q, km_error *error) {
  for (int k = 0; k < a->n; ++k)
    if (!isfinite(q[k]))
      return km_fail(error, KM_USAGE, "%g for %s; expected a finite value", q[k], km_arm_label(a, k));
  return KM_OK;
}

km_status km_check_pose(const km_frame_pose *pose, km_error *error) {
  const double *R = pose->R;
  double misfit = 0.0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double dot = R[i] * R[j] + R[3 + i] * R[3 + j] + R[6 + i] * R[6 + j];
      misfit += fabs(dot - (i == j ? 1.0 : 0.0));
    }
    if (!isfinite(pose->p[i]))
      return km_fail(error, KM_USAGE, "a pose at %g; expected a finite place", pose->p[i]);
  }
  double determinant =
      R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6]);
  return misfit <= 1e-6 && determinant > 0.0
             ? KM_OK
             : km_fail(error, KM_USAGE, "the pose's matrix is no rotation; expected R^T R = 1 and det R = 1");
}

km_status km_check_method(const km_arm *a, const km_method *m, km_error *error) {
  km_error fault;
  const char *key = NULL;
  km_status status = km_check_index((int)m->kind, KM_METHODS, "method", error);
  if (!status && km_method_check(m, &key, &fault))
    status = km_fail(error, KM_USAGE, "%s: %s", key, fault.text);
  if (!status && (m->joint_count < 0 || m->joint_count > KM_METHOD_JOINTS))
    status = km_fail(error, KM_USAGE, "joint count is %d; expected 0 to %d", m->joint_count, KM_METHOD_JOINTS);
  for (int i = 0; i < m->joint_count && !status; ++i)
    status = km_check_index(m->joints[i], a->n, "joint of the arm", error);
  return status;
}
