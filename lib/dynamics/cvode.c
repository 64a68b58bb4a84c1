/* Steps of variable order and length by SUNDIALS' CVODE (A. Hindmarsh and others, 2005): Adams with functional
 * iteration, and BDF with Newton's method where the motion is stiff. */
#include "dynamics/simulation.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <string.h>

struct km_cvode {
  SUNContext context;
  void *memory;
  N_Vector y, at; /* the run's vector, and one whose numbers are the caller's */
  SUNNonlinearSolver functional;
  SUNMatrix matrix;
  SUNLinearSolver dense;
  long seen_failures, seen_steps; /* of the iteration, at the last look */
};

/* Of a hundred steps, as many whose functional iteration failed tell stiffness; fewer steps than so many to the end are
 * rather made by Adams' method, as each of BDF's costs a matrix. */
static const double few_steps = 3e5;
enum { STIFF_LOOK = 100, STIFF_FAILURES = 20 };
/* What rounding may make of a step, over the error allowed. */
static const double most_blindness = 0.3, hopeless = 1e6;
/* The longest step over a singular pose: radians or characteristic lengths. */
static const double most_motion = 0.5;
/* Steps that are made as they come where there was no such step. */
enum { UNSEEING = 50 };
/* The loops' error where forces are stiff. */
static const double tightest = 1e-13;
/* What an evaluation tells CVODE: to try a shorter step, or to stop. */
enum { RETRY = 1, STOP = -1 };

/* ω of Baumgarte's stabilisation by the order of Adams' method: the part of its region of stability that counts
 * (thesis table 3, theory 7). */
static double stability_limit(int order) {
  static const double limits[] = {2.0, 2.0, 2.26, 1.86, 1.4, 1.03, .78, .58, .44, .34, .26, .21, .06};
  return limits[order < 0 ? 0 : order > 12 ? 12 : order];
}

/* A step isn't made where accelerations are rounding. */
static int derivative(double t, N_Vector y, N_Vector ydot, void *data) {
  km_simulation *run = (km_simulation *)data;
  if (!km_simulation_derivative(run, t, NV_DATA_S(y), NV_DATA_S(ydot)))
    return RETRY;
  run->blind = run->unseeing == 0 && km_simulation_blindness(run, run->usual) > most_blindness;
  return run->blind ? STOP : 0;
}

/* 1 over the error that a component may have. */
static int weights(N_Vector y, N_Vector ewt, void *data) {
  const km_simulation *run = (const km_simulation *)data;
  const double *value = NV_DATA_S(y), *tolerance = run->tolerance;
  double *out = NV_DATA_S(ewt);
  for (int i = 0; i < run->size; ++i)
    out[i] = 1.0 / (run->def.relative * fabs(value[i]) + tolerance[i]);
  return 0;
}

static void silent(int code, const char *module, const char *function, char *text, void *data) {
  (void)code;
  (void)module;
  (void)function;
  (void)text;
  (void)data;
}

static bool start(km_simulation *run, km_cvode *c) {
  c->memory = CVodeCreate(run->stiff ? CV_BDF : CV_ADAMS, c->context);
  if (!c->memory || CVodeSetErrHandlerFn(c->memory, silent, NULL) ||
      CVodeInit(c->memory, derivative, run->time, c->y) || CVodeWFtolerances(c->memory, weights) ||
      CVodeSetUserData(c->memory, run) || CVodeSetMaxNumSteps(c->memory, -1))
    return false;
  if (isfinite(run->def.end) && CVodeSetStopTime(c->memory, run->def.end))
    return false;
  if (run->def.max_step > 0.0 && CVodeSetMaxStep(c->memory, run->def.max_step))
    return false;
  if (run->stiff) {
    run->dynamics->closing = tightest; /* its Jacobian is found by differences */
    c->matrix = SUNDenseMatrix(run->size, run->size, c->context);
    c->dense = c->matrix ? SUNLinSol_Dense(c->y, c->matrix, c->context) : NULL;
    return c->dense && !CVodeSetLinearSolver(c->memory, c->dense, c->matrix);
  }
  c->functional = SUNNonlinSol_FixedPoint(c->y, 0, c->context);
  return c->functional && !CVodeSetNonlinearSolver(c->memory, c->functional);
}

static void stop(km_cvode *c) {
  CVodeFree(&c->memory);
  if (c->functional)
    SUNNonlinSolFree(c->functional);
  if (c->dense)
    SUNLinSolFree(c->dense);
  if (c->matrix)
    SUNMatDestroy(c->matrix);
  c->functional = NULL;
  c->dense = NULL;
  c->matrix = NULL;
}

km_status km_cvode_create(km_simulation *run, km_error *error) {
  km_cvode *c = KM_NEW(km_cvode, 1);
  run->cvode = c;
  if (c && SUNContext_Create(NULL, &c->context) == 0) {
    c->y = N_VMake_Serial(run->size, run->y, c->context);
    c->at = N_VMake_Serial(run->size, run->at, c->context);
  }
  if (c && c->y)
    km_vector_use_lanes(c->y);
  return c && c->y && c->at && start(run, c) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the integrator");
}

