/* Rods held from spinning (space/surface/rod_spin.h). */
#include "space/surface/rod_spin.h"

#include "kinematics/body_poses.h"
#include "model/joint_type.h"

/* A turn leaves the share |1 − g·u| of the angle, u the rod's axis: 30 of a share of 0.37 leave the smallest one. */
enum { MOST_TURNS = 30 };
static const double same_angle = 1e-13; /* radians: rounding of τ, 1e-15, where it is well conditioned */

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

/* c in the inertial frame, for a rod along d. */
static km_vec3 find_pole(const km_rod_spin *r, const km_mechanism *m, const km_state *s, km_vec3 d) {
  const km_model *model = m->model;
  int other = km_joint_body(model, r->joint[0], r->sense[0] > 0.0 ? 0 : 1);
  for (int j = 0; j < model->joint_count; ++j) {
    int axis = km_joint_axis(model->joints[j].type);
    if (axis < 0 || (km_joint_body(model, j, 0) != other && km_joint_body(model, j, 1) != other))
      continue;
    km_vec3 hinge = km_joint_pose(m, s, j).R.axis[axis];
    return km_vec3_scale(km_vec3_dot(hinge, d) < 0.0 ? -1.0 : 1.0, hinge);
  }
  return d;
}

static km_vec3 in_parent_frame(const km_mechanism *m, const km_state *s, int joint, km_vec3 v) {
  km_pose X = km_joint_pose(m, s, joint);
  return (km_vec3){km_vec3_dot(X.R.axis[0], v), km_vec3_dot(X.R.axis[1], v), km_vec3_dot(X.R.axis[2], v)};
}

/* An axis of the body, turned by the least angle that takes c to d. */
static km_vec3 turned(const km_rod_spin *r, km_vec3 axis, km_vec3 d) {
  return km_vec3_axpy(-km_vec3_dot(axis, d) / (1.0 + km_vec3_dot(r->c, d)), km_vec3_add(r->c, d), axis);
}

bool km_rod_spin_create(const km_mechanism *m, const km_state *s, const km_passive_freedom *freedom, km_rod_spin *r) {
  const km_model *model = m->model;
  int count = 0;
  *r = (km_rod_spin){.body = freedom->bodies[0]};
  for (int j = 0; j < model->joint_count; ++j) {
    bool is_second = is_in(freedom, km_joint_body(model, j, 1)), is_first = is_in(freedom, km_joint_body(model, j, 0));
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
  km_vec3 axis = find_axis(r, m, s);
  r->d = in_parent_frame(m, s, r->joint[0], axis);
  r->c = in_parent_frame(m, s, r->joint[0], find_pole(r, m, s, axis));
  r->a = km_vec3_perpendicular(r->c);
  r->b = km_vec3_cross(r->c, r->a);
  r->m = turned(r, r->a, r->d);
  return isfinite(km_vec3_norm(r->d));
}

double km_rod_spin_angle(const km_rod_spin *r, const km_state *s, km_vec3 *gradient) {
  km_rotation P = km_quaternion_rotation(km_quaternion_product(s->ball[r->ball], r->inverse));
  bool is_second = r->sense[0] > 0.0; /* else P turns the other body */
  km_vec3 d = is_second ? km_rotate(&P, r->d) : km_rotate_back(&P, r->d);
  km_vec3 m = is_second ? km_rotate(&P, r->m) : km_rotate_back(&P, r->m);
  km_vec3 g = km_vec3_scale(1.0 / (1.0 + km_vec3_dot(r->c, d)), km_vec3_add(r->c, d));
  *gradient = is_second ? g : km_vec3_scale(-1.0, km_rotate(&P, g));
  return atan2(km_vec3_dot(m, turned(r, r->b, d)), km_vec3_dot(m, turned(r, r->a, d)));
}

/* Turns the rod about its axis by an angle. */
static void spin(const km_rod_spin *r, const km_mechanism *m, km_state *s, double angle) {
  km_vec3 axis = find_axis(r, m, s);
  for (int end = 0; end < 2; ++end) {
    int ball = m->ball_of[m->model->joints[r->joint[end]].first_coordinate];
    km_vec3 turn = in_parent_frame(m, s, r->joint[end], km_vec3_scale(r->sense[end] * angle, axis));
    km_state_rotate_ball(m, s, ball, turn);
  }
}

void km_rod_spin_reset(const km_rod_spin *r, const km_mechanism *m, km_state *s) {
  km_vec3 gradient;
  km_poses_compute(m, s);
  double angle = -km_rod_spin_angle(r, s, &gradient);
  spin(r, m, s, angle);
  for (int i = 0; i < MOST_TURNS && fabs(angle) > same_angle;
       ++i) { /* d isn't the axis of a rod whose length has changed */
    km_poses_compute(m, s);
    angle = -km_rod_spin_angle(r, s, &gradient);
    if (fabs(angle) > same_angle)
      spin(r, m, s, angle);
  }
}
