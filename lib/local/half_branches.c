/* Half-branches by the closed configurations on small spheres around a configuration q0:
 *
 *   F(y) = (e(q0 + y), (|D y|² - d²) / 2d) = 0
 *
 * from y = d D⁻¹ Z u, u random unit vectors: least squares (Levenberg and Marquardt, GSL), then Gauss and Newton. A
 * motion through q0 crosses every small sphere, once for each of its halves. A solution counts if it goes on at d/2,
 * d/4 and d/8 in about the same direction.
 *
 * Where two half-branches lie close together, as beside a cusp or where branches touch, F' is nearly singular at each
 * of them. With its least singular value s and its vectors u, v, and k = u·F''(v, v), s t + k t²/2 = 0 has the roots t
 * = 0 and t = -2 s / k: the second is a start for the neighbour. */
#include "local/half_branches.h"

#include "base/random.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <string.h>

enum { STARTS_PER_FREEDOM = 24, MOST_ITERATIONS = 60, MOST_NEWTON = 30, HALVINGS = 3 };
static const double radius =
    0.08; /* d: an order of contact n leaves a misfit of d^n, which must stand out from `closed` */
static const double closed = 1e-12;         /* rms of the worst loop */
static const double least_cosine = 0.8;     /* between the directions at d and d/2 */
static const double least_distance = 1e-4;  /* over d: closer solutions are one */
static const double least_singular = 1e-12; /* singular values below this share of the largest count as 0 */

/* The system at one distance, with its workspace. */
typedef struct sphere {
  km_tangents *f;
  double d;
  size_t equations;    /* GSL requires at least as many as unknowns: the excess ones are 0 */
  double *y;           /* [columns] scaled step from q0 */
  double *J;           /* [columns × rows] */
  double *kept, *last; /* [columns] */
  double *before;      /* [columns] */
  double *rate, *gamma;
  gsl_multifit_nlinear_workspace *fit;
  gsl_matrix *A, *V;
  gsl_vector *x, *error, *S, *work;
} sphere;

static void go(const sphere *p, const gsl_vector *x) {
  const km_tangents *f = p->f;
  for (int k = 0; k < f->sub->columns; ++k)
    p->y[k] = gsl_vector_get(x, (size_t)k);
  km_state_restore(f->s, f->sub, f->origin);
  km_state_move(f->m, f->s, f->sub, p->y);
  km_loops_recompute(f->m, f->s, f->sub);
}

static int residuals(const gsl_vector *x, void *data, gsl_vector *out) {
  const sphere *p = data;
  const km_substructure *sub = p->f->sub;
  go(p, x);
  gsl_vector_set_zero(out);
  for (int r = 0; r < sub->rows; ++r)
    gsl_vector_set(out, (size_t)r, km_state_error(p->f->s, sub)[r]);
  double square = km_step_dot(p->f->m, sub, p->y, p->y);
  gsl_vector_set(out, (size_t)sub->rows, (square - p->d * p->d) / (2.0 * p->d));
  return GSL_SUCCESS;
}

static int derivatives(const gsl_vector *x, void *data, gsl_matrix *out) {
  const sphere *p = data;
  const km_substructure *sub = p->f->sub;
  const double *weight = p->f->m->column_weight + sub->column_start;
  go(p, x);
  /* Of ball joints this is the derivative by the angular velocity, which is that by y to |y|/2: steps converge
   * linearly there. */
  km_state_jacobian_dense(p->f->s, sub, p->J);
  gsl_matrix_set_zero(out);
  for (int k = 0; k < sub->columns; ++k) {
    for (int r = 0; r < sub->rows; ++r)
      gsl_matrix_set(out, (size_t)r, (size_t)k, p->J[k * sub->rows + r]);
    gsl_matrix_set(out, (size_t)sub->rows, (size_t)k, weight[k] * weight[k] * p->y[k] / p->d);
  }
  return GSL_SUCCESS;
}

/* F' = A S Vᵀ at x, which the state goes to. */
static void decompose(sphere *p) {
  derivatives(p->x, p, p->A);
  gsl_linalg_SV_decomp(p->A, p->V, p->S, p->work);
}

