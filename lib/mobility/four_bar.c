/* Types of planar four-bar loops by Grashof's inequality (F. Grashof 1883).
 *
 *   s shortest, l longest link, p and q the others, g the ground
 *   s + l < p + q : the hinges of the shortest link go round    s beside g: crank-rocker, s = g: double crank,
 *                                                                s opposite g: double rocker
 *   s + l = p + q : change point      s + l > p + q : triple rocker, the longest link is too long by s + l − p − q */
#include "base/number/tolerances.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"

#include "kinematics/body_poses.h"

#include <math.h>

/* Number of joints between a body and the inertial frame along the spanning tree. */
static int depth_of(const km_mechanism *m, int body) {
  int depth = 0;
  for (; body > 0; body = m->topology.parent[body])
    ++depth;
  return depth;
}

/* True if the joint connects the body, and isn't used yet. */
static bool continues(const km_mechanism *m, int joint, int body, bool is_used) {
  return !is_used && (km_joint_body(m->model, joint, 0) == body || km_joint_body(m->model, joint, 1) == body);
}

/* Orders the joints round a loop of four hinges from the ground on; false: another loop. bodies[i] lies between joints
 * i − 1 and i, bodies[0] is the one nearest to the inertial frame. */
static bool order_loop(const km_mechanism *m, int loop, km_four_bar *out) {
  const km_topology *t = &m->topology;
  int joints[4], first = 0;
  if (t->member_start[loop + 1] - t->member_start[loop] != 4)
    return false;
  for (int i = 0; i < 4; ++i) {
    joints[i] = t->member[t->member_start[loop] + i].joint;
    const km_model_joint *joint = &m->model->joints[joints[i]];
    const km_joint_kind *kind = km_joint_kind_of(joint->type);
    if (kind->freedom != 1 || kind->motions[0].primitive != KM_REVOLUTE || m->held[joint->first_coordinate])
      return false;
  }
  int ground = km_joint_body(m->model, joints[0], 0);
  for (int i = 0; i < 4; ++i)
    for (int side = 0; side < 2; ++side) {
      int body = km_joint_body(m->model, joints[i], side);
      first = depth_of(m, body) < depth_of(m, ground) ? i : first;
      ground = depth_of(m, body) < depth_of(m, ground) ? body : ground;
    }
  out->bodies[0] = ground;
  for (int k = 0, body = out->bodies[0], used = 0; k < 4; ++k) {
    int next = k == 0 ? first : 0;
    while (k > 0 && next < 4 && !continues(m, joints[next], body, used >> next & 1))
      ++next;
    if (next == 4)
      return false;
    used |= 1 << next;
    out->joints[k] = joints[next];
    body = km_joint_body(m->model, joints[next], 0) == body ? km_joint_body(m->model, joints[next], 1)
                                                            : km_joint_body(m->model, joints[next], 0);
    if (k < 3)
      out->bodies[k + 1] = body;
    else if (body != out->bodies[0])
      return false;
  }
  return true;
}

/* Lengths of the links, the distances of their hinges across the axes; false: hinges that aren't parallel. */
static bool measure(const km_mechanism *m, const km_state *s, km_four_bar *out) {
  km_vec3 axis[4], point[4];
  for (int i = 0; i < 4; ++i) {
    const km_pose X = km_joint_pose(m, s, out->joints[i]);
    axis[i] = X.R.axis[km_joint_kind_of(m->model->joints[out->joints[i]].type)->motions[0].axis];
    point[i] = X.p;
    if (km_vec3_norm(km_vec3_cross(axis[0], axis[i])) > km_relative_zero)
      return false;
  }
  for (int i = 0; i < 4; ++i) {
    const km_vec3 link = km_vec3_sub(point[i], point[(i + 3) % 4]);
    out->lengths[i] = km_vec3_norm(km_vec3_axpy(-km_vec3_dot(axis[0], link), axis[0], link));
  }
  return true;
}

static void classify(km_four_bar *out) {
  double sum = 0.0;
  out->shortest = out->longest = 0;
  for (int i = 0; i < 4; ++i) {
    sum += out->lengths[i];
    out->shortest = out->lengths[i] < out->lengths[out->shortest] ? i : out->shortest;
    out->longest = out->lengths[i] > out->lengths[out->longest] ? i : out->longest;
  }
  out->excess = 2.0 * (out->lengths[out->shortest] + out->lengths[out->longest]) - sum;
  out->kind = fabs(out->excess) <= km_relative_zero * sum ? KM_FOUR_BAR_CHANGE_POINT
              : out->excess > 0.0                         ? KM_FOUR_BAR_TRIPLE_ROCKER
              : out->shortest == 0                        ? KM_FOUR_BAR_DOUBLE_CRANK
              : out->shortest == 2                        ? KM_FOUR_BAR_DOUBLE_ROCKER
                                                          : KM_FOUR_BAR_CRANK_ROCKER;
}

bool km_four_bar_find(const km_mechanism *m, const km_state *s, int loop, km_four_bar *out) {
  if (!out || !km_state_belongs_to(m, s) || loop < 0 || loop >= m->topology.loop_count)
    return false;
  *out = (km_four_bar){0};
  if (!order_loop(m, loop, out) || !measure(m, s, out))
    return false;
  classify(out);
  return out->lengths[out->shortest] > 0.0;
}

const char *km_four_bar_name(km_four_bar_kind kind) {
  static const char *const names[] = {"crank-rocker", "double crank", "double rocker", "triple rocker", "change point"};
  return (unsigned)kind < sizeof names / sizeof *names ? names[kind] : "";
}
