/* Steps of variable order and length by SUNDIALS' CVODE (A. Hindmarsh and others, 2005): Adams with functional
 * iteration, and BDF with Newton's method where the motion is stiff. */
#include "dynamics/integrator/bdf_newton.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <string.h>

struct km_cvode {
  SUNContext context;
  void *memory;
  N_Vector y, at; /* the run's vector, and one whose numbers are the caller's */
  SUNNonlinearSolver functional;
  km_newton *newton;
  bool due; /* the other method's turn has come */
};

/* What rounding may make of a step, over the error allowed. */
static const double most_noise = 0.1, useless_noise = 1e6;
/* The longest step over a singular pose: radians or characteristic lengths. */
static const double most_motion = 0.5;
/* Steps that are made as they come where there was no such step. */
enum { UNCHECKED_STEPS = 50 };
/* What an evaluation tells CVODE: to go on, or to try a shorter step. */
enum { GO_ON = 0, RETRY = 1 };

/* A step isn't made where accelerations are rounding. */
static int derivative(double t, N_Vector y, N_Vector ydot, void *data) {
  km_simulation *run = (km_simulation *)data;
  if (!km_simulation_derivative(run, t, NV_DATA_S(y), NV_DATA_S(ydot)))
    return RETRY;
  km_choice_see(&run->choice, t, NV_DATA_S(y), NV_DATA_S(ydot), run->tolerance);
  if (run->unchecked || !(km_simulation_noise(run, run->usual) > most_noise))
    return GO_ON;
  run->noisy = true;
  return RETRY;
}