/* Gauss and Newton's steps from x, as long as they become shorter. */
static void refine(sphere *p) {
  double last = HUGE_VAL;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    residuals(p->x, p, p->error);
    decompose(p);
    for (size_t k = 0; k < p->S->size; ++k)
      if (gsl_vector_get(p->S, k) < least_singular * gsl_vector_get(p->S, 0))
        gsl_vector_set(p->S, k, 0.0);
    gsl_linalg_SV_solve(p->A, p->V, p->S, p->error, p->work);
    double step = gsl_blas_dnrm2(p->work);
    if (!(step < last))
      break;
    last = step;
    gsl_vector_sub(p->x, p->work);
  }
}

/* Moves the state to a closed configuration at distance d, from y. False: there is none near. */
static bool solve(sphere *p, double d) {
  const km_tangents *f = p->f;
  gsl_multifit_nlinear_fdf fdf = {
      .f = residuals, .df = derivatives, .n = p->equations, .p = (size_t)f->sub->columns, .params = p};
  int info, worst;
  p->d = d;
  for (int k = 0; k < f->sub->columns; ++k)
    gsl_vector_set(p->x, (size_t)k, p->y[k]);
  gsl_multifit_nlinear_init(p->x, &fdf, p->fit);
  gsl_multifit_nlinear_driver(MOST_ITERATIONS, 1e-12, 1e-14, 0.0, NULL, NULL, &info, p->fit);
  gsl_vector_memcpy(p->x, gsl_multifit_nlinear_position(p->fit));
  refine(p);
  go(p, p->x);
  double length = km_step_length(f->m, f->sub, p->y);
  return km_loops_residual(f->m, f->s, f->sub, &worst) <= closed && fabs(length - d) <= 1e-6 * d;
}

/* True if the half-branch through the solution y at d = radius goes on to d/8, with direction changes below acos(0.8)
 * = 37 deg. y becomes the solution there; the state is overwritten. */
static bool leads_back(sphere *p) {
  const km_tangents *f = p->f;
  const int n = f->sub->columns;
  double d = radius;
  for (int k = 0; k < n; ++k)
    p->before[k] = 2.0 * p->y[k];
  for (int i = 0; i < HALVINGS; ++i) {
    memcpy(p->last, p->y, (size_t)n * sizeof *p->last);
    /* The parabola through q0 and the last two solutions. */
    for (int k = 0; k < n; ++k)
      p->y[k] = 0.75 * p->last[k] - 0.125 * p->before[k];
    d *= 0.5;
    if (!solve(p, d) || km_step_dot(f->m, f->sub, p->y, p->last) < least_cosine * d * 2.0 * d)
      return false;
    memcpy(p->before, p->last, (size_t)n * sizeof *p->last);
  }
  return true;
}

/* The shares of D y in the basis, at unit length. */
static void take_shares(const km_tangents *f, const double *y, double *a) {
  const double *weight = f->m->column_weight + f->sub->column_start;
  int n = f->sub->columns;
  for (int i = 0; i < f->conditions.freedom; ++i) {
    a[i] = 0.0;
    for (int k = 0; k < n; ++k)
      a[i] += f->conditions.Z[(size_t)i * (size_t)n + (size_t)k] * weight[k] * y[k];
  }
  km_tangents_normalise(a, f->conditions.freedom);
}

static double *pose_of(const km_half_branches *out, const km_tangents *f, int i) {
  return out->saved + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)f->sub->columns;
}

/* True if the state is at no half-branch that is listed. */
static bool is_new(const sphere *p, const km_half_branches *out) {
  const km_tangents *f = p->f;
  for (int i = 0; i < out->count; ++i) {
    km_state_difference(f->s, f->sub, pose_of(out, f, i), p->last);
    if (km_step_length(f->m, f->sub, p->last) <= least_distance * radius)
      return false;
  }
  return true;
}

/* Counts the solution y at the state if it is a new half-branch; y stays. */
static bool count_new(sphere *p, km_half_branches *out) {
  km_tangents *f = p->f;
  const size_t bytes = (size_t)f->sub->columns * sizeof *p->y;
  const bool is_full = out->count == KM_MAX_HALF_BRANCHES;
  if (out->truncated || !is_new(p, out))
    return false;
  memcpy(p->kept, p->y, bytes);
  if (!is_full)
    km_state_save(f->s, f->sub, pose_of(out, f, out->count));
  bool leads = leads_back(p);
  out->truncated = leads && is_full;
  leads = leads && !is_full;
  if (leads) /* by the solution nearest to q0 */
    take_shares(f, p->y, out->shares + (size_t)out->count++ * (size_t)f->conditions.freedom);
  memcpy(p->y, p->kept, bytes);
  return leads;
}

