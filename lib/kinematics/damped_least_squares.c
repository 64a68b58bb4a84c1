/* Damped least squares (GSL) from a poor start. */
#include "kinematics/damped_least_squares.h"
#include "kinematics/loop_equations.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>

enum { MOST_ITERATIONS = 300 };
static const double pull = 1e-5; /* keeps the problem regular; too faint to hold loops open */

typedef struct problem {
  const km_mechanism *mechanism;
  km_state *state;
  const km_substructure *sub;
  double *start; /* saved coordinates */
  double *step;  /* [columns] */
  double *J;     /* [rows × columns] */
} problem;

/* The unknowns are scaled steps from the start. */
static void go(const problem *p, const gsl_vector *x) {
  km_state_restore(p->state, p->sub, p->start);
  for (int k = 0; k < p->sub->columns; ++k)
    p->step[k] = gsl_vector_get(x, (size_t)k);
  km_state_move(p->mechanism, p->state, p->sub, p->step);
  km_loops_recompute(p->mechanism, p->state, p->sub);
}

static int residuals(const gsl_vector *x, void *data, gsl_vector *f) {
  const problem *p = data;
  size_t rows = (size_t)p->sub->rows;
  go(p, x);
  for (size_t r = 0; r < rows; ++r)
    gsl_vector_set(f, r, km_state_error(p->state, p->sub)[r]);
  for (size_t k = 0; k < (size_t)p->sub->columns; ++k)
    gsl_vector_set(f, rows + k, pull * gsl_vector_get(x, k));
  return GSL_SUCCESS;
}

static int derivatives(const gsl_vector *x, void *data, gsl_matrix *df) {
  const problem *p = data;
  size_t rows = (size_t)p->sub->rows;
  go(p, x);
  gsl_matrix_set_zero(df);
  km_state_jacobian_dense(p->state, p->sub, p->J);
  for (size_t k = 0; k < (size_t)p->sub->columns; ++k) {
    for (size_t r = 0; r < rows; ++r)
      gsl_matrix_set(df, r, k, p->J[k * rows + r]);
    gsl_matrix_set(df, rows + k, k, pull);
  }
  return GSL_SUCCESS;
}

static km_status minimise(problem *p, km_error *error) {
  size_t columns = (size_t)p->sub->columns, rows = (size_t)p->sub->rows;
  gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
  gsl_multifit_nlinear_workspace *w =
      gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, rows + columns, columns);
  gsl_vector *x = gsl_vector_calloc(columns);
  km_status status = KM_OK;
  if (w && x) {
    gsl_multifit_nlinear_fdf fdf = {.f = residuals, .df = derivatives, .n = rows + columns, .p = columns, .params = p};
    int info;
    gsl_multifit_nlinear_init(x, &fdf, w);
    gsl_multifit_nlinear_driver(MOST_ITERATIONS, 1e-12, 1e-14, 0.0, NULL, NULL, &info, w);
    go(p, gsl_multifit_nlinear_position(w));
  } else {
    status = km_fail(error, KM_MEMORY, "out of memory while assembling");
  }
  if (w)
    gsl_multifit_nlinear_free(w);
  gsl_vector_free(x);
  return status;
}

km_status km_damped_least_squares(const km_mechanism *m, km_state *s, int substructure, km_error *error) {
  const km_substructure *sub = &m->substructures[substructure];
  if (sub->columns == 0)
    return KM_OK;
  /* An iteration that stalls is an outcome here, not a reason to abort. The handler is the process's: it
   * stays off, since putting it back would race with other threads. */
  gsl_set_error_handler_off();
  km_arena scratch = {0};
  problem p = {m,
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
