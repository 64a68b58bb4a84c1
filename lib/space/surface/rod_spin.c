/* Rods held from spinning (space/surface/rod_spin.h). */
#include "space/surface/rod_spin.h"

#include "kinematics/body_poses.h"

static int body_at(const km_model *model, int joint, int end) {
  return model->frames[model->joints[joint].frame[end]].body;
}

static bool is_in(const km_passive_freedom *group, int body) {
  for (int i = 0; i < group->body_count; ++i)
    if (group->bodies[i] == body)
      return true;
  return false;
}

/* Unit vector along the rod from joint[0] to joint[1], in the inertial frame. */
static km_vec3 find_axis(const km_rod_spin *r, const km_mechanism *m, const km_state *s) {
  km_vec3 along = km_vec3_sub(km_joint_pose(m, s, r->joint[1]).p, km_joint_pose(m, s, r->joint[0]).p);
  return km_vec3_scale(1.0 / km_vec3_norm(along), along);
}

static km_vec3 in_parent_frame(const km_mechanism *m, const km_state *s, int joint, km_vec3 v) {
  km_pose X = km_joint_pose(m, s, joint);
  return (km_vec3){km_vec3_dot(X.R.axis[0], v), km_vec3_dot(X.R.axis[1], v), km_vec3_dot(X.R.axis[2], v)};
}

bool km_rod_spin_create(const km_mechanism *m, const km_state *s, const km_passive_freedom *freedom, km_rod_spin *r) {
  const km_model *model = m->model;
  int count = 0;
  *r = (km_rod_spin){.body = freedom->bodies[0]};
  for (int j = 0; j < model->joint_count; ++j) {
    bool is_second = is_in(freedom, body_at(model, j, 1)), is_first = is_in(freedom, body_at(model, j, 0));
    if (is_first == is_second)
      continue;
    if (count == 2 || model->joints[j].type != KM_SPHERICAL)
      return false;
    r->joint[count] = j;
    r->sense[count++] = is_second ? 1.0 : -1.0;
  }
  if (count < 2 || freedom->freedoms != 1)
    return false;
  r->coordinate = model->joints[r->joint[0]].first_coordinate;
  r->ball = m->ball_of[r->coordinate];
  r->inverse = km_quaternion_conjugate(s->ball[r->ball]);
  r->axis = in_parent_frame(m, s, r->joint[0], find_axis(r, m, s));
  return isfinite(km_vec3_norm(r->axis));
}

double km_rod_spin_angle(const km_rod_spin *r, const km_state *s, km_vec3 *gradient) {
  km_quaternion P = km_quaternion_product(s->ball[r->ball], r->inverse);
  if (P.w < 0.0)
    P = (km_quaternion){-P.w, -P.x, -P.y, -P.z};
  km_vec3 v = {P.x, P.y, P.z}, d = r->axis;
  double along = km_vec3_dot(v, d), square = P.w * P.w + along * along;
  *gradient = km_vec3_add(km_vec3_scale(P.w * P.w, d), km_vec3_scale(P.w, km_vec3_cross(v, d)));
  *gradient = km_vec3_scale(1.0 / square, km_vec3_axpy(along, v, *gradient));
  return 2.0 * atan2(along, P.w);
}

void km_rod_spin_reset(const km_rod_spin *r, const km_mechanism *m, km_state *s) {
  km_vec3 gradient;
  km_poses_compute(m, s);
  km_vec3 axis = find_axis(r, m, s);
  double angle = -r->sense[0] * km_rod_spin_angle(r, s, &gradient);
  for (int end = 0; end < 2; ++end) {
    int ball = m->ball_of[m->model->joints[r->joint[end]].first_coordinate];
    km_vec3 turn = in_parent_frame(m, s, r->joint[end], km_vec3_scale(r->sense[end] * angle, axis));
    km_state_rotate_ball(m, s, ball, turn);
  }
}
