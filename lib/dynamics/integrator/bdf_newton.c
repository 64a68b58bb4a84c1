/* The linear systems of BDF's Newton iterations, over the components that a derivative depends on. */
#include "dynamics/integrator/bdf_newton.h"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_dense.h>

#include <string.h>

/* Symbols: C the components that f depends on, J_C their columns of J = ∂f/∂y. (I − γ J) x = b is
 * (I − γ J_CC) x_C = b_C, and x = b + γ J_C x_C elsewhere. */

struct km_newton {
  km_simulation *run;
  SUNMatrix matrix; /* without content of its own: what is below stands for it */
  SUNLinearSolver solver;
  int count;      /* of C */
  int *component; /* [count] */
  double *J;      /* [count × size] J_C, one column after the other */
  double *M;      /* [count²] LU of I − γ J_CC, by columns */
  size_t J_room, M_room;
  double **column;     /* [count] of M */
  sunindextype *pivot; /* [count] */
  double *beside;      /* [size] a vector beside the present one, and the derivative at that one */
  double *x;           /* [count] */
  double gamma;
  int repartitions; /* when J was found */
};

/* Of a difference, in radians, characteristic lengths and those per second: beside it the loops' errors are small. */
static const double difference = 1e-7, tightly = 1e-13;

static void add(km_newton *n, int component) {
  n->component[n->count++] = component;
}

/* What an evaluation reads of the vector (integrator_vector.c): of balls the whole quaternion; all where errors are fed back. */
static void list_components(km_newton *n) {
  const km_simulation *run = n->run;
  const km_dynamics *d = run->dynamics;
  const km_mechanism *m = d->mechanism;
  n->count = 0;
  for (int i = 0; i < run->memory_start && d->feeds_back; ++i)
    add(n, i);
  for (int i = 0; i < d->tree.cluster_count && !d->feeds_back; ++i) {
    const int *coordinates = d->tree.coordinate_order + d->tree.clusters[i].coordinate_start;
    for (int k = 0; k < d->cluster[i].freedom; ++k) {
      int c = coordinates[d->cluster[i].independent[k]];
      add(n, run->rate_start + c);
      if (m->ball_of[c] < 0)
        add(n, run->place[c]);
    }
  }
  for (int b = 0; b < m->ball_count && !d->feeds_back; ++b)
    for (int k = 0; k < 4 && !m->held[m->ball_coordinate[b]]; ++k)
      add(n, run->place[m->ball_coordinate[b]] + k);
  for (int i = run->memory_start; i < run->work_start; ++i)
    add(n, i);
}

static bool reserve(km_newton *n) {
  size_t count = (size_t)n->count;
  return km_reserve((void **)&n->J, &n->J_room, count * (size_t)n->run->size, sizeof *n->J) &&
         km_reserve((void **)&n->M, &n->M_room, count * count, sizeof *n->M);
}

/* J_C about y, where n->J has its space. The evaluation at y itself comes last: the run goes on from there. */
static bool differentiate(km_newton *n, double t, const double *y) {
  km_simulation *run = n->run;
  size_t size = (size_t)run->size;
  double closing = run->dynamics->closing, *f = n->beside;
  bool good = true;
  run->dynamics->closing = fmin(closing, tightly);
  for (int k = 0; k < n->count && good; ++k) {
    int i = n->component[k];
    double by = difference * fmax(run->tolerance[i] / run->def.absolute, fabs(y[i]));
    memcpy(n->beside, y, size * sizeof *y);
    n->beside[i] += by;
    n->x[k] = 1.0 / (n->beside[i] - y[i]);
    good = km_simulation_derivative(run, t, n->beside, n->J + (size_t)k * size);
  }
  good = good && km_simulation_derivative(run, t, y, f);
  for (int k = 0; k < n->count && good; ++k) {
    double *column = n->J + (size_t)k * size;
    for (size_t i = 0; i < size; ++i)
      column[i] = n->x[k] * (column[i] - f[i]);
  }
  run->dynamics->closing = closing;
  n->repartitions = km_dynamics_repartitions(run->dynamics);
  return good;
}

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

/* What CVODE is told: to go on, to try a shorter step, to give up. */
enum { GO_ON = 0, RETRY = 1, GIVE_UP = -1 };

static int prepare(realtype t, N_Vector y, N_Vector f, SUNMatrix A, booleantype known, booleantype *renewed,
                   realtype gamma, void *data, N_Vector a, N_Vector b, N_Vector c) {
  km_newton *n = (km_newton *)A->content;
  (void)f, (void)data, (void)a, (void)b, (void)c;
  *renewed = !known || n->repartitions != km_dynamics_repartitions(n->run->dynamics);
  if (*renewed) {
    list_components(n);
    n->run->arena.failed = n->run->arena.failed || !reserve(n);
    if (n->run->arena.failed)
      return GIVE_UP;
    if (!differentiate(n, t, NV_DATA_S(y)))
      return RETRY;
  }
  n->gamma = gamma;
  return factor(n) ? GO_ON : RETRY;
}

static int solve(SUNLinearSolver solver, SUNMatrix A, N_Vector out, N_Vector right, realtype tolerance) {
  km_newton *n = (km_newton *)solver->content;
  size_t size = (size_t)n->run->size;
  const double *b = NV_DATA_S(right);
  double *x = NV_DATA_S(out);
  (void)A, (void)tolerance;
  for (int k = 0; k < n->count; ++k)
    n->x[k] = b[n->component[k]];
  if (n->count > 0) /* else nothing moves freely */
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
  return GO_ON;
}

static SUNLinearSolver_Type solver_type(SUNLinearSolver solver) {
  (void)solver;
  return SUNLINEARSOLVER_DIRECT;
}

static SUNMatrix_ID matrix_id(SUNMatrix matrix) {
  (void)matrix;
  return SUNMATRIX_CUSTOM;
}

static bool allocate(km_newton *n, SUNContext context) {
  size_t size = (size_t)n->run->size;
  n->solver = SUNLinSolNewEmpty(context);
  n->matrix = SUNMatNewEmpty(context);
  n->component = KM_NEW(int, size);
  n->column = KM_NEW(double *, size);
  n->pivot = KM_NEW(sunindextype, size);
  n->beside = KM_NEW(double, size);
  n->x = KM_NEW(double, size);
  return n->solver && n->matrix && n->component && n->column && n->pivot && n->beside && n->x;
}

km_newton *km_newton_create(km_simulation *run, void *cvode, SUNContext context) {
  km_newton *n = KM_NEW(km_newton, 1);
  if (!n)
    return NULL;
  n->run = run;
  bool good = allocate(n, context);
  if (good) {
    n->solver->content = n->matrix->content = n;
    n->solver->ops->gettype = solver_type;
    n->solver->ops->solve = solve;
    n->matrix->ops->getid = matrix_id;
    good = !CVodeSetLinearSolver(cvode, n->solver, n->matrix) && !CVodeSetLinSysFn(cvode, prepare);
  }
  if (good)
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
  km_free(n->beside);
  km_free(n->x);
  km_free(n->J);
  km_free(n->M);
  km_free(n);
}
