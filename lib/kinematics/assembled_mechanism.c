/* Compiles a mechanism with its characteristic length L (docs/theory.md 1.4).
 *
 * L is stated, else the longest link. If no link has a length, L is the greatest distance of two joints in the
 * assembled configuration, found by assembling a mechanism with L = 1 first. */
#include "kinematics/body_poses.h"

#include "base/arguments.h"
#include "base/memory.h"
#include "topology/compile.h"

/* Greatest distance between two joints in the assembled configuration; 0 if that is rounding or the loops do not
 * close. O(joints²). */
static double greatest_joint_distance(const km_mechanism *m) {
  km_state *s = NULL;
  const int count = m->model->joint_count;
  double square = 0.0;
  km_vec3 *position = KM_NEW(km_vec3, (size_t)count + 1);
  if (position && !km_state_create(m, &s, NULL) && !km_assemble(m, s, NULL, NULL)) {
    km_poses_compute(m, s);
    for (int j = 0; j < count; ++j) {
      position[j] = km_joint_pose(m, s, j).p;
      for (int k = 0; k < j; ++k)
        square = fmax(square, km_squared_distance(position[j], position[k], m->position_rounding));
    }
  }
  km_state_free(s);
  km_free(position);
  return sqrt(square);
}

/* Compiles the model; a second time if its characteristic length needs the assembled configuration. */
km_status km_mechanism_compile(const km_model *model, const km_hold *holds, int hold_count, km_mechanism **out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_given(model != NULL, "model", error);
  if (fits)
    return fits;
  km_compiling options = {.holds = holds, .hold_count = hold_count};
  km_status status = km_mechanism_compile_as(model, &options, out, error);
  if (status || (*out)->length_source != KM_LENGTH_UNIT)
    return status;
  options.length = greatest_joint_distance(*out);
  options.length_source = KM_LENGTH_JOINTS;
  if (options.length == 0.0)
    return KM_OK;
  km_mechanism_free(*out);
  return km_mechanism_compile_as(model, &options, out, error);
}
