/* Fiala's tyre on a plane with relaxation of both slips (E. Fiala 1954; K. Wehage 2016, section 7.4; docs/theory.md
 * 11.10).
 *
 *   μ = μ_max − (μ_max − μ_min) s_s,  s_s = min(1, √(s_x² + tan²α));   F_z = k_z depth − b_z v_z ≥ 0
 *   ṡ_x = −(v_sx + |v_x| s_x)/x_RL,   α̇ = (v_y − |v_x| tan α)/y_RL
 *   F_x = C_s s_x  for |s_x| ≤ μF_z/(2 C_s),  else  sgn(s_x) (μF_z − (μF_z)²/(4 |s_x| C_s))
 *   H = 1 − C_α |tan α|/(3 μF_z),  F_y = −μF_z (1 − H³) sgn α,  M_z = μF_z w (1 − H) H³ sgn α;   M_y = −C_R F_z s(r ω)
 *
 * s_x longitudinal slip, α lateral slip angle, C_s and C_α stiffnesses, x_RL and y_RL relaxation lengths. The road
 * is the plane z = 0 of the parent frame; the wheel rotates about y of the child frame; x points in the rolling
 * direction of a positive rotation. */
#include "forces/motion_forces.h"

typedef struct tyre_contact {
  km_vec3 x, y, z, point, center; /* rolling, lateral and normal direction; contact point; wheel centre */
  double depth, vx, vy, vz, vsx;  /* penetration; velocities of the contact point below the wheel centre, and
                                   * longitudinal slip velocity */
  double spin;
} tyre_contact;

/* Contact of the wheel with the road plane: directions, contact point, penetration, velocities. */
static tyre_contact find_contact(const km_mechanism *m, const km_forces *f, const km_model_module *module) {
  const km_model_frame *road = &m->model->frames[module->output.frame[0]];
  const km_model_frame *wheel = &m->model->frames[module->output.frame[1]];
  km_pose R = km_pose_product(&f->pose[road->body], &road->pose);
  km_pose W = km_pose_product(&f->pose[wheel->body], &wheel->pose);
  km_twist v = km_twist_axpy(-1.0, f->twist[road->body], f->twist[wheel->body]);
  tyre_contact c = {.z = R.R.axis[2], .center = W.p};
  km_vec3 axle = W.R.axis[1], x = km_vec3_cross(axle, c.z);
  double upright = km_vec3_norm(x), height = km_vec3_dot(c.z, km_vec3_sub(W.p, R.p));
  if (!(upright > 1e-6)) /* the wheel lies flat */
    return c;
  c.x = km_vec3_scale(1.0 / upright, x);
  c.y = km_vec3_cross(c.z, c.x);
  /* Contact point: lowest point of the disc, in the wheel's plane. */
  km_vec3 up = km_vec3_cross(c.x, axle);
  double reach = height / upright;
  c.depth = module->tire.radius - reach;
  c.point = km_vec3_axpy(-reach, up, c.center);
  km_vec3 centre_speed = km_vec3_add(v.v, km_vec3_cross(v.w, c.center));
  c.spin = km_vec3_dot(v.w, axle);
  km_vec3 carried = km_vec3_axpy(-c.spin, axle, v.w); /* angular velocity without spin: the contact point stays below
                                                       * the centre */
  km_vec3 speed = km_vec3_add(centre_speed, km_vec3_cross(carried, km_vec3_sub(c.point, c.center)));
  c.vx = km_vec3_dot(c.x, speed);
  c.vy = km_vec3_dot(c.y, speed);
  c.vz = km_vec3_dot(c.z, centre_speed);
  c.vsx = c.vx - c.spin * reach;
  return c;
}

static double sign_of(double x) {
  return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0;
}

/* Tyre forces from load and slips, and the rates of both slips. */
void km_tire_apply(const km_mechanism *m, km_forces *f, int index) {
  km_moving_forces *moving = f->moving;
  const km_model_module *module = moving->modules[index];
  const km_tire *tire = &module->tire;
  double *state = moving->internal_state + moving->first_state_of[index],
         *rate = moving->internal_rate + moving->first_state_of[index];
  tyre_contact c = find_contact(m, f, module);
  double load = c.depth > 0.0 ? tire->stiffness * c.depth - tire->damping * c.vz : 0.0;
  load = load > 0.0 ? load : 0.0;
  double sx = state[0], tangent = tan(state[1]);
  rate[0] = -(c.vsx + fabs(c.vx) * sx) / tire->relaxation[0];
  rate[1] = (c.vy - fabs(c.vx) * tangent) / tire->relaxation[1];
  if (!(load > 0.0))
    return;
  double slip = fmin(1.0, sqrt(sx * sx + tangent * tangent));
  double limit = (tire->friction_peak - (tire->friction_peak - tire->friction_sliding) * slip) * load;
  double fx = fabs(sx) <= limit / (2.0 * tire->longitudinal)
                  ? tire->longitudinal * sx
                  : sign_of(sx) * (limit - limit * limit / (4.0 * fabs(sx) * tire->longitudinal));
  double fy = -limit * sign_of(tangent), mz = 0.0;
  if (fabs(tangent) < 3.0 * limit / tire->lateral) {
    double H = 1.0 - tire->lateral * fabs(tangent) / (3.0 * limit);
    fy = -limit * (1.0 - H * H * H) * sign_of(tangent);
    mz = limit * tire->width * (1.0 - H) * H * H * H * sign_of(tangent);
  }
  double my = -tire->rolling_resistance * load * km_slip_share(tire->radius * c.spin, km_stiction_speed(m, NULL));
  km_vec3 force = km_vec3_axpy(fx, c.x, km_vec3_axpy(fy, c.y, km_vec3_scale(load, c.z)));
  km_vec3 couple = km_vec3_axpy(my, c.y, km_vec3_scale(mz, c.z));
  int wheel = m->model->frames[module->output.frame[1]].body, road = m->model->frames[module->output.frame[0]].body;
  km_forces_add(f, wheel, force, couple, c.point);
  km_forces_add(f, road, km_vec3_scale(-1.0, force), km_vec3_scale(-1.0, couple), c.point);
  km_twist v = km_twist_axpy(-1.0, f->twist[road], f->twist[wheel]);
  double power = km_wrench_power(km_wrench_at(force, couple, c.point), v);
  moving->dissipation -= power;
  *km_module_report_of(m, f, module) = (km_module_report){
      .power = power, .tire_force = {fx, fy, load}, .tire_moment = {0.0, my, mz}, .slip = sx, .slip_angle = state[1]};
}
