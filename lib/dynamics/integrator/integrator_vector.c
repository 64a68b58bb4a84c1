/* The integrator's vector y: conversion to and from the state, and its derivative.
 *
 *   y = (coordinates, quaternions of balls; rates; internal states of forces; dissipated work, motor work)
 *   state = y + shift
 *
 * Dependent coordinates of the vector drift within the error allowed; an evaluation closes the loops from them and
 * uses nothing else of them. After a repartition some of them become independent, and the motion would jump to
 * their drifted values. Therefore the state continues unchanged and the difference is stored in `shift`. A constant
 * offset has no derivative, so the integrator's history remains valid (docs/theory.md 11.3). */
#include "dynamics/simulation.h"

#include <string.h>

static const double loose = 10.0; /* weakness of constraints up to which rounding isn't examined */

/* Sets the state from the vector plus shift. */
void km_simulation_unpack(km_simulation *run, const double *y, double time) {
  const km_mechanism *m = run->dynamics->mechanism;
  km_state *s = run->state;
  double *shifted = run->shifted;
  for (int i = 0; i < run->size; ++i)
    shifted[i] = y[i] + run->shift[i];
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->ball_of[c] < 0)
      s->q[c] = shifted[run->value_index[c]];
    s->rate[c] = shifted[run->rate_start + c];
  }
  for (int b = 0; b < m->ball_count; ++b) {
    const double *q = shifted + run->value_index[m->ball_coordinate[b]];
    km_state_set_ball(m, s, b, (km_quaternion){q[0], q[1], q[2], q[3]});
  }
  s->time = time;
  const km_moving_forces *moving = run->dynamics->forces->moving;
  memcpy(moving->internal_state, shifted + run->memory_start, (size_t)moving->state_count * sizeof *y);
}

void km_simulation_locate_bodies(km_simulation *run, const double *y, double time) {
  km_simulation_unpack(run, y, time);
  km_tree_update(run->dynamics, run->state);
  km_dynamics_locate_bodies(run->dynamics);
}

/* Copies the state's coordinates and rates to `closed`; of q and −q of a ball, the one closer to `shifted`. */
static void copy_state(km_simulation *run) {
  const km_mechanism *m = run->dynamics->mechanism;
  const km_state *s = run->state;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->ball_of[c] < 0)
      run->closed[run->value_index[c]] = s->q[c];
  for (int b = 0; b < m->ball_count; ++b) {
    const km_quaternion *q = &s->ball[b];
    int value_index = run->value_index[m->ball_coordinate[b]];
    const double *y = run->shifted + value_index;
    double same = q->w * y[0] + q->x * y[1] + q->y * y[2] + q->z * y[3] < 0.0 ? -1.0 : 1.0;
    const double values[4] = {same * q->w, same * q->x, same * q->y, same * q->z};
    memcpy(run->closed + value_index, values, sizeof values);
  }
  memcpy(run->closed + run->rate_start, s->rate, (size_t)m->coordinate_count * sizeof *s->rate);
}

/* Copies the closed state to `closed`. */
static void keep_closed(km_simulation *run) {
  copy_state(run);
  if (run->dynamics->changed_pivots)
    km_simulation_shift(run);
}

/* Evaluates the accelerations at a time; the closed state is in `closed`. */
static km_dynamics_outcome evaluate(km_simulation *run, double time, const double *y, bool search) {
  km_simulation_unpack(run, y, time);
  run->outcome = km_dynamics_evaluate(run->dynamics, run->state, search);
  if (run->outcome == KM_DYNAMICS_DONE)
    keep_closed(run);
  return run->outcome;
}

bool km_simulation_close(km_simulation *run, double time, const double *y) {
  km_simulation_unpack(run, y, time);
  run->outcome = km_dynamics_close(run->dynamics, run->state, false);
  if (run->outcome == KM_DYNAMICS_DONE && run->dynamics->weakness > loose)
    run->outcome = km_dynamics_accelerate_closed(run->dynamics, run->state, false);
  if (run->outcome == KM_DYNAMICS_DONE)
    keep_closed(run);
  return run->outcome == KM_DYNAMICS_DONE;
}

