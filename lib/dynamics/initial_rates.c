/* Initial rates that keep the closed loops, by the least change of them.
 *
 *   minimise |D (v - v0)|  subject to  J v = 0  and  v_k = v0_k for every stated rate k
 *
 *   v  = x + D^-1 Z a, x the motion of the prescribed coordinates, Z the orthonormal null space with these at rest
 *   a0 = Z^T D (v0 - x): the nearest rates without the statements
 *   Z_S N b = D_S (v0 - v(a0))_S in least squares, |b| least, a = a0 + N b: the rows S of Z are those of the stated
 *        rates, N spans what the statements that come before leave (the caller's come before the model's)
 *
 * Statements that contradict each other are met in least squares. Golub, Van Loan: Matrix Computations, 6.2. */
#include "dynamics/dynamics.h"

#include "base/arguments.h"
#include "kinematics/loop_closing.h"

#include <gsl/gsl_linalg.h>
#include <string.h>

/* Singular value of Z_S, relative to 1, up to which the statements do not determine a direction; the criterion of a
 * joint at its dead point. */
static const double singular_tolerance = 3e-8;
/* Residuals of stated rates up to this part of the largest rate are rounding errors. */
static const double rounding = 1e-13;

/* Rates x due to the prescribed coordinates, with all other independent rates 0. */
static void prescribed_part(const km_dynamics *d, const km_state *s, int index, double *x, double *direction) {
  const km_mechanism *m = d->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k)
    x[k] = 0.0;
  for (int k = km_factor_rank(p); k < sub->columns; ++k) {
    int c = coordinate[km_factor_column_order(p)[k]];
    if (!d->driven[c])
      continue;
    km_factor_null_vector(p, km_factor_column_order(p)[k], direction);
    for (int i = 0; i < sub->columns; ++i)
      x[i] += s->rate[c] / m->unit[c] * direction[i];
  }
}

/* Least-squares fit of the stated rates of one substructure. */
typedef struct rate_fit {
  const km_state *s;
  const km_substructure *sub;
  const int *coordinate; /* [columns] */
  const double *weight;  /* [columns] D */
  const double *Z;       /* [count x columns] */
  int count;
  double *v;      /* [columns] the rates, in columns' units */
  double *target; /* [columns] v0 */
  double *N;      /* [count x left] by columns */
  int left;       /* columns of N */
} rate_fit;

/* v ← v + D⁻¹ Z a. */
static void add_motion(rate_fit *f, const double *a) {
  for (int i = 0; i < f->count; ++i)
    for (int k = 0; k < f->sub->columns; ++k)
      f->v[k] += a[i] * f->Z[(size_t)i * (size_t)f->sub->columns + (size_t)k] / f->weight[k];
}

static double residual(const rate_fit *f, int k) {
  return f->weight[k] * (f->target[k] - f->v[k]);
}

/* True if all stated rates are met already. */
static bool is_met(const rate_fit *f) {
  double largest = 0.0, worst = 0.0;
  for (int k = 0; k < f->sub->columns; ++k) {
    largest = fmax(largest, fabs(f->weight[k] * f->target[k]));
    if (f->s->rate_source[f->coordinate[k]] != KM_RATE_FOLLOWS)
      worst = fmax(worst, fabs(residual(f, k)));
  }
  return worst <= rounding * largest;
}

/* Minimum-norm least squares by the singular value decomposition A = U S Vᵀ: b = V S⁺ Uᵀ r, a = N b. N becomes N V₀,
 * with V₀ the null space of A. */
static void solve_least_squares(rate_fit *f, gsl_matrix *U, const gsl_matrix *V, const gsl_vector *S, const double *r,
                                double *a, double *kept) {
  size_t count = (size_t)f->count, left = (size_t)f->left, next = 0;
  memset(a, 0, count * sizeof *a);
  for (size_t j = 0; j < left; ++j) {
    double along = 0.0, sigma = gsl_vector_get(S, j);
    double *direction = kept + next * count;
    for (size_t i = 0; i < U->size1; ++i)
      along += gsl_matrix_get(U, i, j) * r[i];
    for (size_t i = 0; i < count; ++i) {
      direction[i] = 0.0;
      for (size_t l = 0; l < left; ++l)
        direction[i] += f->N[l * count + i] * gsl_matrix_get(V, l, j);
    }
    if (sigma <= singular_tolerance)
      next++;
    for (size_t i = 0; sigma > singular_tolerance && i < count; ++i)
      a[i] += along / sigma * direction[i];
  }
  memcpy(f->N, kept, next * count * sizeof *kept);
  f->left = (int)next;
}

