/* Half-branches: closed configurations on small spheres around a configuration q0 (docs/theory.md 5.7).
 *
 *   F(y) = ( e(q0 + y),  (|D y|² − d²)/(2 d) ) = 0,   d = 0.08,  from y = d D⁻¹ Z u, u random
 *
 * A motion through q0 crosses every small sphere once for each of its halves. Each solution (Levenberg-Marquardt, then
 * Gauss-Newton) counts if it continues at d/2, d/4, … within 37° of its direction. If the starts cover the sphere and
 * none makes |F| small, q0 is isolated. */
#include "base/number/tolerances.h"
#include "local/local_private.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <string.h>

enum { STARTS_PER_FREEDOM = 24, MAX_ITERATIONS = 60, MAX_NEWTON_STEPS = 30, MIN_HALVINGS = 3, MAX_HALVINGS = 11 };
enum { MAX_COVERED_FREEDOM = 3 }; /* freedoms for which the starts cover the sphere of tangents, 20 degrees apart */
static const double radius =
    0.08; /* radius d: a contact of order n leaves a misfit of d^n, which must exceed the residual tolerance */

/* The system at one distance, with its workspace. */
typedef struct sphere {
  km_local *l;
  double d;
  size_t equations;         /* GSL requires at least as many as unknowns: the excess ones are 0 */
  double *y;                /* [columns] scaled step from q0 */
  double *J;                /* [columns × rows] */
  double *last;             /* [columns] solution at the last distance */
  double *previous_but_one; /* [columns] solution at the distance before */
  double *end;              /* [KM_MAX_HALF_BRANCHES × columns] solution of each half-branch nearest to q0, */
  double end_distance[KM_MAX_HALF_BRANCHES]; /* and its distance */
  double least_residual;                     /* least |F| of the starts at d = radius, before Gauss-Newton steps */
  gsl_multifit_nlinear_workspace *fit;
  gsl_matrix *A, *V;
  gsl_vector *x, *error, *S, *work;
} sphere;

/* Moves the state to q0 + x and evaluates errors and Jacobian. */
static void evaluate_at(const sphere *p, const gsl_vector *x) {
  const km_local *l = p->l;
  for (int k = 0; k < l->sub->columns; ++k)
    p->y[k] = gsl_vector_get(x, (size_t)k);
  km_state_restore(l->s, l->sub, l->origin);
  km_state_move(l->m, l->s, l->sub, p->y);
  km_loops_recompute(l->m, l->s, l->sub);
}

/* F(y) for GSL. */
static int compute_residuals(const gsl_vector *x, void *data, gsl_vector *out) {
  const sphere *p = data;
  const km_substructure *sub = p->l->sub;
  evaluate_at(p, x);
  gsl_vector_set_zero(out);
  for (int r = 0; r < sub->rows; ++r)
    gsl_vector_set(out, (size_t)r, km_state_error(p->l->s, sub)[r]);
  double square = km_step_dot(p->l->m, sub, p->y, p->y);
  gsl_vector_set(out, (size_t)sub->rows, (square - p->d * p->d) / (2.0 * p->d));
  return GSL_SUCCESS;
}

/* F'(y) for GSL. */
static int compute_derivatives(const gsl_vector *x, void *data, gsl_matrix *out) {
  const sphere *p = data;
  const km_substructure *sub = p->l->sub;
  const double *weight = p->l->m->column_weight + sub->column_start;
  evaluate_at(p, x);
  /* For ball joints this is the derivative by the angular velocity, which equals that by y up to |y|/2: convergence is
   * linear there. */
  km_state_jacobian_dense(p->l->s, sub, p->J);
  gsl_matrix_set_zero(out);
  for (int k = 0; k < sub->columns; ++k) {
    for (int r = 0; r < sub->rows; ++r)
      gsl_matrix_set(out, (size_t)r, (size_t)k, p->J[k * sub->rows + r]);
    gsl_matrix_set(out, (size_t)sub->rows, (size_t)k, weight[k] * weight[k] * p->y[k] / p->d);
  }
  return GSL_SUCCESS;
}

/* Singular value decomposition F' = A S Vᵀ at x, to which the state moves. */
static void compute_svd(sphere *p) {
  compute_derivatives(p->x, p, p->A);
  gsl_linalg_SV_decomp(p->A, p->V, p->S, p->work);
}

