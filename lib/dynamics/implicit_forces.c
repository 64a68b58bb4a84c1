/* Forces that depend on accelerations (docs/theory.md 11.8).
 *
 *   q̈ = q̈(F) is linear, so that what the modules measure is x(F) = x(F_0) + C (F − F_0)
 *   F_k = law_k(x_k): Newton's method on r = law(x(F)) − F,  r' = diag(law') C − 1;   C from one solution a module
 *
 * The laws are evaluated on solutions of the equations of motion, with a derivative by differences. */
#include "base/number/vectors.h"
#include "dynamics/dynamics.h"

#include "base/extrema.h"

#include <gsl/gsl_linalg.h>
#include <math.h>
#include <string.h>

enum { MAX_ITERATIONS = 30 };
static const double converged = 1e-13; /* residual over the largest force */

/* Residuals law(x(F)) − F of the present solution, with the implicit forces F. */
static void read_residuals(const km_dynamics *d, const km_state *s, double *residual) {
  const km_moving_forces *moving = d->forces->moving;
  km_implicit_forces_compute(d->mechanism, s, d->forces, residual);
  for (int k = 0; k < moving->implicit_count; ++k)
    residual[k] -= moving->implicit_force[k];
}

/* Residuals at the implicit forces F; they act afterwards. */
static km_dynamics_outcome compute_residuals(km_dynamics *d, km_state *s, const double *force, double *residual) {
  km_moving_forces *moving = d->forces->moving;
  memcpy(moving->implicit_force, force, (size_t)moving->implicit_count * sizeof *force);
  km_dynamics_outcome outcome = km_dynamics_solve_explicit(d, s);
  read_residuals(d, s, residual);
  return outcome;
}

/* Newton step of F by differences of the residuals, by LU. */
static km_dynamics_outcome newton_step(km_dynamics *d, km_state *s, double *force, const double *residual,
                                       double *changed, gsl_matrix *A, gsl_vector *step, gsl_permutation *pivots) {
  int n = d->forces->moving->implicit_count, sign;
  for (int k = 0; k < n; ++k) {
    /* the laws are piecewise polynomials, mostly linear: a difference of this size is exact for those */
    double kept = force[k], h = 1e-3 * fmax(fabs(kept), fmax(fabs(residual[k]), 1e-6));
    force[k] = kept + h;
    km_dynamics_outcome outcome = compute_residuals(d, s, force, changed);
    force[k] = kept;
    if (outcome != KM_DYNAMICS_DONE)
      return outcome;
    for (int i = 0; i < n; ++i)
      gsl_matrix_set(A, (size_t)i, (size_t)k, (changed[i] - residual[i]) / h);
  }
  for (int i = 0; i < n; ++i)
    gsl_vector_set(step, (size_t)i, -residual[i]);
  gsl_linalg_LU_decomp(A, pivots, &sign);
  if (gsl_linalg_LU_sgndet(A, sign) == 0 || gsl_linalg_LU_svx(A, pivots, step))
    return KM_DYNAMICS_IMPLICIT;
  for (int i = 0; i < n; ++i)
    force[i] += gsl_vector_get(step, (size_t)i);
  return KM_DYNAMICS_DONE;
}

km_dynamics_outcome km_implicit_forces_solve(km_dynamics *d, km_state *s) {
  km_moving_forces *moving = d->forces->moving;
  int n = moving->implicit_count;
  double *force = moving->implicit_work, *residual = force + n, *changed = residual + n;
  size_t *places = moving->implicit_places;
  gsl_matrix_view A = gsl_matrix_view_array(changed + n, (size_t)n, (size_t)n);
  gsl_vector_view step = gsl_vector_view_array(changed + n + n * n, (size_t)n);
  gsl_permutation pivots = {(size_t)n, places};
  memcpy(force, moving->implicit_force, (size_t)n * sizeof *force);
  read_residuals(d, s, residual);
  km_dynamics_outcome outcome = KM_DYNAMICS_DONE;
  double last = HUGE_VAL;
  for (int i = 0; i < MAX_ITERATIONS && outcome == KM_DYNAMICS_DONE; ++i) {
    double worst = km_max_norm(residual, n), size = fmax(km_max_norm(force, n), worst);
    if (worst <= converged * size || (worst >= last && worst <= 1e3 * converged * size))
      return KM_DYNAMICS_DONE;
    last = worst;
    outcome = newton_step(d, s, force, residual, changed, &A.matrix, &step.vector, &pivots);
    if (outcome == KM_DYNAMICS_DONE)
      outcome = compute_residuals(d, s, force, residual);
  }
  return outcome == KM_DYNAMICS_DONE ? KM_DYNAMICS_IMPLICIT : outcome;
}
