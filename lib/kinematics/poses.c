/* Poses and twists of bodies in the inertial frame. */
#include "kinematics/poses.h"
#include "topology/chain.h"

/* The displacement of motion i of a passage. */
static km_pose motion_pose(const km_mechanism *m, const km_state *s, const km_passage *p, int i, double pitch) {
  if (p->motion[i].primitive != KM_BALL)
    return km_motion_passed(p->motion[i], pitch, &s->q[p->coordinate[i]], p->sign);
  km_quaternion q = s->ball[m->ball_of[p->coordinate[i]]];
  return (km_pose){km_quaternion_rotation(p->sign < 0.0 ? km_quaternion_conjugate(q) : q), {0, 0, 0}};
}

static km_pose across(const km_mechanism *m, const km_state *s, const km_arc *arc) {
  km_passage p = km_joint_passage(m->model, arc->joint, arc->against);
  double pitch = km_pitch_per_radian(m->model, arc->joint, 1.0);
  km_pose X = arc->before;
  for (int i = 0; i < p.count; ++i) {
    km_pose motion = motion_pose(m, s, &p, i, pitch);
    X = km_pose_product(&X, &motion);
  }
  return km_pose_product(&X, &arc->after);
}

km_twist km_body_twist(const km_mechanism *m, const km_state *s, int body, const double *rates) {
  const km_arc *arc = &m->arcs[m->arc_of[body]];
  km_passage p = km_joint_passage(m->model, arc->joint, arc->against);
  double pitch = km_pitch_per_radian(m->model, arc->joint, 1.0);
  km_pose X = km_pose_product(&s->pose[arc->parent], &arc->before);
  km_twist sum = {{0, 0, 0}, {0, 0, 0}};
  for (int i = 0; i < p.count; ++i) {
    km_pose motion = motion_pose(m, s, &p, i, pitch), after = km_pose_product(&X, &motion);
    /* A ball's rates are about its parent frame's axes, which come last where it is passed against. */
    const km_pose *frame = p.motion[i].primitive == KM_BALL && p.sign < 0.0 ? &after : &X;
    for (int k = 0; k < km_primitive_freedom(p.motion[i].primitive); ++k)
      sum = km_twist_axpy(p.sign * rates[p.coordinate[i] + k], km_motion_twist(p.motion[i], pitch, frame, k), sum);
    X = after;
  }
  return sum;
}

static km_pose frame_pose(const km_mechanism *m, const km_pose *pose, int frame) {
  const km_model_frame *def = &m->model->frames[frame];
  return km_pose_product(&pose[def->body], &def->pose);
}

km_pose km_joint_pose(const km_mechanism *m, const km_state *s, int joint) {
  return frame_pose(m, s->pose, m->model->joints[joint].frame[0]);
}

km_twist km_coordinate_twist(const km_mechanism *m, const km_state *s, int coordinate) {
  return km_coordinate_twist_about(m, s, s->pose, coordinate);
}

km_twist km_coordinate_twist_about(const km_mechanism *m, const km_state *s, const km_pose *pose, int coordinate) {
  int joint = m->model->coordinates[coordinate].joint;
  km_passage p = km_joint_passage(m->model, joint, false);
  double pitch = km_pitch_per_radian(m->model, joint, 1.0);
  km_pose X = frame_pose(m, pose, m->model->joints[joint].frame[0]);
  int i = 0;
  for (; coordinate >= p.coordinate[i] + km_primitive_freedom(p.motion[i].primitive); ++i) {
    km_pose motion = motion_pose(m, s, &p, i, pitch);
    X = km_pose_product(&X, &motion);
  }
  return km_motion_twist(p.motion[i], pitch, &X, coordinate - p.coordinate[i]);
}

static void update_body(const km_mechanism *m, const km_state *s, const km_arc *arc, km_pose *pose) {
  km_pose step = across(m, s, arc);
  pose[arc->body] = km_pose_product(&pose[arc->parent], &step);
}

void km_poses_about(const km_mechanism *m, const km_state *s, km_vec3 origin, km_pose *pose) {
  pose[0] = (km_pose){km_rotation_identity(), km_vec3_scale(-1.0, origin)};
  for (int i = 0; i < m->topology.body_count - 1; ++i)
    update_body(m, s, &m->arcs[i], pose);
}

void km_poses_update_in(const km_mechanism *m, km_state *s, int substructure) {
  const km_topology *t = &m->topology;
  for (int i = t->body_start[substructure]; i < t->body_start[substructure + 1]; ++i)
    update_body(m, s, &m->arcs[m->arc_of[t->body[i]]], s->pose);
}

void km_poses_update(const km_mechanism *m, km_state *s) {
  if (!km_state_fits(m, s))
    return;
  km_poses_about(m, s, (km_vec3){0, 0, 0}, s->pose);
}

void km_frame_position(const km_mechanism *m, const km_state *s, int frame, double position[3]) {
  if (!position)
    return;
  position[0] = position[1] = position[2] = nan("");
  if (!km_state_fits(m, s) || frame < 0 || frame >= m->model->frame_count)
    return;
  const km_model_frame *def = &m->model->frames[frame];
  km_vec3 p = km_pose_point(&s->pose[def->body], def->pose.p);
  position[0] = p.x;
  position[1] = p.y;
  position[2] = p.z;
}
