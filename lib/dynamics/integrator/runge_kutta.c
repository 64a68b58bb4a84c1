/* Fixed steps of the classical Runge-Kutta method of order 4, with the loops closed after each step: bounded work
 * per step. */
#include "dynamics/simulation.h"

#include <math.h>
#include <string.h>

/* out = y + h · slope. */
static void combine(const km_simulation *run, const double *slope, double h, double *out) {
  for (int i = 0; i < run->size; ++i)
    out[i] = run->y[i] + h * slope[i];
}

/* One step of the classical Runge-Kutta method, with the loops closed at its end. */
static bool make_step(km_simulation *run, double h, double to) {
  size_t n = (size_t)run->size;
  double *k1 = run->stage, *k2 = k1 + n, *k3 = k2 + n, *k4 = k3 + n, *at = k4 + n, t = run->time;
  bool is_ok = km_simulation_derivative(run, t, run->y, k1);
  combine(run, k1, 0.5 * h, at);
  is_ok = is_ok && km_simulation_derivative(run, t + 0.5 * h, at, k2);
  combine(run, k2, 0.5 * h, at);
  is_ok = is_ok && km_simulation_derivative(run, t + 0.5 * h, at, k3);
  combine(run, k3, h, at);
  is_ok = is_ok && km_simulation_derivative(run, t + h, at, k4);
  for (size_t i = 0; i < n && is_ok; ++i)
    at[i] = run->y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
  if (!is_ok || !km_simulation_accept(run, at, t + h, true))
    return false;
  memcpy(run->before, run->y, n * sizeof *at);
  memcpy(run->slope, k1, n * sizeof *at);
  memcpy(run->y, at, n * sizeof *at);
  run->time = to;
  run->steps++;
  return true;
}

/* Steps end at origin + n h, so that rounding doesn't accumulate; the first one after a restart is shorter. */
km_status km_fixed_step(km_simulation *run, km_error *error) {
  static const double least = 1e-6; /* a shorter rest, in steps, is added to the next step */
  double h = run->def.max_step, to = run->origin + h * (floor((run->time - run->origin) / h + least) + 1.0);
  if (run->def.end - to < least * h)
    to = run->def.end;
  run->step_method = KM_STEP_RUNGE_KUTTA;
  run->order = 4;
  return make_step(run, to - run->time, to) ? KM_OK : km_dynamics_fail(run->dynamics, run->outcome, error);
}

/* Quadratic interpolant with the values at both ends and the slope at the first one, for output between steps. */
void km_fixed_interpolate(const km_simulation *run, double time, double *y) {
  double h = run->time - run->last_time, x = (time - run->last_time) / h;
  for (int i = 0; i < run->size; ++i) {
    double change = run->y[i] - run->before[i], slope = h * run->slope[i];
    y[i] = run->before[i] + x * slope + x * x * (change - slope);
  }
}