/* Gauss-Newton steps from x by the pseudo-inverse of F', while they become shorter. */
static void gauss_newton(sphere *p) {
  double last = HUGE_VAL;
  for (int i = 0; i < MAX_NEWTON_STEPS; ++i) {
    compute_residuals(p->x, p, p->error);
    compute_svd(p);
    for (size_t k = 0; k < p->S->size; ++k)
      if (gsl_vector_get(p->S, k) < km_solved_rounding * gsl_vector_get(p->S, 0))
        gsl_vector_set(p->S, k, 0.0);
    gsl_linalg_SV_solve(p->A, p->V, p->S, p->error, p->work);
    double step = gsl_blas_dnrm2(p->work);
    if (!(step < last))
      break;
    last = step;
    gsl_vector_sub(p->x, p->work);
  }
}

/* Moves the state to a closed configuration at distance d, from y. False: there is none nearby. */
static bool solve_on_sphere(sphere *p, double d) {
  const km_local *l = p->l;
  gsl_multifit_nlinear_fdf fdf = {
      .f = compute_residuals, .df = compute_derivatives, .n = p->equations, .p = (size_t)l->sub->columns, .params = p};
  int info;
  p->d = d;
  for (int k = 0; k < l->sub->columns; ++k)
    gsl_vector_set(p->x, (size_t)k, p->y[k]);
  gsl_multifit_nlinear_init(p->x, &fdf, p->fit);
  gsl_multifit_nlinear_driver(MAX_ITERATIONS, 1e-12, 1e-14, 0.0, NULL, NULL, &info, p->fit);
  gsl_vector_memcpy(p->x, gsl_multifit_nlinear_position(p->fit));
  p->least_residual = fmin(p->least_residual, gsl_blas_dnrm2(gsl_multifit_nlinear_residual(p->fit)));
  gauss_newton(p);
  evaluate_at(p, p->x);
  double length = km_step_length(l->m, l->sub, p->y);
  return km_loops_residual(l->m, l->s, l->sub) <= km_solved_rounding && fabs(length - d) <= 1e-6 * d;
}

/* Error of the last solution for a residual: the residual over the smallest singular value of F'. */
static double solution_error(const sphere *p, double residual) {
  return residual / gsl_vector_get(p->S, p->S->size - 1);
}

/* True if the half-branch through the solution y at d = radius continues to d/8, and further as long as solutions are
 * accurate, with direction changes below acos(0.8) = 37°. A motion that passes q0 at a distance ends at that distance.
 * y becomes the solution there; the state is overwritten. */
static bool continues_to_origin(sphere *p) {
  const km_local *l = p->l;
  const int n = l->sub->columns;
  double d = radius;
  for (int k = 0; k < n; ++k)
    p->previous_but_one[k] = 2.0 * p->y[k];
  for (int i = 0;
       i < MIN_HALVINGS || (i < MAX_HALVINGS && solution_error(p, km_solved_rounding) < km_secant_tolerance * p->d);
       ++i) {
    memcpy(p->last, p->y, (size_t)n * sizeof *p->last);
    /* Predictor: parabola through q0 and the last two solutions. */
    for (int k = 0; k < n; ++k)
      p->y[k] = 0.75 * p->last[k] - 0.125 * p->previous_but_one[k];
    d *= 0.5;
    if (!solve_on_sphere(p, d) || km_step_dot(l->m, l->sub, p->y, p->last) < km_min_direction_cosine * d * 2.0 * d)
      return false;
    memcpy(p->previous_but_one, p->last, (size_t)n * sizeof *p->last);
  }
  return true;
}

static double *saved_of(const km_half_branches *out, const km_local *l, int i) {
  return out->saved + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)l->sub->columns;
}

/* True if the state is at none of the half-branches found so far. */
static bool is_new_half_branch(const sphere *p, const km_half_branches *out) {
  const km_local *l = p->l;
  for (int i = 0; i < out->count; ++i) {
    km_state_difference(l->s, l->sub, saved_of(out, l, i), p->last);
    if (km_step_length(l->m, l->sub, p->last) <= km_root_rounding)
      return false;
  }
  return true;
}

/* True if the solution y nearest to q0 is that of a half-branch found before, which meets the sphere of the radius
 * more than once. */
static bool is_known_end(const sphere *p, const km_half_branches *out) {
  const size_t n = (size_t)p->l->sub->columns;
  bool known = false;
  for (int i = 0; i < out->count && !known; ++i) {
    for (size_t k = 0; k < n; ++k)
      p->last[k] = p->y[k] - p->end[(size_t)i * n + k];
    known =
        p->end_distance[i] == p->d && km_step_length(p->l->m, p->l->sub, p->last) <= solution_error(p, km_sum_rounding);
  }
  return known;
}

