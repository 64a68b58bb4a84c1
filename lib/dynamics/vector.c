/* The integrator's vector: from and to the state, and its derivative. */
#include "dynamics/simulation.h"

#include <string.h>

void km_simulation_unpack(km_simulation *run, const double *y, double time) {
  const km_mechanism *m = run->dynamics->mechanism;
  km_state *s = run->state;
  const double *rate = y + run->rate_start;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->ball_of[c] < 0)
      s->q[c] = y[run->place[c]];
    s->rate[c] = rate[c];
  }
  for (int b = 0; b < m->ball_count; ++b) {
    const double *q = y + run->place[m->ball_coordinate[b]];
    s->ball[b] = km_quaternion_normalised((km_quaternion){q[0], q[1], q[2], q[3]});
  }
  s->time = time;
  const km_moving_forces *moving = run->dynamics->forces->moving;
  memcpy(moving->memory, y + run->memory_start, (size_t)moving->memory_count * sizeof *y);
}

void km_simulation_pack(km_simulation *run, double *y) {
  const km_mechanism *m = run->dynamics->mechanism;
  const km_state *s = run->state;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->ball_of[c] < 0)
      y[run->place[c]] = s->q[c];
  for (int b = 0; b < m->ball_count; ++b) {
    const km_quaternion *q = &s->ball[b];
    double *to = y + run->place[m->ball_coordinate[b]];
    to[0] = q->w;
    to[1] = q->x;
    to[2] = q->y;
    to[3] = q->z;
  }
  memcpy(y + run->rate_start, s->rate, (size_t)m->coordinate_count * sizeof *y);
}

/* q̇ = ½ ω q, and what draws the vector's quaternion to the closed one (on its side of the sphere). */
static void ball_derivative(const km_simulation *run, int ball, const double *y, double *ydot) {
  const km_state *s = run->state;
  const double *w = &s->rate[run->dynamics->mechanism->ball_coordinate[ball]];
  km_quaternion q = s->ball[ball], d = km_quaternion_product((km_quaternion){0.0, w[0], w[1], w[2]}, q);
  double same = q.w * y[0] + q.x * y[1] + q.y * y[2] + q.z * y[3] < 0.0 ? -1.0 : 1.0;
  const double closed[4] = {same * q.w, same * q.x, same * q.y, same * q.z};
  const double rate[4] = {same * d.w, same * d.x, same * d.y, same * d.z};
  for (int i = 0; i < 4; ++i)
    ydot[i] = 0.5 * rate[i] + run->pull * (closed[i] - y[i]);
}

bool km_simulation_derivative(km_simulation *run, double time, const double *y, double *ydot) {
  km_dynamics *d = run->dynamics;
  const km_mechanism *m = d->mechanism;
  const km_state *s = run->state;
  run->evaluations++;
  km_simulation_unpack(run, y, time);
  km_dynamics_outcome outcome = km_dynamics_evaluate(d, run->state, false);
  if (outcome != KM_DYNAMICS_DONE) {
    run->outcome = outcome;
    return false;
  }
  const double *rate = y + run->rate_start;
  double *acceleration = ydot + run->rate_start;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->ball_of[c] < 0)
      ydot[run->place[c]] = s->rate[c] + run->pull * (s->q[c] - y[run->place[c]]);
    acceleration[c] = m->held[c] ? 0.0 : s->acceleration[c] + run->pull * (s->rate[c] - rate[c]);
  }
  for (int b = 0; b < m->ball_count; ++b) {
    int place = run->place[m->ball_coordinate[b]];
    ball_derivative(run, b, y + place, ydot + place);
  }
  const km_moving_forces *moving = d->forces->moving;
  memcpy(ydot + run->memory_start, moving->rate, (size_t)moving->memory_count * sizeof *ydot);
  double sum = 0.0; /* not finite where any acceleration isn't */
  for (int c = 0; c < m->coordinate_count; ++c)
    sum += acceleration[c];
  if (!isfinite(sum)) {
    run->outcome = KM_DYNAMICS_OPEN;
    return false;
  }
  ydot[run->work_start] = moving->dissipation;
  ydot[run->work_start + 1] = moving->motor_power + km_dynamics_driving_power(d, s);
  return true;
}

bool km_simulation_settle(km_simulation *run, double *y, double time, bool keep) {
  km_simulation_unpack(run, y, time);
  run->outcome = km_dynamics_evaluate(run->dynamics, run->state, true);
  if (run->outcome == KM_DYNAMICS_DONE && keep)
    km_simulation_pack(run, y);
  return run->outcome == KM_DYNAMICS_DONE;
}
