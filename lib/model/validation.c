/* Validation of a complete model. */
#include "model/validation.h"

#include "base/number/union_find.h"
#include "model/geometry/mass_properties.h"

#include <float.h>
#include <string.h>

/* Marks the bodies connected to the inertial frame. */
void km_model_check_ties(km_model *model, km_messages *messages) {
  int *parent = model->arena.failed ? NULL : KM_NEW(int, (size_t)model->body_count);
  if (!parent) {
    model->arena.failed = true;
    return;
  }
  km_sets_reset(parent, model->body_count);
  for (int j = 0; j < model->joint_count; ++j) {
    int a = km_set_root(parent, km_joint_body(model, j, 0));
    int b = km_set_root(parent, km_joint_body(model, j, 1));
    parent[a > b ? a : b] = a < b ? a : b;
  }
  for (int b = 1; b < model->body_count; ++b)
    if (km_set_root(parent, b) != 0)
      km_messages_add(messages, KM_ERROR,
                      "%s: body \"%.80s\" is tied to the inertial frame by no chain of joints; expected at least "
                      "one (a joint of type float ties a free body to [\"fixed\"])",
                      model->bodies[b].where, model->bodies[b].name);
  km_free(parent);
}

/* Size of the model: the largest distance of a frame or centre of mass from its body's origin. */
static double reach(const km_model *model) {
  double far = 0.0;
  for (int f = 0; f < model->frame_count; ++f)
    far = fmax(far, km_vec3_norm(model->frames[f].pose.p));
  for (int b = 1; b < model->body_count; ++b)
    far = fmax(far, km_vec3_norm(model->bodies[b].center_of_mass));
  return far;
}

/* Tolerance of a negative principal moment: rounding of the entries, or of cancelled moments m·l² about a distant
 * point; a light body may have been separated from a heavy one. */
static double moment_rounding(const km_model_body *body, double heaviest, double far) {
  double size = 0.0;
  for (int k = 0; k < 6; ++k)
    size = fmax(size, fabs(body->inertia[k]));
  return 1e-9 * size + 1e-12 * fmax(body->mass, 1e-3 * heaviest) * far * far;
}

/* Triangle inequality of principal moments in ascending order: the largest is at most the sum of the others. A
 * planar model may state one moment only; rounded digits of a flat body are tolerated. */
static bool no_body_has(const double moments[3]) {
  static const double rounded = 1e-3;
  return moments[1] > 1e-9 * moments[2] && moments[0] + moments[1] < (1.0 - rounded) * moments[2];
}

void km_model_check_inertias(const km_model *model, km_messages *messages) {
  double heaviest = 0.0, far = reach(model), moments[3];
  for (int b = 1; b < model->body_count; ++b)
    heaviest = fmax(heaviest, model->bodies[b].mass);
  for (int b = 1; b < model->body_count; ++b) {
    const km_model_body *body = &model->bodies[b];
    km_principal_moments(body->inertia, moments);
    if (moments[0] < -moment_rounding(body, heaviest, far))
      km_messages_add(messages, KM_ERROR,
                      "%s.moment_of_inertia: a principal moment is negative: %.4g, beside %.4g and %.4g; expected "
                      "moments of at least 0",
                      body->where, moments[0], moments[1], moments[2]);
    else if (no_body_has(moments))
      km_messages_add(
          messages, KM_NOTE,
          "%s.moment_of_inertia: no body has such moments of inertia, as the largest is more than the sum of "
          "the others: %.4g, %.4g and %.4g",
          body->where, moments[0], moments[1], moments[2]);
  }
}

km_status km_model_rotation(const double rows[9], km_rotation *out, double *misfit, km_error *error) {
  const double *m = rows;
  km_rotation R = {{{m[0], m[3], m[6]}, {m[1], m[4], m[7]}, {m[2], m[5], m[8]}}};
  *out = km_rotation_identity();
  *misfit = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double entry = fabs(km_vec3_dot(R.axis[i], R.axis[j]) - (i == j));
      if (!(entry <= *misfit))
        *misfit = entry;
    }
  double determinant = km_vec3_dot(R.axis[0], km_vec3_cross(R.axis[1], R.axis[2]));
  if (determinant < 0.0)
    return km_fail(error, KM_MODEL, "a mirrored frame (determinant %.3g); expected a right-handed rotation",
                   determinant);
  bool near = *misfit <= 10.0 * KM_ROTATION_ROUNDING; /* Frobenius error is below 3.5 times this bound if no entry is
                                                       * further off */
  km_rotation nearest = near ? km_rotation_nearest(&R) : R;
  double distance = near ? km_rotation_distance(&R, &nearest) : *misfit;
  if (!near || !(distance <= KM_ROTATION_ROUNDING))
    return km_fail(error, KM_MODEL, "not a rotation: %s by %.3g; expected at most %g",
                   near ? "an entry differs from the nearest rotation's" : "an entry of RᵀR differs from the identity",
                   distance, KM_ROTATION_ROUNDING);
  /* A matrix within four rounding errors is kept as it is, so that writing and reading doesn't change it. */
  *out = *misfit <= 4.0 * DBL_EPSILON ? R : nearest;
  return KM_OK;
}