/* Fits the rates of one source within the freedom that earlier sources left. */
static bool fit_source(rate_fit *f, km_rate_source source) {
  size_t count = (size_t)f->count, left = (size_t)f->left, stated = 0, rows;
  for (int k = 0; k < f->sub->columns; ++k)
    stated += f->s->rate_source[f->coordinate[k]] == source;
  if (stated == 0 || left == 0)
    return true;
  rows = stated > left ? stated : left; /* GSL requires at least as many rows as columns: zero rows are appended */
  double *work = KM_NEW(double, rows *left + left * left + 2 * left + rows + count + count * left);
  if (!work)
    return false;
  double *v = work + rows * left, *sigma = v + left * left, *r = sigma + 2 * left, *a = r + rows, *kept = a + count;
  gsl_matrix_view U = gsl_matrix_view_array(work, rows, left), V = gsl_matrix_view_array(v, left, left);
  gsl_vector_view S = gsl_vector_view_array(sigma, left), space = gsl_vector_view_array(sigma + left, left);
  size_t row = 0;
  for (int k = 0; k < f->sub->columns; ++k) {
    if (f->s->rate_source[f->coordinate[k]] != source)
      continue;
    for (size_t j = 0; j < left; ++j)
      for (size_t i = 0; i < count; ++i)
        work[row * left + j] += f->Z[i * (size_t)f->sub->columns + (size_t)k] * f->N[j * count + i];
    r[row++] = residual(f, k);
  }
  bool done = gsl_linalg_SV_decomp(&U.matrix, &V.matrix, &S.vector, &space.vector) == 0;
  if (done) {
    solve_least_squares(f, &U.matrix, &V.matrix, &S.vector, r, a, kept);
    add_motion(f, a);
  }
  km_free(work);
  return done;
}

/* Closest rates that satisfy the loops, then the stated rates within them. */
static bool fit(rate_fit *f) {
  size_t count = (size_t)f->count;
  double *a = KM_NEW(double, count *(count + 1) + 1);
  if (!a)
    return false;
  for (int i = 0; i < f->count; ++i)
    for (int k = 0; k < f->sub->columns; ++k)
      a[i] += f->Z[(size_t)i * (size_t)f->sub->columns + (size_t)k] * residual(f, k);
  add_motion(f, a);
  f->N = a + count;
  f->left = f->count;
  for (size_t i = 0; i < count; ++i)
    f->N[i * count + i] = 1.0;
  bool done = is_met(f) || (fit_source(f, KM_RATE_CALLER) && fit_source(f, KM_RATE_MODEL));
  km_free(a);
  return done;
}

/* Projects the rates of one substructure on its loops and stated rates; sums their change. */
static bool project(km_dynamics *d, km_state *s, int index, double *changed, double *size) {
  const km_mechanism *m = d->mechanism;
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  rate_fit f = {.s = s,
                .sub = sub,
                .coordinate = m->column_coordinate + sub->column_start,
                .weight = m->column_weight + sub->column_start,
                .v = d->step,
                .target = s->work};
  prescribed_part(d, s, index, f.v, s->projection);
  for (int k = 0; k < sub->columns; ++k)
    f.target[k] = s->rate[f.coordinate[k]] / m->unit[f.coordinate[k]];
  f.count = km_factor_freedom(p);
  for (int k = km_factor_rank(p); k < sub->columns; ++k)
    f.count -= d->driven[f.coordinate[km_factor_column_order(p)[k]]];
  f.Z = km_factor_null_space(p, f.count);
  if ((!f.Z && f.count > 0) || !fit(&f))
    return false;
  for (int k = 0; k < sub->columns; ++k) {
    int c = f.coordinate[k];
    double rate = m->unit[c] * f.v[k], change = m->scale[c] * (rate - s->rate[c]);
    if (s->rate_source[c] != KM_RATE_FOLLOWS) {
      *changed += change * change;
      *size += m->scale[c] * m->scale[c] * s->rate[c] * s->rate[c];
    }
    s->rate[c] = rate;
  }
  return true;
}

/* Closes the loops and projects the rates of all substructures. */
km_status km_dynamics_project_rates(km_dynamics *d, km_state *s, double *change, km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (status)
    return status;
  double changed = 0.0, size = 0.0;
  status = km_dynamics_move_to_prescribed(d, s, error);
  if (status)
    return status;
  km_dynamics_apply_prescribed(d, s, true);
  double *kept = KM_NEW(double, (size_t)s->mechanism->coordinate_count);
  if (!kept)
    return km_fail(error, KM_MEMORY, "out of memory for the rates");
  for (int c = 0; c < s->mechanism->coordinate_count; ++c)
    kept[c] = s->rate[c];
  bool closed = km_constraints_close(d, s, true); /* finds the pivots; its rates aren't the closest ones */
  for (int c = 0; c < s->mechanism->coordinate_count; ++c)
    s->rate[c] = kept[c];
  km_free(kept);
  bool memory = true;
  for (int i = 0; closed && memory && i < d->mechanism->topology.substructure_count; ++i)
    memory = project(d, s, i, &changed, &size);
  if (!memory)
    return km_fail(error, KM_MEMORY, "out of memory for the rates");
  if (change)
    *change = size > 0.0 ? sqrt(changed / size) : sqrt(changed);
  return closed ? KM_OK : km_dynamics_fail(d, KM_DYNAMICS_OPEN, error);
}