/* Adds the solution y at the state if it is a new half-branch that continues to q0. y is overwritten. */
static void add_half_branch(sphere *p, km_half_branches *out) {
  km_local *l = p->l;
  const bool is_full = out->count == KM_MAX_HALF_BRANCHES;
  if (out->truncated || !is_new_half_branch(p, out))
    return;
  if (!is_full)
    km_state_save(l->s, l->sub, saved_of(out, l, out->count));
  if (!continues_to_origin(p) || is_known_end(p, out))
    return;
  out->truncated = is_full;
  if (is_full)
    return;
  /* direction by the solution nearest to q0 */
  memcpy(p->end + (size_t)out->count * (size_t)l->sub->columns, p->y, (size_t)l->sub->columns * sizeof *p->y);
  p->end_distance[out->count] = p->d;
  km_local_coefficients(l, p->y, out->coefficients + (size_t)out->count++ * (size_t)l->freedom);
}

/* Solves from one random start. */
static void search_from_random_start(sphere *p, km_half_branches *out) {
  km_local *l = p->l;
  km_local_draw(l, &l->random, l->a);
  km_local_direction(l, l->a, p->y);
  for (int k = 0; k < l->sub->columns; ++k)
    p->y[k] *= radius;
  if (solve_on_sphere(p, radius))
    add_half_branch(p, out);
}

/* Allocates the workspace of the system on the sphere. */
static bool reserve_sphere(sphere *p) {
  km_arena *arena = p->l->arena;
  size_t n = (size_t)p->l->sub->columns, rows = (size_t)p->l->sub->rows;
  double **vectors[] = {&p->y, &p->last, &p->previous_but_one};
  for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
    *vectors[i] = KM_ARENA_NEW(arena, double, n);
  p->end = KM_ARENA_NEW(arena, double, KM_MAX_HALF_BRANCHES *n);
  p->J = KM_ARENA_NEW(arena, double, n *rows);
  p->equations = rows + 1 > n ? rows + 1 : n;
  /* GSL's handler belongs to the process: it stays off, since restoring it would race with other threads. */
  gsl_set_error_handler_off();
  gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
  p->fit = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, p->equations, n);
  p->A = gsl_matrix_alloc(p->equations, n);
  p->V = gsl_matrix_alloc(n, n);
  p->x = gsl_vector_alloc(n);
  p->error = gsl_vector_alloc(p->equations);
  p->S = gsl_vector_alloc(n);
  p->work = gsl_vector_alloc(n);
  return !arena->failed && p->fit && p->A && p->V && p->x && p->error && p->S && p->work;
}

static void free_sphere(sphere *p) {
  if (p->fit)
    gsl_multifit_nlinear_free(p->fit);
  gsl_matrix_free(p->A);
  gsl_matrix_free(p->V);
  gsl_vector_free(p->x);
  gsl_vector_free(p->error);
  gsl_vector_free(p->S);
  gsl_vector_free(p->work);
}

/* Solves the system on the sphere from random starts and collects the half-branches. */
bool km_half_branches_find(km_local *l, km_half_branches *out) {
  size_t n = (size_t)l->sub->columns, k = (size_t)l->freedom;
  *out = (km_half_branches){.length = radius};
  out->saved = KM_ARENA_NEW(l->arena, double, KM_MAX_HALF_BRANCHES *KM_SAVED_PER_COLUMN *n);
  out->coefficients = KM_ARENA_NEW(l->arena, double, KM_MAX_HALF_BRANCHES *k);
  sphere p = {.l = l, .least_residual = HUGE_VAL};
  bool is_ok = reserve_sphere(&p);
  for (size_t i = 0; is_ok && i < STARTS_PER_FREEDOM * k && !out->truncated; ++i)
    search_from_random_start(&p, out);
  out->is_isolated = k <= MAX_COVERED_FREEDOM && p.least_residual > km_relative_zero /* d^n, n <= 8 */;
  free_sphere(&p);
  km_state_restore(l->s, l->sub, l->origin);
  km_loops_update(l->m, l->s, l->sub);
  km_state_invalidate_pivots(l->s, l->index);
  l->arena->failed = l->arena->failed || !is_ok;
  return is_ok;
}
