/* Steps of variable order and size by CVODE (A. Hindmarsh and others 2005): Adams with functional iteration, BDF
 * with Newton's method for stiff motions, and a collocation step over configurations with weak constraints
 * (docs/theory.md 11.5). */
#include "dynamics/integrator/bdf_newton.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <string.h>

struct km_cvode {
  SUNContext context;
  void *memory;
  N_Vector y, at; /* the run's vector, and one with the caller's data */
  SUNNonlinearSolver functional;
  km_newton *newton;
  bool change_due; /* a change to the other method is due */
};

/* Largest noise of a step, over the error allowed; noise above which a collocation step is useless. */
static const double max_noise = 0.1, useless_noise = 1e6;
/* Longest collocation step over a singular configuration, radians or characteristic lengths. */
static const double max_motion = 0.5;
/* Number of steps without a check of noise if no collocation step was possible. */
enum { UNCHECKED_STEPS = 50 };
/* Return codes for CVODE: success, recoverable failure (shorter step). */
enum { SUCCESS = 0, RECOVERABLE = 1 };

/* Right side for CVODE; fails where accelerations are dominated by rounding. */
static int derivative(double t, N_Vector y, N_Vector ydot, void *data) {
  km_simulation *run = (km_simulation *)data;
  if (run->outcome == KM_DYNAMICS_STOPPED || /* shorter steps fail, too, so that CVODE gives up */
      !km_simulation_derivative(run, t, NV_DATA_S(y), NV_DATA_S(ydot)))
    return RECOVERABLE;
  km_method_choice_evaluation(&run->choice, t, NV_DATA_S(y), NV_DATA_S(ydot), run->tolerance);
  if (run->unchecked || !(km_simulation_noise(run, run->typical_step) > max_noise))
    return SUCCESS;
  run->is_noisy = true;
  return RECOVERABLE;
}

/* Error weights: 1/(relative · |y_i| + absolute_i). */
static int weights(N_Vector y, N_Vector ewt, void *data) {
  const km_simulation *run = (const km_simulation *)data;
  const double *value = NV_DATA_S(y), *tolerance = run->tolerance;
  double *out = NV_DATA_S(ewt);
  for (int i = 0; i < run->size; ++i)
    out[i] = 1.0 / (run->def.relative * fabs(value[i]) + tolerance[i]);
  for (int i = run->work_start; i < run->work_start + run->work_count; ++i)
    out[i] = 1.0 / km_simulation_work_tolerance(run, value[i]);
  return 0;
}

static void ignore_error(int code, const char *module, const char *function, char *text, void *data) {
  (void)code;
  (void)module;
  (void)function;
  (void)text;
  (void)data;
}

/* Creates CVODE's memory for Adams or BDF at the present vector. */
static bool create_integrator(km_simulation *run, km_cvode *c) {
  bool bdf = run->choice.method == KM_BDF;
  c->memory = CVodeCreate(bdf ? CV_BDF : CV_ADAMS, c->context);
  if (!c->memory || CVodeSetErrHandlerFn(c->memory, ignore_error, NULL) ||
      CVodeInit(c->memory, derivative, run->time, c->y) || CVodeWFtolerances(c->memory, weights) ||
      CVodeSetUserData(c->memory, run) || CVodeSetMaxNumSteps(c->memory, -1))
    return false;
  if (run->def.max_step > 0.0 && CVodeSetMaxStep(c->memory, run->def.max_step))
    return false;
  if (bdf) {
    c->newton = km_newton_create(run, c->memory, c->context);
    return c->newton && !CVodeSetStabLimDet(c->memory, SUNTRUE);
  }
  c->functional = SUNNonlinSol_FixedPoint(c->y, 0, c->context);
  return c->functional && !CVodeSetNonlinearSolver(c->memory, c->functional);
}

static void free_integrator(km_cvode *c) {
  CVodeFree(&c->memory);
  if (c->functional)
    SUNNonlinSolFree(c->functional);
  km_newton_free(c->newton);
  c->functional = NULL;
  c->newton = NULL;
}

