/* Terms of tolerances and plays. */
#include "allowance/joint_fits.h"

#include <gsl/gsl_cdf.h>
#include <math.h>

enum { ACROSS = 0, ALONG = 2, AT_CHILD = 3, AT_PARENT = 6 }; /* rows of km_self_stress.wrench */

bool km_model_states_clearance(const km_model *model) {
  for (int j = 0; j < model->joint_count; ++j)
    if (model->joints[j].fit.has_clearance)
      return true;
  return false;
}

double km_statistical_factor(int count) {
  /* the share of a normal distribution within three standard deviations */
  return sqrt(gsl_cdf_chisq_Pinv(erf(3.0 / M_SQRT2), count)) / 3.0;
}

static void add_term(km_support_term *terms, int *count, int first, int rows, int owner, double size) {
  if (size > 0.0)
    terms[(*count)++] = (km_support_term){size, first, rows, owner};
}

bool km_fit_terms_create(const km_mechanism *m, const km_self_stress *stress, const km_fit_defaults *defaults,
                         km_arena *arena, km_support_terms *out) {
  const size_t joints = (size_t)stress->joint_count;
  const double radian = m->model->units.angle->si;
  *out = (km_support_terms){.rows = stress->joint_count * KM_STRESS_ROWS,
                            .dimension = stress->count,
                            .W = stress->wrench,
                            .length = KM_ARENA_NEW(arena, double, KM_STRESS_ROWS *joints + 1),
                            .error = KM_ARENA_NEW(arena, km_support_term, 4 * joints + 1),
                            .play = KM_ARENA_NEW(arena, km_support_term, 3 * joints + 1)};
  if (arena->failed)
    return false;
  for (int r = 0; r < out->rows; ++r)
    for (int i = 0; i < out->dimension; ++i)
      out->length[r] = hypot(out->length[r], out->W[r * out->dimension + i]);
  for (int i = 0; i < stress->joint_count; ++i) {
    const int joint = stress->joint[i], first = i * KM_STRESS_ROWS;
    const km_joint_fit *fit = &m->model->joints[joint].fit;
    const double position = fit->has_tolerance ? fit->position : defaults->position,
                 direction = fit->has_tolerance ? fit->direction * radian : defaults->direction;
    for (int end = 0; end < 2; ++end)
      add_term(out->error, &out->error_count, first + ACROSS, 3, joint, position);
    add_term(out->error, &out->error_count, first + AT_CHILD, 3, joint, direction);
    add_term(out->error, &out->error_count, first + AT_PARENT, 3, joint, direction);
    const bool has_axis = km_joint_axis(m->model->joints[joint].type) >= 0; /* else its play is radial alone */
    add_term(out->play, &out->play_count, first + ACROSS, has_axis ? 2 : 3, joint,
             fit->has_clearance ? fit->radial : defaults->play);
    if (has_axis)
      add_term(out->play, &out->play_count, first + ALONG, 1, joint, fit->has_clearance ? fit->axial : defaults->play);
    add_term(out->play, &out->play_count, first + AT_CHILD, 3, joint,
             fit->has_clearance ? fit->angular * radian : defaults->angle);
  }
  return true;
}
