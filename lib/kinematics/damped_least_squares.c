/* Levenberg-Marquardt closing from a poor start (docs/theory.md 4.3).
 *
 *   min |f(x)|²,  f = (e(q₀ + x),  1e-5 x),   df/dx = (J; 1e-5 I)        x: scaled step from the start */
#include "kinematics/damped_least_squares.h"
#include "kinematics/loop_equations.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>

enum { MAX_ITERATIONS = 300 };
static const double regularisation = 1e-5; /* Tikhonov term that keeps JᵀJ regular; too small to keep loops open */

typedef struct least_squares {
  const km_mechanism *mechanism;
  km_state *state;
  const km_substructure *sub;
  double *start; /* saved coordinates */
  double *step;  /* [columns] */
  double *J;     /* [rows × columns] */
} least_squares;

/* Moves the state to start + x and evaluates errors and Jacobian. */
static void evaluate_at(const least_squares *p, const gsl_vector *x) {
  km_state_restore(p->state, p->sub, p->start);
  for (int k = 0; k < p->sub->columns; ++k)
    p->step[k] = gsl_vector_get(x, (size_t)k);
  km_state_move(p->mechanism, p->state, p->sub, p->step);
  km_loops_recompute(p->mechanism, p->state, p->sub);
}

/* f(x) for GSL. */
static int compute_residuals(const gsl_vector *x, void *data, gsl_vector *f) {
  const least_squares *p = data;
  size_t rows = (size_t)p->sub->rows;
  evaluate_at(p, x);
  for (size_t r = 0; r < rows; ++r)
    gsl_vector_set(f, r, km_state_error(p->state, p->sub)[r]);
  for (size_t k = 0; k < (size_t)p->sub->columns; ++k)
    gsl_vector_set(f, rows + k, regularisation * gsl_vector_get(x, k));
  return GSL_SUCCESS;
}

/* df/dx for GSL. */
static int compute_derivatives(const gsl_vector *x, void *data, gsl_matrix *df) {
  const least_squares *p = data;
  size_t rows = (size_t)p->sub->rows;
  evaluate_at(p, x);
  gsl_matrix_set_zero(df);
  km_state_jacobian_dense(p->state, p->sub, p->J);
  for (size_t k = 0; k < (size_t)p->sub->columns; ++k) {
    for (size_t r = 0; r < rows; ++r)
      gsl_matrix_set(df, r, k, p->J[k * rows + r]);
    gsl_matrix_set(df, rows + k, k, regularisation);
  }
  return GSL_SUCCESS;
}

/* Runs GSL's trust-region solver; the state ends at its last point. */
static km_status minimise(least_squares *p, km_error *error) {
  size_t columns = (size_t)p->sub->columns, rows = (size_t)p->sub->rows;
  gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
  gsl_multifit_nlinear_workspace *w =
      gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, rows + columns, columns);
  gsl_vector *x = gsl_vector_calloc(columns);
  km_status status = KM_OK;
  if (w && x) {
    gsl_multifit_nlinear_fdf fdf = {
        .f = compute_residuals, .df = compute_derivatives, .n = rows + columns, .p = columns, .params = p};
    int info;
    gsl_multifit_nlinear_init(x, &fdf, w);
    gsl_multifit_nlinear_driver(MAX_ITERATIONS, 1e-12, 1e-14, 0.0, NULL, NULL, &info, w);
    evaluate_at(p, gsl_multifit_nlinear_position(w));
  } else {
    status = km_fail(error, KM_MEMORY, "out of memory while assembling");
  }
  if (w)
    gsl_multifit_nlinear_free(w);
  gsl_vector_free(x);
  return status;
}

/* Levenberg-Marquardt closing of a substructure; the state ends at the minimum. */
km_status km_damped_least_squares(const km_mechanism *m, km_state *s, int substructure, km_error *error) {
  const km_substructure *sub = &m->substructures[substructure];
  if (sub->columns == 0)
    return KM_OK;
  /* A stalled iteration is an outcome, not an error. GSL's handler belongs to the process: it stays off, since
   * restoring it would race with other threads. */
  gsl_set_error_handler_off();
  km_arena scratch = {0};
  least_squares p = {m,
                     s,
                     sub,
                     KM_ARENA_NEW(&scratch, double, (size_t)(KM_SAVED_PER_COLUMN * sub->columns)),
                     KM_ARENA_NEW(&scratch, double, (size_t)sub->columns),
                     KM_ARENA_NEW(&scratch, double, (size_t)sub->rows *(size_t)sub->columns)};
  km_status status;
  if (scratch.failed) {
    status = km_fail(error, KM_MEMORY, "out of memory while assembling");
  } else {
    km_state_save(s, sub, p.start);
    status = minimise(&p, error);
  }
  km_arena_free(&scratch);
  return status;
}
