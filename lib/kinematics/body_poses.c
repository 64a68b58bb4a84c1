/* Forward kinematics along the spanning tree: poses and twists of bodies in the inertial frame (docs/theory.md 1.2,
 * 2.1).
 *
 *   X_body = X_parent · before · motions(q) · after          before, after: constant, to and from the joint's frame */
#include "kinematics/body_poses.h"
#include "topology/chain.h"

/* Multiplies X by a motion of a joint, with the bits of km_motion_traversed. `sign` −1: reversed joint. */
static inline __attribute__((always_inline)) void apply_motion(const km_mechanism *m, const km_state *s,
                                                               km_motion motion, double sign, double pitch,
                                                               int coordinate, km_pose *X) {
  double value = s->q[coordinate];
  switch (motion.primitive) {
  case KM_PRISMATIC:
    X->p = km_vec3_axpy(sign * value, X->R.axis[motion.axis], X->p);
    break;
  case KM_HELICAL:
    X->p = km_vec3_axpy(sign * (pitch * value), X->R.axis[motion.axis], X->p); /* fall through */
  case KM_REVOLUTE:
    X->R = km_rotation_about_axis(&X->R, motion.axis, cos(value), sign * sin(value));
    break;
  case KM_BALL: {
    km_quaternion q = s->ball[m->ball_of[coordinate]];
    km_rotation turn = km_quaternion_rotation(sign < 0.0 ? km_quaternion_conjugate(q) : q);
    X->R = km_rotation_product(&X->R, &turn);
    break;
  }
  }
}

/* Twist of a body relative to its parent: sum of rate · unit twist over the motions of its tree joint. */
static km_twist twist_to_parent(const km_mechanism *m, const km_state *s, int body, const double *rates) {
  const km_arc *arc = &m->arcs[m->arc_of[body]];
  km_joint_traversal p;
  km_joint_traverse(m->model, arc->joint, arc->is_reversed, &p);
  double pitch = km_pitch_per_radian(m->model, arc->joint, 1.0);
  km_pose X = km_pose_product(&s->pose[arc->parent], &arc->before);
  km_twist sum = {{0, 0, 0}, {0, 0, 0}};
  for (int i = 0; i < p.count; ++i) {
    km_pose after = X;
    apply_motion(m, s, p.motion[i], p.sign, pitch, p.coordinate[i], &after);
    /* Rates of a ball joint are about its parent frame's axes; of a reversed joint that is the frame after the
     * motion. */
    const km_pose *frame = p.motion[i].primitive == KM_BALL && p.sign < 0.0 ? &after : &X;
    for (int k = 0; k < km_primitive_freedom(p.motion[i].primitive); ++k)
      sum = km_twist_axpy(p.sign * rates[p.coordinate[i] + k], km_motion_twist(p.motion[i], pitch, frame, k), sum);
    X = after;
  }
  return sum;
}

