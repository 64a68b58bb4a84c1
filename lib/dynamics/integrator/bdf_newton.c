/* Linear systems of BDF's Newton iteration, reduced to the components C on which the derivative depends
 * (docs/theory.md 11.5).
 *
 *   (I − γ J) x = b,  J = ∂f/∂y with non-zero columns C only:  (I − γ J_CC) x_C = b_C,   x = b + γ J_C x_C elsewhere */
#include "dynamics/integrator/bdf_newton.h"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_dense.h>

#include <string.h>

struct km_newton {
  km_simulation *run;
  SUNMatrix matrix; /* no content; the fields below replace it */
  SUNLinearSolver solver;
  int count;      /* number of components in C */
  int *component; /* [count] components C */
  double *J;      /* [count × size] J_C, column-major */
  double *M;      /* [count²] LU factors of I − γ J_CC, column-major */
  size_t J_capacity, M_capacity;
  double **column;     /* [count] pointers to the columns of M */
  sunindextype *pivot; /* [count] components C */
  double *work;        /* [size] shifted vector, then the derivative at the present one */
  double *x;           /* [count] components C */
  double gamma;
  int repartitions; /* number of repartitions when J was computed */
};

/* Step of the differences, in radians, characteristic lengths and these per second; closing error of loops
 * meanwhile, which is small compared with it. */
static const double difference = 1e-7, accepted_tolerance = 1e-13;

static void add(km_newton *n, int component) {
  n->component[n->count++] = component;
}

/* Lists the components that an evaluation reads (integrator_vector.c): independent coordinates, their rates,
 * quaternions of balls, internal states; all with Baumgarte's stabilisation. */
static void list_components(km_newton *n) {
  const km_simulation *run = n->run;
  const km_dynamics *d = run->dynamics;
  const km_mechanism *m = d->mechanism;
  n->count = 0;
  for (int i = 0; i < run->memory_start && d->uses_baumgarte; ++i)
    add(n, i);
  for (int i = 0; i < d->tree.cluster_count && !d->uses_baumgarte; ++i) {
    const int *coordinates = d->tree.coordinate_order + d->tree.clusters[i].coordinate_start;
    for (int k = 0; k < d->cluster[i].freedom; ++k) {
      int c = coordinates[d->cluster[i].independent[k]];
      add(n, run->rate_start + c);
      if (m->ball_of[c] < 0)
        add(n, run->value_index[c]);
    }
  }
  for (int b = 0; b < m->ball_count && !d->uses_baumgarte; ++b)
    for (int k = 0; k < 4 && !m->held[m->ball_coordinate[b]]; ++k)
      add(n, run->value_index[m->ball_coordinate[b]] + k);
  for (int i = run->memory_start; i < run->work_start; ++i)
    add(n, i);
}

static bool reserve(km_newton *n) {
  size_t count = (size_t)n->count;
  return km_reserve((void **)&n->J, &n->J_capacity, count * (size_t)n->run->size, sizeof *n->J) &&
         km_reserve((void **)&n->M, &n->M_capacity, count * count, sizeof *n->M);
}

/* Computes J_C at y by forward differences. The evaluation at y itself is the last one, so the state is that of y. */
static bool differentiate(km_newton *n, double t, const double *y) {
  km_simulation *run = n->run;
  size_t size = (size_t)run->size;
  double closing_tolerance = run->dynamics->closing_tolerance, *f = n->work;
  bool is_ok = true;
  run->dynamics->closing_tolerance = fmin(closing_tolerance, accepted_tolerance);
  for (int k = 0; k < n->count && is_ok; ++k) {
    int i = n->component[k];
    double by = difference * fmax(run->tolerance[i] / run->def.absolute, fabs(y[i]));
    memcpy(n->work, y, size * sizeof *y);
    n->work[i] += by;
    n->x[k] = 1.0 / (n->work[i] - y[i]);
    is_ok = km_simulation_derivative(run, t, n->work, n->J + (size_t)k * size);
  }
  is_ok = is_ok && km_simulation_derivative(run, t, y, f);
  for (int k = 0; k < n->count && is_ok; ++k) {
    double *column = n->J + (size_t)k * size;
    for (size_t i = 0; i < size; ++i)
      column[i] = n->x[k] * (column[i] - f[i]);
  }
  run->dynamics->closing_tolerance = closing_tolerance;
  n->repartitions = km_dynamics_repartitions(run->dynamics);
  return is_ok;
}

