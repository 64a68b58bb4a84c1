/* Mechanisms from models: where no link has a length, the assembled pose gives the characteristic length. */
#include "kinematics/poses.h"

#include "base/check.h"
#include "topology/compile.h"

/* The greatest distance between two joints in the assembled pose; 0 if that is rounding, or the loops don't close. */
static double joints_apart(const km_mechanism *m) {
  km_state *s = NULL;
  double furthest = 0.0;
  if (!km_state_create(m, &s, NULL) && !km_assemble(m, s, NULL, NULL)) {
    km_poses_update(m, s);
    for (int j = 0; j < m->model->joint_count; ++j)
      for (int k = 0; k < j; ++k)
        furthest = fmax(furthest, km_square_apart(km_joint_pose(m, s, j).p, km_joint_pose(m, s, k).p, m->grain));
  }
  km_state_free(s);
  return sqrt(furthest);
}

km_status km_mechanism_compile(const km_model *model, const km_hold *holds, int hold_count, km_mechanism **out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_given(model != NULL, "model", error);
  if (fits)
    return fits;
  km_compiling how = {.holds = holds, .hold_count = hold_count};
  km_status status = km_mechanism_compile_as(model, &how, out, error);
  if (status || (*out)->length_source != KM_LENGTH_UNIT)
    return status;
  how.length = joints_apart(*out);
  how.length_source = KM_LENGTH_JOINTS;
  if (how.length == 0.0)
    return KM_OK;
  km_mechanism_free(*out);
  return km_mechanism_compile_as(model, &how, out, error);
}
