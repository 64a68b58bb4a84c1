/* Minimum-norm steps and rates in the metric D (docs/theory.md 3.5).
 *
 *   step  : x <- x − D⁻¹ Z Zᵀ D x,  Z = orthonormal null space of J D⁻¹
 *   rates : t_driver = 1,  J t = 0,  |D t| minimal
 *
 * The projection uses the null space, the row space, or equations in the rows, whichever is smallest. */
#include "kinematics/minimum_norm_step.h"
#include "kinematics/loop_closing.h"

#include <string.h>

/* (D a)·(D b): inner product of scaled steps in the metric D. */
double km_step_dot(const km_mechanism *m, const km_substructure *sub, const double *a, const double *b) {
  const double *weight = m->column_weight + sub->column_start;
  double sum = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    sum += weight[k] * a[k] * weight[k] * b[k];
  return sum;
}

double km_step_length(const km_mechanism *m, const km_substructure *sub, const double *x) {
  return sqrt(km_step_dot(m, sub, x, x));
}

void km_minimum_norm_step(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  km_factor *p = s->factor[index];
  km_factor_remove_null_space(p, km_state_jacobian(s, &m->substructures[index]), km_count_free_motions(p, driver), x);
}

/* Minimum-norm rates as the null-space projection of the driver's unit vector over its driver entry, t = P u / (P
 * u)_driver. The null vector of the driver can be long and cancel; this avoids it. */
static bool project_driver(const km_mechanism *m, km_state *s, int index, int driver, double *t) {
  const km_substructure *sub = &m->substructures[index];
  memset(t, 0, (size_t)sub->columns * sizeof *t);
  t[driver] = 1.0;
  km_minimum_norm_step(m, s, index, KM_NO_DRIVER, t);
  double share = 1.0 - t[driver];
  for (int k = 0; k < sub->columns; ++k)
    t[k] = k == driver ? 1.0 : -t[k] / share;
  return share > 0.0;
}

/* Rates t with t_driver = 1, J t = 0, |D t| minimal. */
void km_minimum_norm_rates(const km_mechanism *m, km_state *s, int index, int driver, double *t) {
  const km_factor *p = s->factor[index];
  if (km_factor_avoids_basis(p) && project_driver(m, s, index, driver, t))
    return;
  km_factor_null_vector(p, driver, t);
  km_minimum_norm_step(m, s, index, driver, t);
}
