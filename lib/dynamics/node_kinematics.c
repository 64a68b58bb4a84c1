/* Forward pass over the nodes: poses, joint twists, twists, inertias about the origin, velocity products
 * (docs/theory.md 11.1).
 *
 *   V = V_parent + Σ h_k q̇_k,   ζ = [V_parent, Σ h_k q̇_k],   p = V ×* (I V) */
#include "dynamics/dynamics.h"
#include "kinematics/primitive_motion.h"

/* Kinematics of one node from its parent: pose, joint twist, V, ζ = [V_parent, Σ h q̇], inertia about the origin,
 * p. */
static void move_node(km_dynamics *d, const km_state *s, int n) {
  const km_node *node = &d->tree.nodes[n];
  km_node_motion *out = &d->node[n];
  const km_node_motion *parent = &d->node[node->parent];
  km_twist *h = &d->column[node->coordinate], x = {{0, 0, 0}, {0, 0, 0}};
  km_pose X = {node->has_rotation ? km_rotation_product(&parent->pose.R, &node->before.R) : parent->pose.R,
               km_pose_point(&parent->pose, node->before.p)};
  const km_quaternion *ball = node->primitive == KM_BALL ? &s->ball[node->ball] : NULL;
  out->pose = km_motion_step((km_motion){node->primitive, node->axis}, node->sign, node->pitch,
                             node->sign * s->q[node->coordinate], ball, X, h);
  for (int k = 0; k < node->freedom; ++k)
    x = km_twist_axpy(s->rate[node->coordinate + k], h[k], x);
  out->V = km_twist_axpy(1.0, x, parent->V);
  out->zeta = km_twist_bracket(parent->V, x);
  if (node->has_mass) {
    out->inertia = km_inertia_transform(&out->pose, &node->inertia);
    out->p = km_wrench_cross(out->V, km_inertia_times(&out->inertia, out->V));
  } else {
    out->p = (km_wrench){{0, 0, 0}, {0, 0, 0}};
  }
}

void km_tree_update(km_dynamics *d, const km_state *s) {
  km_vec3 origin = d->forces->origin;
  d->node[0] = (km_node_motion){.pose = {km_rotation_identity(), km_vec3_scale(-1.0, origin)}};
  for (int n = 1; n < d->tree.node_count; ++n)
    move_node(d, s, n);
}