/* 1 over the error that a component may have. */
static int weights(N_Vector y, N_Vector ewt, void *data) {
  const km_simulation *run = (const km_simulation *)data;
  const double *value = NV_DATA_S(y), *tolerance = run->tolerance;
  double *out = NV_DATA_S(ewt);
  for (int i = 0; i < run->size; ++i)
    out[i] = 1.0 / (run->def.relative * fabs(value[i]) + tolerance[i]);
  for (int i = run->work_start; i < run->work_start + KM_WORKS; ++i)
    out[i] = 1.0 / km_simulation_work_tolerance(run, value[i]);
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
  bool bdf = run->choice.method == KM_BDF;
  c->memory = CVodeCreate(bdf ? CV_BDF : CV_ADAMS, c->context);
  if (!c->memory || CVodeSetErrHandlerFn(c->memory, silent, NULL) ||
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

static void stop(km_cvode *c) {
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

/* The other method from the present vector on. */
static bool change_method(km_simulation *run) {
  km_cvode *c = run->cvode;
  c->due = false;
  km_choice_change(&run->choice);
  stop(c);
  return start(run, c);
}

/* Evaluations so far, and as many as have taken the time of what Newton's method computed beside them. */
static double work_of(const km_simulation *run) {
  static const double operations = 64.0; /* of an evaluation, a component */
  return (double)run->evaluations + run->operations / (operations * run->size);
}

/* The ω with which the rounding of a loop's error stays an acceleration within the error allowed: the first steps, which
 * are very short, would ask for far more. */
static double firmest(const km_simulation *run) {
  static const double rounding = 1e-14;
  return sqrt(run->def.absolute / rounding) * run->dynamics->mechanism->model->units.time->si;
}

static void adapt(km_simulation *run) {
  double h;
  int order;
  CVodeGetLastStep(run->cvode->memory, &h);
  CVodeGetLastOrder(run->cvode->memory, &order);
  km_simulation_shift(run);
  run->dynamics->omega = h > 0.0 ? fmin(0.005 * km_stability_limit(order) / h, firmest(run)) : 0.0;
  const km_taken_step step = {run->time, h, order, work_of(run)};
  run->cvode->due = km_choice_step(&run->choice, &step, run->tolerance);
}

static km_status why(const km_simulation *run, int flag, double h, km_error *error) {
  if (run->outcome != KM_DYNAMICS_DONE)
    return km_dynamics_fail(run->dynamics, run->outcome, error);
  if (flag == CV_MEM_FAIL || flag == CV_MEM_NULL || run->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  return km_fail(error, KM_DIVERGED, "the step fell to %g at time %g and its error is still too large", h, run->time);
}

bool km_cvode_restart(km_simulation *run) {
  return CVodeReInit(run->cvode->memory, run->time, run->cvode->y) == CV_SUCCESS;
}

/* One step over a pose where constraints lose their grip, whose evaluations lie before and behind it; and a new start. Of
 * several lengths the first that sees well, else the one that sees best, rather one whose end sees well. */
static bool pass_over(km_simulation *run) {
  double chosen = 0.0, least = HUGE_VAL, longest = most_motion / km_simulation_speed(run);
  bool over = false; /* `chosen` ends behind the pose */
  for (double h = run->usual; h < 20.0 * run->usual && h < longest && least > most_noise; h *= 1.07) {
    double step = fmin(h, run->def.end - run->time), noise, after;
    if (!(step > 0.0) || !km_collocation_try(run, step, &noise, &after) || noise > useless_noise)
      continue;
    bool ends = after <= most_noise || run->time + step >= run->def.end;
    if ((over && !ends) || (over == ends && !(noise < least)))
      continue;
    chosen = step;
    least = ends ? noise : fmax(noise, 2.0 * most_noise);
    over = ends;
    km_collocation_keep(run);
  }
  run->outcome = KM_DYNAMICS_DONE;
  run->noisy = run->noisy && !(chosen > 0.0);
  return chosen > 0.0 && km_collocation_step(run, chosen) && km_cvode_restart(run);
}

static void accept_step(km_simulation *run, double t) {
  double h;
  CVodeGetNumErrTestFails(run->cvode->memory, &run->rejected);
  CVodeGetLastStep(run->cvode->memory, &h);
  run->usual = fmax(h, 0.998 * run->usual);
  run->unchecked -= run->unchecked > 0;
  run->time = t;
  run->steps++;
  km_simulation_watch_works(run);
  adapt(run);
}

/* Some steps as they come, however much of them is rounding. */
static bool go_on_unchecked(km_simulation *run) {
  run->unchecked = UNCHECKED_STEPS;
  run->noisy = false;
  return km_cvode_restart(run);
}

/* A step ends where the run does, where a law in time has a corner, and where one before has passed over something. */
static bool set_stop_time(km_simulation *run) {
  if (run->due_time <= run->time)
    run->due_time = HUGE_VAL;
  double time = fmin(fmin(run->def.end, run->due_time), km_corners_next(&run->corners, run->time));
  return !isfinite(time) || CVodeSetStopTime(run->cvode->memory, time) == CV_SUCCESS;
}

/* A step of CVODE. Where it couldn't be made, the vector is as it was. */
static int try_step(km_simulation *run) {
  double t = run->time;
  run->outcome = KM_DYNAMICS_DONE;
  run->way = KM_STEP_CVODE;
  run->noisy = false;
  if (!set_stop_time(run))
    return CV_MEM_NULL;
  int flag = CVode(run->cvode->memory, run->time + 1.0, run->cvode->y, &t, CV_ONE_STEP);
  if (flag < 0)
    memcpy(run->y, run->good, (size_t)run->size * sizeof *run->y);
  else
    accept_step(run, t);
  return flag;
}

km_status km_cvode_step(km_simulation *run, km_error *error) {
  km_cvode *c = run->cvode;
  if (c->due && !change_method(run)) /* not before: between steps the past of this method is asked for */
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  if (run->noisy && pass_over(run)) /* CVODE has come near, by steps that became shorter */
    return KM_OK;
  if (run->noisy && !go_on_unchecked(run))
    return km_fail(error, KM_MEMORY, "out of memory for the integrator");
  int flag = try_step(run);
  if (flag >= 0)
    return KM_OK;
  km_dynamics_outcome outcome = run->outcome;
  if (run->usual > 0.0 && pass_over(run))
    return KM_OK;
  if (run->noisy && go_on_unchecked(run))
    return km_cvode_step(run, error);
  c->due = km_choice_fail(&run->choice);
  if (c->due)
    return km_cvode_step(run, error);
  double h;
  run->outcome = outcome;
  CVodeGetCurrentStep(c->memory, &h);
  return why(run, flag, h, error);
}

bool km_cvode_between(const km_simulation *run, double time, double *y) {
  N_VSetArrayPointer(y, run->cvode->at);
  return CVodeGetDky(run->cvode->memory, time, 0, run->cvode->at) == CV_SUCCESS;
}