km_status km_cvode_create(km_simulation *run, km_error *error) {
  km_cvode *c = KM_NEW(km_cvode, 1);
  run->cvode = c;
  if (c && SUNContext_Create(NULL, &c->context) == 0) {
    c->y = N_VMake_Serial(run->size, run->y, c->context);
    c->at = N_VMake_Serial(run->size, run->at, c->context);
  }
  if (c && c->y && c->at) {
    km_vector_use_lanes(c->y);
    km_vector_use_lanes(c->at);
  }
  return c && c->y && c->at && create_integrator(run, c)
             ? KM_OK
             : km_fail(error, KM_MEMORY, "out of memory for the integrator");
}

void km_cvode_free(km_cvode *c) {
  if (!c)
    return;
  free_integrator(c);
  if (c->y)
    N_VDestroy(c->y);
  if (c->at)
    N_VDestroy(c->at);
  SUNContext_Free(&c->context);
  km_free(c);
}

/* Changes to the other method at the present vector. */
static bool change_method(km_simulation *run) {
  km_cvode *c = run->cvode;
  c->change_due = false;
  km_method_choice_change(&run->choice);
  free_integrator(c);
  return create_integrator(run, c);
}

/* Work so far, in evaluations: evaluations plus the equivalent of Newton's linear algebra. */
static double work_of(const km_simulation *run) {
  static const double operations = 64.0; /* operations of an evaluation per component */
  return (double)run->evaluations + run->operations / (operations * run->size);
}

/* Largest ω of Baumgarte's stabilisation at which the rounding of a loop error causes an acceleration within the
 * error allowed. Without this bound the first, very short steps would have a far larger ω. */
static double max_omega(const km_simulation *run) {
  static const double rounding = 1e-14;
  return sqrt(run->def.absolute / rounding) * run->dynamics->mechanism->model->units.time->si;
}

/* After a step: shift, ω of Baumgarte's stabilisation, and the choice of the method. */
static void update_step_control(km_simulation *run) {
  double h;
  int order;
  CVodeGetLastStep(run->cvode->memory, &h);
  CVodeGetLastOrder(run->cvode->memory, &order);
  km_simulation_shift(run);
  run->order = order;
  run->dynamics->omega = h > 0.0 ? fmin(0.005 * km_stability_limit(order) / h, max_omega(run)) : 0.0;
  const km_step_record step = {run->time, h, order, work_of(run)};
  run->cvode->change_due = km_method_choice_step(&run->choice, &step, run->tolerance);
}

