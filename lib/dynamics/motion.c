/* The outward pass over the nodes: poses, columns, twists, inertias, velocity products. */
#include "dynamics/dynamics.h"

static inline km_twist about_axis(km_vec3 axis, double sign, const km_pose *X) {
  return km_twist_revolute(km_vec3_scale(sign, axis), X->p);
}

/* One motion from X, its frame: the pose after it. h receives the columns, one a coordinate. */
static km_pose passed(const km_node *node, km_pose X, const km_state *s, km_twist *h) {
  double value = node->sign * s->q[node->coordinate];
  km_vec3 axis = X.R.axis[node->axis];
  switch (node->primitive) {
  case KM_PRISMATIC:
    h[0] = km_twist_prismatic(km_vec3_scale(node->sign, axis));
    X.p = km_vec3_axpy(value, axis, X.p);
    break;
  case KM_REVOLUTE:
    h[0] = about_axis(axis, node->sign, &X);
    X.R = km_rotation_turn(&X.R, node->axis, cos(value), sin(value));
    break;
  case KM_HELICAL:
    h[0] = about_axis(axis, node->sign, &X);
    h[0].v = km_vec3_axpy(node->sign * node->pitch, axis, h[0].v);
    X.p = km_vec3_axpy(value * node->pitch, axis, X.p);
    X.R = km_rotation_turn(&X.R, node->axis, cos(value), sin(value));
    break;
  case KM_BALL: {
    /* Rates are about the axes of the joint's own parent frame: before the turn, or, passed against its sense, after. */
    km_quaternion q = node->sign > 0.0 ? s->ball[node->ball] : km_quaternion_conjugate(s->ball[node->ball]);
    km_rotation turn = km_quaternion_rotation(q), before = X.R;
    X.R = km_rotation_product(&X.R, &turn);
    for (int k = 0; k < 3; ++k)
      h[k] = about_axis(node->sign > 0.0 ? before.axis[k] : X.R.axis[k], node->sign, &X);
    break;
  }
  }
  return X;
}

static void move_node(km_dynamics *d, const km_state *s, int n) {
  const km_node *node = &d->tree.nodes[n];
  km_node_motion *out = &d->node[n];
  const km_node_motion *parent = &d->node[node->parent];
  km_twist *h = &d->column[node->coordinate], x = {{0, 0, 0}, {0, 0, 0}};
  km_pose X = {node->turned ? km_rotation_product(&parent->pose.R, &node->before.R) : parent->pose.R,
               km_pose_point(&parent->pose, node->before.p)};
  out->pose = passed(node, X, s, h);
  for (int k = 0; k < node->freedom; ++k)
    x = km_twist_axpy(s->rate[node->coordinate + k], h[k], x);
  out->V = km_twist_axpy(1.0, x, parent->V);
  out->zeta = km_twist_bracket(parent->V, x);
  if (node->massive) {
    out->inertia = km_inertia_move(&out->pose, &node->inertia);
    out->p = km_wrench_carried(out->V, km_inertia_times(&out->inertia, out->V));
  } else {
    out->p = (km_wrench){{0, 0, 0}, {0, 0, 0}};
  }
}

void km_tree_move(km_dynamics *d, const km_state *s) {
  km_vec3 origin = d->forces->origin;
  d->node[0] = (km_node_motion){.pose = {km_rotation_identity(), km_vec3_scale(-1.0, origin)}};
  for (int n = 1; n < d->tree.node_count; ++n)
    move_node(d, s, n);
}
