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

/* Projection of D x onto the `count` orthonormal vectors of Y, into sum[columns]. */
static void project_onto_basis(const km_substructure *sub, const double *weight, const double *Y, int count,
                               const double *x, double *sum) {
  memset(sum, 0, (size_t)sub->columns * sizeof *sum);
  for (int k = 0; k < count; ++k) {
    const double *y = Y + (size_t)k * (size_t)sub->columns;
    double dot = 0.0;
    for (int j = 0; j < sub->columns; ++j)
      dot += y[j] * weight[j] * x[j];
    for (int j = 0; j < sub->columns; ++j)
      sum[j] += dot * y[j];
  }
}

/* Minimum-norm step by the row equations. False if a basis is cheaper or they fail. */
static bool remove_null_space_by_rows(const km_mechanism *m, km_state *s, int index, int count, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  return km_uses_row_equations(p, count) &&
         km_partition_remove_null_space(p, km_state_jacobian(s, sub), m->column_weight + sub->column_start, count, x,
                                        s->projection);
}

/* D x minus its projection onto the null space Z, or its projection onto the row space R: whichever has fewer
 * vectors. */
void km_minimum_norm_step(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  const double *weight = m->column_weight + sub->column_start;
  int count = km_count_free_motions(p, driver);
  if (count <= 0)
    return;
  bool uses_row_space = p->rank < count, is_ok = remove_null_space_by_rows(m, s, index, count, x);
  if (is_ok) {
    s->basis[index].count = 0;
    return;
  }
  const double *Y = uses_row_space ? km_state_row_space(m, s, index, count) : km_state_null_space(m, s, index, count);
  if (!Y)
    return;
  project_onto_basis(sub, weight, Y, uses_row_space ? p->rank : count, x, s->projection);
  bool keeps_driver = driver >= 0 && !p->forced_dependent; /* the null vectors have no entry at the driver, and R omits
                                                            * its column */
  double driver_value = keeps_driver ? x[driver] : 0.0;
  for (int j = 0; j < sub->columns; ++j)
    x[j] = uses_row_space ? s->projection[j] / weight[j] : x[j] - s->projection[j] / weight[j];
  if (keeps_driver)
    x[driver] = driver_value;
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
  const km_partition *p = &s->partition[index];
  if (km_partition_avoids_basis(p) && project_driver(m, s, index, driver, t))
    return;
  km_partition_null_vector(p, driver, t);
  km_minimum_norm_step(m, s, index, driver, t);
}
