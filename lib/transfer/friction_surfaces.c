/* Friction surfaces of joints (theory 8.5). A screw with a square thread of mean radius r and lead angle λ under a
 * thrust F has the torque F r tan(λ ± φ), tan φ = μ (R. Budynas, J. Nisbett, Shigley's Mechanical Engineering Design,
 * 8-2). */
#include "transfer/friction_surfaces.h"

static const km_model_joint *joint_of(const km_mechanism *m, int c) {
  return &m->model->joints[m->model->coordinates[c].joint];
}

/* True if the coordinate rotates about an axis along which its joint does not slide. */
static bool is_hinge(const km_mechanism *m, int c) {
  km_joint_type type = joint_of(m, c)->type;
  return type == KM_RX || type == KM_RY || type == KM_RZ || type == KM_UNIVERSAL;
}

int km_surfaces_list(const km_mechanism *m, km_surface *out) {
  int count = 0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (m->held[c] || !(joint_of(m, c)->friction.coefficient > 0.0) || km_slip_arm(m, c) == 0.0)
      continue;
    out[count++] = (km_surface){c, false};
    if (is_hinge(m, c))
      out[count++] = (km_surface){c, true};
  }
  return count;
}

double km_thread_slope(const km_mechanism *m, int c) {
  const km_model_joint *joint = joint_of(m, c);
  double radius = joint->friction.radius;
  return joint->type == KM_SCREW && radius > 0.0 ? joint->pitch / (2.0 * M_PI * radius) : 0.0;
}

double km_slip_arm(const km_mechanism *m, int c) {
  return km_model_coordinate_is_length(m->model, c)
             ? 1.0
             : joint_of(m, c)->friction.radius * hypot(1.0, km_thread_slope(m, c));
}

double km_slip_speed(const km_mechanism *m, const double *rates, int c) {
  const km_model_joint *joint = joint_of(m, c);
  const int first = joint->first_coordinate;
  if (m->ball_of[c] >= 0)
    return km_slip_arm(m, c) * km_vec3_norm(km_vec3_from_array(rates + m->ball_coordinate[m->ball_of[c]]));
  if (joint->type == KM_CYLINDRICAL || (joint->type == KM_PLANAR && m->model->coordinates[c].index < 2))
    return hypot(km_slip_arm(m, first) * rates[first], km_slip_arm(m, first + 1) * rates[first + 1]);
  return km_slip_arm(m, c) * fabs(rates[c]);
}

km_vec3 km_surface_axis(const km_statics *st, int c) {
  const km_twist *h = &st->work->twist[c];
  return km_vec3_norm(h->w) > 0.5 ? h->w : h->v;
}

km_vec3 km_surface_load(const km_mechanism *m, const km_statics *st, const km_surface *surface) {
  int c = surface->coordinate;
  const km_model_joint *joint = joint_of(m, c);
  km_vec3 force = km_vec3_from_array(st->reactions[m->model->coordinates[c].joint].force);
  km_vec3 axis = km_surface_axis(st, joint->type == KM_PLANAR ? joint->first_coordinate + 2 : c);
  double along = km_vec3_dot(force, axis);
  if (m->ball_of[c] >= 0)
    return force;
  if (joint->type == KM_PLANAR || surface->is_collar)
    return km_vec3_scale(along, axis);
  if (joint->type == KM_SCREW)
    return km_vec3_axpy((hypot(1.0, km_thread_slope(m, c)) - 1.0) * along, axis, force);
  return km_vec3_axpy(-along, axis, force);
}

double km_surface_normal(const km_mechanism *m, const km_statics *st, const km_surface *surface, double friction) {
  km_vec3 load = km_surface_load(m, st, surface);
  double k = friction * km_thread_slope(m, surface->coordinate), square = km_vec3_dot(load, load);
  if (k == 0.0 || square == 0.0)
    return sqrt(square);
  /* (1 - k²) N² - 2 k A N - |v|² = 0, A the part of v along the axis; the root that is |v| for k = 0. */
  double a = k * km_vec3_dot(load, km_surface_axis(st, surface->coordinate));
  double below = sqrt(a * a + (1.0 - k * k) * square) - a;
  return below > 0.0 ? square / below : HUGE_VAL;
}