/* LU factorisation of I − γ J_CC. */
static bool factor(km_newton *n) {
  size_t size = (size_t)n->run->size, count = (size_t)n->count;
  for (size_t k = 0; k < count; ++k) {
    const double *J = n->J + k * size;
    double *M = n->M + k * count;
    for (size_t r = 0; r < count; ++r)
      M[r] = -n->gamma * J[n->component[r]];
    M[k] += 1.0;
    n->column[k] = M;
  }
  n->run->operations += 2.0 / 3.0 * pow(n->count, 3.0);
  return n->count == 0 || SUNDlsMat_denseGETRF(n->column, n->count, n->count, n->pivot) == 0;
}

/* Return codes for CVODE: success, recoverable failure (shorter step), unrecoverable failure. */
enum { SUCCESS = 0, RECOVERABLE = 1, UNRECOVERABLE = -1 };

/* CVODE's callback: computes J_C if needed and factors I − γ J_CC. */
static int prepare(realtype t, N_Vector y, N_Vector f, SUNMatrix A, booleantype known, booleantype *repartitions,
                   realtype gamma, void *data, N_Vector a, N_Vector b, N_Vector c) {
  km_newton *n = (km_newton *)A->content;
  (void)f, (void)data, (void)a, (void)b, (void)c;
  *repartitions = !known || n->repartitions != km_dynamics_repartitions(n->run->dynamics);
  if (*repartitions) {
    list_components(n);
    n->run->arena.failed = n->run->arena.failed || !reserve(n);
    if (n->run->arena.failed)
      return UNRECOVERABLE;
    if (!differentiate(n, t, NV_DATA_S(y)))
      return RECOVERABLE;
  }
  n->gamma = gamma;
  return factor(n) ? SUCCESS : RECOVERABLE;
}

/* CVODE's callback: solves (I − γ J) x = b. */
static int solve(SUNLinearSolver solver, SUNMatrix A, N_Vector out, N_Vector right, realtype tolerance) {
  km_newton *n = (km_newton *)solver->content;
  size_t size = (size_t)n->run->size;
  const double *b = NV_DATA_S(right);
  double *x = NV_DATA_S(out);
  (void)A, (void)tolerance;
  for (int k = 0; k < n->count; ++k)
    n->x[k] = b[n->component[k]];
  if (n->count > 0) /* 0: no free motion */
    SUNDlsMat_denseGETRS(n->column, n->count, n->pivot, n->x);
  memmove(x, b, size * sizeof *x);
  for (int k = 0; k < n->count; ++k) {
    const double *J = n->J + (size_t)k * size;
    double by = n->gamma * n->x[k];
    for (size_t i = 0; i < size; ++i)
      x[i] += by * J[i];
  }
  for (int k = 0; k < n->count; ++k)
    x[n->component[k]] = n->x[k];
  n->run->operations += 2.0 * n->count * (n->count + (double)size);
  return SUCCESS;
}

static SUNLinearSolver_Type solver_type(SUNLinearSolver solver) {
  (void)solver;
  return SUNLINEARSOLVER_DIRECT;
}

static SUNMatrix_ID matrix_id(SUNMatrix matrix) {
  (void)matrix;
  return SUNMATRIX_CUSTOM;
}

/* Allocates matrix, solver and work arrays. */
static bool allocate(km_newton *n, SUNContext context) {
  size_t size = (size_t)n->run->size;
  n->solver = SUNLinSolNewEmpty(context);
  n->matrix = SUNMatNewEmpty(context);
  n->component = KM_NEW(int, size);
  n->column = KM_NEW(double *, size);
  n->pivot = KM_NEW(sunindextype, size);
  n->work = KM_NEW(double, size);
  n->x = KM_NEW(double, size);
  return n->solver && n->matrix && n->component && n->column && n->pivot && n->work && n->x;
}

km_newton *km_newton_create(km_simulation *run, void *cvode, SUNContext context) {
  km_newton *n = KM_NEW(km_newton, 1);
  if (!n)
    return NULL;
  n->run = run;
  bool is_ok = allocate(n, context);
  if (is_ok) {
    n->solver->content = n->matrix->content = n;
    n->solver->ops->gettype = solver_type;
    n->solver->ops->solve = solve;
    n->matrix->ops->getid = matrix_id;
    is_ok = !CVodeSetLinearSolver(cvode, n->solver, n->matrix) && !CVodeSetLinSysFn(cvode, prepare);
  }
  if (is_ok)
    return n;
  km_newton_free(n);
  return NULL;
}

void km_newton_free(km_newton *n) {
  if (!n)
    return;
  if (n->solver)
    SUNLinSolFreeEmpty(n->solver);
  if (n->matrix)
    SUNMatFreeEmpty(n->matrix);
  km_free(n->component);
  km_free(n->column);
  km_free(n->pivot);
  km_free(n->work);
  km_free(n->x);
  km_free(n->J);
  km_free(n->M);
  km_free(n);
}
