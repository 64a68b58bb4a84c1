/* Compiles a mechanism with its characteristic length L (docs/theory.md 1.4).
 *
 * L is stated, else the longest link. If no link has a length, L is the greatest distance of two joints in the
 * assembled configuration, found by assembling a mechanism with L = 1 first. */
#include "kinematics/body_poses.h"

#include "base/arguments.h"
#include "base/memory.h"
#include "topology/compile.h"

#include <stdlib.h>

/* Position of a joint and its distance from the mean of all positions. */
typedef struct joint_position {
  km_vec3 p;
  double radius;
} joint_position;

static int compare_radii(const void *a, const void *b) {
  double x = ((const joint_position *)a)->radius, y = ((const joint_position *)b)->radius;
  return (x < y) - (x > y);
}

/* Greatest distance between two positions. They are sorted by radius, since two positions are no further apart than the
 * sum of their radii. */
static double greatest_distance(joint_position *positions, int count, double rounding_length) {
  const double slack = 1.0 + 1e-9; /* rounding of the radii */
  double greatest = 0.0;
  qsort(positions, (size_t)count, sizeof *positions, compare_radii);
  for (int j = 0; j < count; ++j)
    for (int k = 0; k < j; ++k) {
      if ((positions[j].radius + positions[k].radius) * slack <= fmax(greatest, rounding_length))
        break;
      greatest = fmax(greatest, sqrt(km_squared_distance(positions[j].p, positions[k].p, rounding_length)));
    }
  return greatest;
}

/* Greatest distance between two joints in the assembled configuration; 0 if that is rounding or the loops do not
 * close. */
static double greatest_joint_distance(const km_mechanism *m) {
  km_state *s = NULL;
  const int count = m->model->joint_count;
  double greatest = 0.0;
  joint_position *positions = KM_NEW(joint_position, (size_t)count + 1);
  if (positions && !km_state_create(m, &s, NULL) && !km_assemble(m, s, NULL, NULL)) {
    km_vec3 mean = {0, 0, 0};
    km_poses_compute(m, s);
    for (int j = 0; j < count; ++j) {
      positions[j].p = km_joint_pose(m, s, j).p;
      mean = km_vec3_add(mean, km_vec3_scale(1.0 / count, positions[j].p));
    }
    for (int j = 0; j < count; ++j)
      positions[j].radius = km_vec3_norm(km_vec3_sub(positions[j].p, mean));
    greatest = greatest_distance(positions, count, m->position_rounding);
  }
  km_state_free(s);
  km_free(positions);
  return greatest;
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