void km_cvode_free(km_cvode *c) {
  if (!c)
    return;
  stop(c);
  if (c->y)
    N_VDestroy(c->y);
  if (c->at)
    N_VDestroy(c->at);
  SUNContext_Free(&c->context);
  km_free(c);
}

/* Over to BDF from the present vector, where Adams' functional iteration often fails. */
static bool look_for_stiffness(km_simulation *run) {
  km_cvode *c = run->cvode;
  long steps, failures;
  CVodeGetNumSteps(c->memory, &steps);
  CVodeGetNumNonlinSolvConvFails(c->memory, &failures);
  if (steps - c->seen_steps < STIFF_LOOK)
    return true;
  double h;
  CVodeGetLastStep(c->memory, &h);
  bool stiff = failures - c->seen_failures >= STIFF_FAILURES && run->def.end - run->time > few_steps * h;
  c->seen_steps = steps;
  c->seen_failures = failures;
  if (!stiff || run->stiff)
    return true;
  run->stiff = true;
  stop(c);
  return start(run, c);
}

static void adapt(km_simulation *run) {
  double h;
  int order;
  CVodeGetLastStep(run->cvode->memory, &h);
  CVodeGetLastOrder(run->cvode->memory, &order);
  km_simulation_shift(run);
  run->dynamics->omega = h > 0.0 ? 0.005 * stability_limit(order) / h : 0.0;
}

static km_status why(const km_simulation *run, int flag, double h, km_error *error) {
  if (run->outcome != KM_DYNAMICS_DONE)
    return km_dynamics_fail(run->dynamics, run->outcome, error);
  if (flag == CV_MEM_FAIL || flag == CV_MEM_NULL)
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  return km_fail(error, KM_DIVERGED, "the step fell to %g at time %g and its error is still too large", h, run->time);
}

/* One step over a pose where constraints lose their grip, whose evaluations lie before and behind it; and a new start. Of
 * several lengths the first that sees well, else the one that sees best, rather one whose end sees well. */
static bool pass_over(km_simulation *run) {
  double chosen = 0.0, least = HUGE_VAL, longest = most_motion / km_simulation_speed(run);
  bool over = false; /* `chosen` ends behind the pose */
  for (double h = run->usual; h < 20.0 * run->usual && h < longest && least > most_blindness; h *= 1.15) {
    double step = fmin(h, run->def.end - run->time), blindness, after;
    if (!(step > 0.0) || !km_collocation_try(run, step, &blindness, &after) || blindness > hopeless)
      continue;
    bool ends = after <= most_blindness || run->time + step >= run->def.end;
    if ((over && !ends) || (over == ends && !(blindness < least)))
      continue;
    chosen = step;
    least = ends ? blindness : fmax(blindness, 2.0 * most_blindness);
    over = ends;
    km_collocation_keep(run);
  }
  run->outcome = KM_DYNAMICS_DONE;
  return chosen > 0.0 && km_collocation_step(run, chosen) &&
         CVodeReInit(run->cvode->memory, run->time, run->cvode->y) == CV_SUCCESS;
}

km_status km_cvode_step(km_simulation *run, km_error *error) {
  km_cvode *c = run->cvode;
  double t = run->time, h = 0.0;
  run->outcome = KM_DYNAMICS_DONE;
  run->way = KM_STEP_CVODE;
  run->blind = false;
  int flag = CVode(c->memory, run->time + 1.0, c->y, &t, CV_ONE_STEP);
  if (flag < 0) {
    km_dynamics_outcome outcome = run->outcome;
    memcpy(run->y, run->good, (size_t)run->size * sizeof *run->y);
    if (run->usual > 0.0 && pass_over(run))
      return KM_OK;
    if (run->blind) {
      run->unseeing = UNSEEING;
      return CVodeReInit(c->memory, run->time, c->y) ? km_fail(error, KM_MEMORY, "out of memory for the integrator")
                                                     : km_cvode_step(run, error);
    }
    run->outcome = outcome;
    CVodeGetCurrentStep(c->memory, &h);
    return why(run, flag, h, error);
  }
  CVodeGetNumErrTestFails(c->memory, &run->rejected);
  CVodeGetLastStep(c->memory, &h);
  run->usual = fmax(h, 0.998 * run->usual);
  run->unseeing -= run->unseeing > 0;
  run->time = t;
  run->steps++;
  adapt(run);
  return look_for_stiffness(run) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the integrator");
}

bool km_cvode_between(const km_simulation *run, double time, double *y) {
  N_VSetArrayPointer(y, run->cvode->at);
  return CVodeGetDky(run->cvode->memory, time, 0, run->cvode->at) == CV_SUCCESS;
}