km_twist km_body_twist(const km_mechanism *m, const km_state *s, int body, const double *rates) {
  km_twist sum = {{0, 0, 0}, {0, 0, 0}};
  for (; body > 0; body = m->topology.parent[body])
    sum = km_twist_axpy(1.0, twist_to_parent(m, s, body, rates), sum);
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

/* Unit twist of one coordinate: advances the joint's frame by the motions before it. */
km_twist km_coordinate_twist_about(const km_mechanism *m, const km_state *s, const km_pose *pose, int coordinate) {
  int joint = m->model->coordinates[coordinate].joint, at = m->model->joints[joint].first_coordinate;
  const km_motion *motion = km_joint_kind_of(m->model->joints[joint].type)->motions;
  double pitch = km_pitch_per_radian(m->model, joint, 1.0);
  km_pose X = frame_pose(m, pose, m->model->joints[joint].frame[0]);
  for (; coordinate >= at + km_primitive_freedom(motion->primitive); ++motion) {
    apply_motion(m, s, *motion, 1.0, pitch, at, &X);
    at += km_primitive_freedom(motion->primitive);
  }
  return km_motion_twist(*motion, pitch, &X, coordinate - at);
}

/* Unit twists h of all coordinates for given poses. */
void km_twists_about(const km_mechanism *m, const km_state *s, const km_pose *pose, km_twist *twist) {
  for (int c = 0; c < m->coordinate_count; ++c) {
    const km_model_coordinate *def = &m->model->coordinates[c];
    const km_model_joint *joint = &m->model->joints[def->joint];
    km_motion motion = km_joint_kind_of(joint->type)->motions[0];
    if (def->index > 0 || motion.primitive == KM_BALL) {
      twist[c] = km_coordinate_twist_about(m, s, pose, c);
      continue;
    }
    const km_model_frame *frame = &m->model->frames[joint->frame[0]]; /* only its axis and origin are needed */
    const km_pose *body = &pose[frame->body];
    twist[c] = km_axis_twist(motion.primitive, km_pitch_per_radian(m->model, def->joint, 1.0),
                             km_rotate(&body->R, frame->pose.R.axis[motion.axis]), km_pose_point(body, frame->pose.p));
  }
}

/* Pose of a body from that of its parent. */
static void update_body(const km_mechanism *m, const km_state *s, const km_arc *arc, km_pose *pose) {
  const km_model_joint *joint = &m->model->joints[arc->joint];
  const km_joint_kind *kind = km_joint_kind_of(joint->type);
  const km_pose *parent = &pose[arc->parent], *after = &arc->after;
  km_pose X = arc->before, *out = &pose[arc->body];
  double sign = arc->is_reversed ? -1.0 : 1.0, pitch = km_pitch_per_radian(m->model, arc->joint, 1.0);
  int coordinate = joint->first_coordinate + (arc->is_reversed ? kind->freedom : 0);
  for (int i = 0; i < kind->motion_count; ++i) {
    km_motion motion = kind->motions[arc->is_reversed ? kind->motion_count - 1 - i : i];
    int freedom = km_primitive_freedom(motion.primitive);
    coordinate -= arc->is_reversed ? freedom : 0;
    apply_motion(m, s, motion, sign, pitch, coordinate, &X);
    coordinate += arc->is_reversed ? 0 : freedom;
  }
  for (int k = 0; k < 3; ++k)
    out->R.axis[k] = km_rotate(&parent->R, km_rotate(&X.R, after->R.axis[k]));
  out->p = km_pose_point(parent, km_pose_point(&X, after->p));
}

/* Updates the bodies from arc `first` on, in level order. */
static void update_bodies(const km_mechanism *m, const km_state *s, int first, km_pose *pose) {
  for (int i = first; i < m->topology.body_count - 1; ++i)
    update_body(m, s, &m->arcs[i], pose);
}

void km_poses_about(const km_mechanism *m, const km_state *s, km_vec3 origin, km_pose *pose) {
  pose[0] = (km_pose){km_rotation_identity(), km_vec3_scale(-1.0, origin)};
  update_bodies(m, s, 0, pose);
}

/* Forward kinematics about the origin of the first moving body. */
km_vec3 km_poses_about_mechanism(const km_mechanism *m, const km_state *s, km_pose *pose) {
  pose[0] = km_pose_identity();
  if (m->topology.body_count < 2)
    return pose[0].p;
  km_pose *first = &pose[m->arcs[0].body];
  update_body(m, s, &m->arcs[0], pose);
  km_vec3 origin = first->p;
  pose[0].p = km_vec3_scale(-1.0, origin);
  first->p = km_vec3_sub(first->p, origin);
  update_bodies(m, s, 1, pose);
  return origin;
}

/* Forward kinematics of one substructure's bodies. */
void km_poses_compute_in(const km_mechanism *m, km_state *s, int substructure) {
  const km_topology *t = &m->topology;
  for (int i = t->body_start[substructure]; i < t->body_start[substructure + 1]; ++i)
    update_body(m, s, &m->arcs[m->arc_of[t->body[i]]], s->pose);
}

/* Forward kinematics of all bodies. */
void km_poses_compute(const km_mechanism *m, km_state *s) {
  if (!km_state_belongs_to(m, s))
    return;
  km_poses_about(m, s, (km_vec3){0, 0, 0}, s->pose);
}

void km_frame_position(const km_mechanism *m, const km_state *s, int frame, double position[3]) {
  if (!position)
    return;
  position[0] = position[1] = position[2] = nan("");
  if (!km_state_belongs_to(m, s) || frame < 0 || frame >= m->model->frame_count)
    return;
  km_vec3 p = km_frame_origin(m->model, s->pose, frame);
  km_vec3_write(p, position);
}

/* Adds the motion of one primitive: V = V_from + x, A = A_from + Σ h q̈ + [V_from, x], x = Σ h q̇ (docs/theory.md 2.6).
 * The columns h move with either side of the primitive, because [x, x] = 0. */
static void add_primitive(const km_mechanism *m, const km_state *s, int first, int freedom, double sense,
                          const double *rate, const double *acceleration, km_body_motion *b) {
  km_twist x = {{0, 0, 0}, {0, 0, 0}};
  for (int c = first; c < first + freedom; ++c) {
    km_twist h = km_coordinate_twist(m, s, c);
    x = km_twist_axpy(sense * rate[c], h, x);
    b->A = km_twist_axpy(sense * acceleration[c], h, b->A);
  }
  b->A = km_twist_axpy(1.0, km_twist_bracket(b->V, x), b->A);
  b->V = km_twist_axpy(1.0, x, b->V);
}

void km_body_motions(const km_mechanism *m, const km_state *s, const double *rate, const double *acceleration,
                     km_body_motion *out) {
  out[0] = (km_body_motion){{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}};
  for (int i = 0; i < m->topology.body_count - 1; ++i) {
    const km_arc *arc = &m->arcs[i];
    const km_model_joint *joint = &m->model->joints[arc->joint];
    const km_joint_kind *kind = km_joint_kind_of(joint->type);
    int coordinate = joint->first_coordinate + (arc->is_reversed ? kind->freedom : 0);
    km_body_motion *b = &out[arc->body];
    *b = out[arc->parent];
    for (int k = 0; k < kind->motion_count; ++k) {
      km_motion motion = kind->motions[arc->is_reversed ? kind->motion_count - 1 - k : k];
      int freedom = km_primitive_freedom(motion.primitive);
      coordinate -= arc->is_reversed ? freedom : 0;
      add_primitive(m, s, coordinate, freedom, arc->is_reversed ? -1.0 : 1.0, rate, acceleration, b);
      coordinate += arc->is_reversed ? 0 : freedom;
    }
  }
}