/* From the solution y at d = radius to the start for its neighbour, into y. False: the neighbour is no nearer than q0. */
static bool go_to_neighbour(sphere *p) {
  const km_tangents *f = p->f;
  const km_substructure *sub = f->sub;
  const double *weight = f->m->column_weight + sub->column_start;
  size_t n = (size_t)sub->columns, rows = (size_t)sub->rows;
  double square = 0.0, curvature = 0.0;
  p->d = radius;
  for (size_t k = 0; k < n; ++k)
    gsl_vector_set(p->x, k, p->y[k]);
  decompose(p);
  for (size_t k = 0; k < n; ++k) {
    int c = f->m->column_coordinate[sub->column_start + (int)k];
    double v = gsl_matrix_get(p->V, k, n - 1);
    p->rate[c] = f->m->unit[c] * v;
    square += weight[k] * v * weight[k] * v;
  }
  km_loops_velocity_products(f->m, f->s, sub, p->rate, p->gamma); /* -e''(v, v) */
  for (size_t r = 0; r < rows; ++r)
    curvature -= gsl_matrix_get(p->A, r, n - 1) * p->gamma[r];
  curvature += gsl_matrix_get(p->A, rows, n - 1) * square / p->d;
  double t = -2.0 * gsl_vector_get(p->S, n - 1) / curvature;
  for (size_t k = 0; k < n; ++k)
    p->y[k] += t * gsl_matrix_get(p->V, k, n - 1);
  return fabs(t) < radius;
}

/* From one random start, and from there to the neighbour. */
static void try_start(sphere *p, km_half_branches *out) {
  km_tangents *f = p->f;
  for (int i = 0; i < f->conditions.freedom; ++i)
    f->a[i] = km_uniform(&f->random);
  km_tangents_normalise(f->a, f->conditions.freedom);
  km_tangents_direction(f, f->a, p->y);
  for (int k = 0; k < f->sub->columns; ++k)
    p->y[k] *= radius;
  if (solve(p, radius) && count_new(p, out) && go_to_neighbour(p) && solve(p, radius))
    count_new(p, out);
}

static bool reserve(sphere *p) {
  km_arena *arena = p->f->arena;
  size_t n = (size_t)p->f->sub->columns, rows = (size_t)p->f->sub->rows;
  double **vectors[] = {&p->y, &p->kept, &p->last, &p->before};
  for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
    *vectors[i] = KM_ARENA_NEW(arena, double, n);
  p->J = KM_ARENA_NEW(arena, double, n *rows);
  p->rate = KM_ARENA_NEW(arena, double, (size_t)p->f->m->coordinate_count);
  p->gamma = KM_ARENA_NEW(arena, double, rows);
  p->equations = rows + 1 > n ? rows + 1 : n;
  /* The handler is the process's: it stays off, since putting it back would race with other threads. */
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

static void release(sphere *p) {
  if (p->fit)
    gsl_multifit_nlinear_free(p->fit);
  gsl_matrix_free(p->A);
  gsl_matrix_free(p->V);
  gsl_vector_free(p->x);
  gsl_vector_free(p->error);
  gsl_vector_free(p->S);
  gsl_vector_free(p->work);
}

bool km_half_branches_find(km_tangents *f, km_half_branches *out) {
  size_t n = (size_t)f->sub->columns, k = (size_t)f->conditions.freedom;
  *out = (km_half_branches){.length = radius};
  out->saved = KM_ARENA_NEW(f->arena, double, KM_MAX_HALF_BRANCHES *KM_SAVED_PER_COLUMN *n);
  out->shares = KM_ARENA_NEW(f->arena, double, KM_MAX_HALF_BRANCHES *k);
  sphere p = {.f = f};
  bool made = reserve(&p);
  for (size_t i = 0; made && i < STARTS_PER_FREEDOM * k && !out->truncated; ++i)
    try_start(&p, out);
  release(&p);
  km_state_restore(f->s, f->sub, f->origin);
  km_loops_update(f->m, f->s, f->sub);
  km_state_invalidate_pivots(f->s, f->index);
  f->arena->failed = f->arena->failed || !made;
  return made;
}