void km_simulation_shift(km_simulation *run) {
  for (int i = 0; i < run->memory_start; ++i) {
    run->shift[i] += run->closed[i] - run->shifted[i];
    run->shifted[i] = run->closed[i];
  }
}

void km_simulation_pack(km_simulation *run, double *y) {
  copy_state(run);
  for (int i = 0; i < run->memory_start; ++i)
    y[i] = run->closed[i] - run->shift[i];
}

/* Derivative of coordinates and rates: q̇ (½ ω q for balls) and q̈. False: not finite. */
static bool differentiate(km_simulation *run, double *ydot) {
  const km_mechanism *m = run->dynamics->mechanism;
  const km_state *s = run->state;
  double sum = 0.0; /* not finite if any acceleration isn't */
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->ball_of[c] < 0)
      ydot[run->value_index[c]] = s->rate[c];
    ydot[run->rate_start + c] = m->held[c] ? 0.0 : s->acceleration[c];
    sum += ydot[run->rate_start + c];
  }
  for (int b = 0; b < m->ball_count; ++b) {
    const double *w = &s->rate[m->ball_coordinate[b]], *q = run->closed + run->value_index[m->ball_coordinate[b]];
    km_quaternion rate =
        km_quaternion_product((km_quaternion){0.0, w[0], w[1], w[2]}, (km_quaternion){q[0], q[1], q[2], q[3]});
    const double half[4] = {0.5 * rate.w, 0.5 * rate.x, 0.5 * rate.y, 0.5 * rate.z};
    memcpy(ydot + run->value_index[m->ball_coordinate[b]], half, sizeof half);
  }
  return isfinite(sum);
}

/* Right side of the ordinary differential equations: rates, accelerations, internal rates, powers. */
bool km_simulation_derivative(km_simulation *run, double time, const double *y, double *ydot) {
  km_dynamics *d = run->dynamics;
  km_dynamics_outcome outcome = run->outcome;
  run->evaluations++;
  if (evaluate(run, time, y, false) != KM_DYNAMICS_DONE)
    return false;
  run->outcome = outcome;
  if (!differentiate(run, ydot)) {
    run->outcome = KM_DYNAMICS_INFINITE;
    return false;
  }
  const km_moving_forces *moving = d->forces->moving;
  memcpy(ydot + run->memory_start, moving->internal_rate, (size_t)moving->state_count * sizeof *ydot);
  ydot[run->work_start] = moving->dissipation;
  ydot[run->work_start + 1] = moving->motor_power + km_dynamics_driving_power(d, run->state);
  for (int i = KM_WORKS; i < run->work_count; ++i)
    ydot[run->work_start + i] = d->forces->report[i - KM_WORKS].power;
  for (int i = run->work_start + run->work_count; i < run->size; ++i)
    ydot[i] = 0.0;
  return true;
}

bool km_simulation_accept(km_simulation *run, double *y, double time, bool keep) {
  if (evaluate(run, time, y, true) != KM_DYNAMICS_DONE)
    return false;
  if (keep)
    km_simulation_pack(run, y);
  return true;
}

double km_simulation_speed(const km_simulation *run) {
  const km_mechanism *m = run->dynamics->mechanism;
  double speed = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c)
    speed = fmax(speed, m->scale[c] * fabs(run->state->rate[c]));
  return speed;
}

double km_simulation_noise(const km_simulation *run, double h) {
  static const double rounding = 3e-15;
  const km_mechanism *m = run->dynamics->mechanism;
  double perturbation = 0.0, w = run->dynamics->weakness;
  if (!(w > loose))
    return 0.0;
  double speed = km_simulation_speed(run);
  for (int c = 0; c < m->coordinate_count; ++c)
    perturbation = fmax(perturbation, m->scale[c] * fabs(run->state->acceleration[c]));
  return rounding * w * w * fmax(speed * speed, perturbation) * h / (run->def.absolute + run->def.relative * speed);
}
