/* The ranges of what comes in for arms. */
#include "arm/check.h"

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

typedef struct range {
  const char *name;
  double value, low, high;
} range;

km_status km_check_method(const km_arm *a, const km_method *m, km_error *error) {
  km_status status = km_check_index((int)m->kind, KM_METHODS, "method", error);
  const range ranges[] = {
      {"branches", m->branches, 1, 1001},
      {"levels", m->levels, 1, 20},
      {"angle", m->angle, 1e-5, 1.56},
      {"stride", m->stride, 0, 1e6},
      {"damping", m->damping, 0, 10},
      {"below", m->below, 0, 10},
      {"gain", m->gain, -1e6, 1e6},
      {"spacing", m->spacing, 0, 10},
      {"knots", m->knots, 2, 64},
      {"evaluations", m->evaluations, 1, 1e6},
      {"joint count", m->joint_count, 0, KM_METHOD_JOINTS},
  };
  for (size_t i = 0; i < sizeof ranges / sizeof *ranges && !status; ++i)
    if (!(ranges[i].value >= ranges[i].low && ranges[i].value <= ranges[i].high))
      status = km_fail(error, KM_USAGE, "%s is %g; expected %g to %g", ranges[i].name, ranges[i].value, ranges[i].low,
                       ranges[i].high);
  if (!status && (m->branches - 1) / 2 * m->angle >= 1.56 && m->kind == KM_LOOKAHEAD)
    status = km_fail(error, KM_USAGE, "the outermost of %d branches turns by %g rad; expected less than a right angle",
                     m->branches, (m->branches - 1) / 2 * m->angle);
  for (int i = 0; i < m->joint_count && !status; ++i)
    status = km_check_index(m->joints[i], a->n, "joint of the arm", error);
  return status;
}