static km_status report_failure(const km_simulation *run, int flag, double h, km_error *error) {
  if (run->outcome != KM_DYNAMICS_DONE)
    return km_dynamics_fail(run->dynamics, run->outcome, error);
  if (flag == CV_MEM_FAIL || flag == CV_MEM_NULL || run->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  return km_fail(error, KM_DIVERGED, "the step fell to %g at time %g and its error is still too large", h, run->time);
}

bool km_cvode_restart(km_simulation *run) {
  return CVodeReInit(run->cvode->memory, run->time, run->cvode->y) == CV_SUCCESS;
}

/* Passes over a configuration with weak constraints by one collocation step, whose stages lie before and after it,
 * and restarts CVODE. Takes the first step length with small noise, else the one with the least noise, preferring
 * steps whose end has small noise. */
static bool step_over_weak_constraints(km_simulation *run) {
  double chosen = 0.0, least = HUGE_VAL, longest = max_motion / km_simulation_speed(run);
  bool over = false; /* `chosen` ends after the configuration */
  for (double h = run->typical_step; h < 20.0 * run->typical_step && h < longest && least > max_noise; h *= 1.07) {
    double step = fmin(h, run->def.end - run->time), noise, after;
    if (!(step > 0.0) || !km_collocation_try(run, step, &noise, &after) || noise > useless_noise)
      continue;
    bool ends = after <= max_noise || run->time + step >= run->def.end;
    if ((over && !ends) || (over == ends && !(noise < least)))
      continue;
    chosen = step;
    least = ends ? noise : fmax(noise, 2.0 * max_noise);
    over = ends;
    km_collocation_keep(run);
  }
  run->outcome = KM_DYNAMICS_DONE;
  run->is_noisy = run->is_noisy && !(chosen > 0.0);
  return chosen > 0.0 && km_collocation_step(run, chosen) && km_cvode_restart(run);
}

/* Records an accepted step. */
static void accept_step(km_simulation *run, double t) {
  double h;
  CVodeGetNumErrTestFails(run->cvode->memory, &run->rejected);
  CVodeGetLastStep(run->cvode->memory, &h);
  run->typical_step = fmax(h, 0.998 * run->typical_step);
  run->unchecked -= run->unchecked > 0;
  run->time = t;
  run->steps++;
  km_simulation_update_works(run);
  update_step_control(run);
}

/* Continues for some steps without the check of noise. */
static bool continue_unchecked(km_simulation *run) {
  run->unchecked = UNCHECKED_STEPS;
  run->is_noisy = false;
  return km_cvode_restart(run);
}

/* Sets the end of the step: end of the run, next corner in time, or the time of a passed-over corner. */
static bool set_stop_time(km_simulation *run) {
  if (run->due_time <= run->time)
    run->due_time = HUGE_VAL;
  double time = fmin(fmin(run->def.end, run->due_time), km_corners_above(&run->corners, KM_CORNER_TIME, run->time));
  return !isfinite(time) || CVodeSetStopTime(run->cvode->memory, time) == CV_SUCCESS;
}

/* One step of CVODE. If it fails, the vector is restored. */
static int try_step(km_simulation *run) {
  double t = run->time;
  run->outcome = KM_DYNAMICS_DONE;
  run->step_method = KM_STEP_CVODE;
  run->is_noisy = false;
  if (!set_stop_time(run))
    return CV_MEM_NULL;
  int flag = CVode(run->cvode->memory, run->time + 1.0, run->cvode->y, &t, CV_ONE_STEP);
  if (flag >= 0 && !(t > run->time)) /* CVODE accepts steps so short that the time doesn't change */
    flag = CV_CONV_FAILURE;
  if (flag < 0)
    memcpy(run->y, run->accepted, (size_t)run->size * sizeof *run->y);
  else
    accept_step(run, t);
  return flag;
}

/* One step; before configurations with weak constraints a collocation step, after failures the other method. */
km_status km_cvode_step(km_simulation *run, km_error *error) {
  km_cvode *c = run->cvode;
  if (c->change_due && !change_method(run)) /* not earlier: dense output needs this method's history */
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  if (run->is_noisy && step_over_weak_constraints(run)) /* CVODE approached the configuration by ever shorter steps */
    return KM_OK;
  if (run->is_noisy && !continue_unchecked(run))
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  int flag = try_step(run);
  if (flag >= 0)
    return KM_OK;
  km_dynamics_outcome outcome = run->outcome;
  if (outcome == KM_DYNAMICS_STOPPED)
    return km_dynamics_fail(run->dynamics, outcome, error);
  if (run->typical_step > 0.0 && step_over_weak_constraints(run))
    return KM_OK;
  if (run->is_noisy && continue_unchecked(run))
    return km_cvode_step(run, error);
  c->change_due = km_method_choice_failure(&run->choice);
  if (c->change_due)
    return km_cvode_step(run, error);
  double h;
  run->outcome = outcome;
  CVodeGetCurrentStep(c->memory, &h);
  return report_failure(run, flag, h, error);
}

bool km_cvode_interpolate(const km_simulation *run, double time, double *y) {
  N_VSetArrayPointer(y, run->cvode->at);
  return CVodeGetDky(run->cvode->memory, time, 0, run->cvode->at) == CV_SUCCESS;
}
