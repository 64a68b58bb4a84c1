/* Compliant stops of joints at their limits, in statics and during a motion (docs/theory.md 11.8).
 *
 *   x beyond a limit, v its rate (0 in statics):   F = k x + b v, never pulling
 *   stored k x²/2,   dissipated (F − k x) v */
#include "forces/forces.h"

#include "base/arguments.h"
#include "kmech/dynamics.h"

static bool acts(const km_joint_stop *stop) {
  return stop->stiffness > 0.0 || stop->damping > 0.0;
}

static const km_joint_stop *own_stop(const km_mechanism *m, int c) {
  return &m->model->joints[m->model->coordinates[c].joint].stop;
}

/* True if the limits are those of one component of a ball. */
static bool limits_component(const km_mechanism *m, int c) {
  return m->ball_of[c] >= 0 && (isfinite(m->low[c]) || isfinite(m->high[c]));
}

/* Stop of a coordinate: its joint's own, else that of km_forces_set_limit_stops. */
static const km_joint_stop *stop_of(const km_forces *f, int c) {
  const km_joint_stop *own = own_stop(f->mechanism, c);
  return acts(own) || limits_component(f->mechanism, c) ? own : &f->limit_stop;
}

void km_stops_list(const km_mechanism *m, km_forces *f) {
  f->stop_count = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (!m->held[c] && acts(stop_of(f, c)) && km_is_limited(m, c))
      f->stops[f->stop_count++] = c;
}

/* Rejects stops of single components of a ball: a component's rate isn't conjugate to the torque about its axis, so
 * such a stop would not conserve energy. */
km_status km_stops_check(const km_mechanism *m, km_error *error) {
  for (int c = 0; c < m->coordinate_count; ++c)
    if (!m->held[c] && acts(own_stop(m, c)) && limits_component(m, c))
      return km_fail(error, KM_MODEL, "joint %s: a stop of one component of a ball; expected one range of its angle",
                     m->model->coordinates[c].label);
  return KM_OK;
}

km_status km_forces_set_limit_stops(km_forces *f, double stiffness, double damping, km_error *error) {
  km_status status = km_check_given(f != NULL, "forces", error);
  if (status)
    return status;
  if (f->moving)
    return km_fail(error, KM_USAGE, "equations of motion use the forces already; expected stops before these");
  if (!(stiffness > 0.0) || !isfinite(stiffness) || !(damping >= 0.0) || !isfinite(damping))
    return km_fail(error, KM_USAGE, "stiffness %g, damping %g; expected a positive one and one of at least 0",
                   stiffness, damping);
  f->limit_stop = (km_joint_stop){stiffness, damping};
  km_stops_list(f->mechanism, f);
  return KM_OK;
}

/* Excess of a coordinate over its limits: above (> 0) or below (< 0). */
static double beyond(const km_mechanism *m, const km_state *s, int c) {
  return s->q[c] > m->high[c] ? s->q[c] - m->high[c] : s->q[c] < m->low[c] ? s->q[c] - m->low[c] : 0.0;
}

/* Stop force k x + b v, never pulling; adds the power that isn't stored to the dissipation. */
static double stop_force(const km_joint_stop *stop, double x, double v, double *dissipation) {
  double force = stop->stiffness * x + stop->damping * v;
  force = force * x > 0.0 ? force : 0.0;
  *dissipation += (force - stop->stiffness * x) * v;
  return force;
}

/* Stop of a ball's angle |q|; its force acts along q/|q|, which is equal in both frames. */
static double add_stop_of_ball(const km_mechanism *m, const km_state *s, int c, bool moves, km_forces *f) {
  const km_joint_stop *stop = stop_of(f, c);
  double x = km_state_ball_excess(m, c, &s->q[c]);
  double dissipation = 0.0;
  if (!(x > 0.0))
    return 0.0;
  km_vec3 q = km_vec3_from_array(&s->q[c]), u = km_vec3_scale(1.0 / km_vec3_norm(q), q);
  double v = moves ? km_vec3_dot(u, km_vec3_from_array(&s->rate[c])) : 0.0;
  double force = stop_force(stop, x, v, &dissipation);
  f->joint[c] -= force * u.x;
  f->joint[c + 1] -= force * u.y;
  f->joint[c + 2] -= force * u.z;
  f->couple_size += force;
  return dissipation;
}

double km_stops_add(const km_mechanism *m, const km_state *s, bool moves, km_forces *f) {
  double dissipation = 0.0;
  for (int i = 0; i < f->stop_count; ++i) {
    int c = f->stops[i];
    double x = beyond(m, s, c);
    if (x != 0.0)
      km_forces_add_joint(m->model, f, c, -stop_force(stop_of(f, c), x, moves ? s->rate[c] : 0.0, &dissipation));
    dissipation += add_stop_of_ball(m, s, c, moves, f);
  }
  return dissipation;
}

double km_stop_excess(const km_mechanism *m, const km_state *s, int c) {
  return m->ball_of[c] < 0 ? beyond(m, s, c) : fmax(km_state_ball_excess(m, c, &s->q[c]), 0.0);
}

double km_stop_force(const km_mechanism *m, const km_state *s, const km_forces *f, int c) {
  return stop_of(f, c)->stiffness * km_stop_excess(m, s, c);
}

double km_stops_energy(const km_mechanism *m, const km_state *s, const km_forces *f) {
  double energy = 0.0;
  for (int i = 0; i < f->stop_count; ++i) {
    int c = f->stops[i];
    double x = beyond(m, s, c);
    double excess = fmax(km_state_ball_excess(m, c, &s->q[c]), 0.0);
    energy += 0.5 * stop_of(f, c)->stiffness * (x * x + excess * excess);
  }
  return energy;
}
