/* Inverse dynamics of an arm by the recursive Newton-Euler method, about the arm's origin (docs/theory.md 12.10).
 *
 *   V_k = V_k-1 + h_k q̇_k,   A_k = A_k-1 + h_k q̈_k + [V_k-1, h_k q̇_k],   V_0 = 0,  A_0 = (-g; 0)
 *   F_k = I_k A_k + V_k ×* I_k V_k + F_k+1,   τ_k = h_k · F_k + J_k q̈_k + d_k q̇_k
 *
 * h_k unit twist, I_k inertia of link k, J_k armature, d_k damping. Source: J. Luh, M. Walker and R. Paul 1980. */
#include "arm/arm_dynamics.h"

#include "kinematics/primitive_motion.h"
#include "model/units.h"
#include "topology/chain.h"

/* Moves the frame X of motion k - 1 to the frame of motion k; *h receives its unit twist. */
static km_pose move(const km_arm *a, int k, double q, km_pose X, km_twist *h) {
  const km_arm_motion *m = &a->motions[k];
  const km_quaternion no_ball = {1.0, 0.0, 0.0, 0.0};
  X = km_pose_product(&X, &m->before);
  return km_motion_step((km_motion){m->primitive, m->axis}, m->sign, m->pitch, m->sign * q, &no_ball, X, h);
}

void km_arm_joint_forces(const km_arm *a, const double *q, const double *rates, const double *accelerations,
                         double *force) {
  const km_arm_mass *mass = &a->mass;
  km_twist h[KM_ARM_MAX_JOINTS], V = {{0, 0, 0}, {0, 0, 0}}, A = {km_vec3_scale(-1.0, mass->gravity), {0, 0, 0}};
  km_wrench own[KM_ARM_MAX_JOINTS], F = {{0, 0, 0}, {0, 0, 0}};
  km_pose X = km_pose_identity();
  for (int k = 0; k < a->n; ++k) {
    X = move(a, k, q[k], X, &h[k]);
    const km_twist relative = km_twist_axpy(rates[k], h[k], (km_twist){{0, 0, 0}, {0, 0, 0}});
    A = km_twist_axpy(1.0, km_twist_bracket(V, relative), km_twist_axpy(accelerations[k], h[k], A));
    V = km_twist_axpy(1.0, relative, V);
    const km_inertia inertia = km_inertia_transform(&X, &mass->inertia[k]);
    own[k] = km_wrench_axpy(1.0, km_wrench_cross(V, km_inertia_times(&inertia, V)), km_inertia_times(&inertia, A));
  }
  for (int k = a->n - 1; k >= 0; --k) {
    F = km_wrench_axpy(1.0, own[k], F);
    force[k] = km_wrench_power(F, h[k]) + mass->armature[k] * accelerations[k] + mass->damping[k] * rates[k];
  }
}

/* Number of the arm's motions that carry each body: those of the chain up to the body from which its branch leaves. */
static void count_motions(const km_arm *a, const km_arc *const *arcs, int count, int *carried) {
  const km_mechanism *m = a->mechanism;
  const int bodies = m->topology.body_count;
  for (int b = 0; b < bodies; ++b)
    carried[b] = b == 0 ? 0 : -1;
  for (int i = 0, motions = 0; i < count; ++i) {
    km_joint_traversal p;
    km_joint_traverse(m->model, arcs[i]->joint, arcs[i]->is_reversed, &p);
    for (int k = 0; k < p.count; ++k)
      motions += !m->held[p.coordinate[k]];
    carried[arcs[i]->body] = motions;
  }
  for (int b = 0; b < bodies; ++b) {
    int root = b;
    while (carried[root] < 0)
      root = m->arcs[m->arc_of[root]].parent;
    carried[b] = carried[root];
  }
}

/* Inertia of a body in the frame X of a motion; both poses are in the inertial frame and the model's unit. The result
 * has the units of km_arm_mass, with lengths over L. */
static km_inertia body_inertia(const km_arm *a, const km_model_body *body, const km_pose *X, const km_pose *pose) {
  const double L = a->length, per_second = a->mechanism->model->units.time->si;
  const double factor = km_inertial_factor(a->mechanism->model) * per_second * per_second;
  const km_pose back = km_pose_inverse(X), relative = km_pose_product(&back, pose);
  const km_inertia own = km_inertia_of_body(body->mass, body->center_of_mass, body->inertia);
  km_inertia there = km_inertia_transform(&relative, &own);
  there.m *= factor * L * L;
  there.mc = km_vec3_scale(factor * L, there.mc);
  there.I = km_symmetric_axpy(factor, there.I, (km_symmetric){0});
  return there;
}

/* Adds the inertias of all bodies that the arm carries, with the poses pose[body count] about the arm's origin. */
static void add_bodies(km_arm *a, const km_state *s, const int *carried, const km_pose *pose) {
  const km_mechanism *m = a->mechanism;
  km_pose frame[KM_ARM_MAX_JOINTS], X = km_pose_identity();
  km_twist h;
  for (int k = 0; k < a->n; ++k) {
    X = move(a, k, s->q[a->coordinate[k]] / a->unit[k], X, &h);
    frame[k] = (km_pose){X.R, km_vec3_scale(a->length, X.p)};
  }
  for (int b = 1; b < m->topology.body_count; ++b) {
    if (carried[b] == 0)
      continue;
    const int link = carried[b] - 1;
    const km_inertia inertia = body_inertia(a, &m->model->bodies[b], &frame[link], &pose[b]);
    const km_symmetric *I = &inertia.I;
    a->mass.inertia[link] = km_inertia_add(a->mass.inertia[link], inertia);
    a->mass.has_mass = a->mass.has_mass || inertia.m != 0.0 || I->xx + I->yy + I->zz != 0.0;
  }
}

/* Sets what the drive of each coordinate has: armature, damping, largest force. */
static void set_drives(km_arm *a) {
  const km_mechanism *m = a->mechanism;
  const double per_second = m->model->units.time->si, inertial = km_inertial_factor(m->model);
  for (int k = 0; k < a->n; ++k) {
    const int c = a->coordinate[k];
    const double unit = a->unit[k];
    a->mass.armature[k] = inertial * unit * unit * per_second * per_second * m->armature[c];
    a->mass.damping[k] = unit * unit * per_second * m->model->coordinates[c].damping;
    a->mass.force_limit[k] = unit * m->max_force[c];
    a->mass.has_mass = a->mass.has_mass || m->armature[c] != 0.0;
  }
}

bool km_arm_set_masses(km_arm *a, const km_state *s, const km_arc *const *arcs, int count) {
  const km_mechanism *m = a->mechanism;
  const double per_second = m->model->units.time->si;
  const size_t n = (size_t)a->n, bodies = (size_t)m->topology.body_count;
  a->mass.inertia = KM_ARENA_NEW(&a->arena, km_inertia, n);
  a->mass.armature = KM_ARENA_NEW(&a->arena, double, n);
  a->mass.damping = KM_ARENA_NEW(&a->arena, double, n);
  a->mass.force_limit = KM_ARENA_NEW(&a->arena, double, n);
  a->mass.gravity = km_vec3_scale(1.0 / (a->length * per_second * per_second), m->model->gravity);
  int *carried = KM_NEW(int, bodies);
  km_pose *pose = KM_NEW(km_pose, bodies);
  const bool is_ok = !a->arena.failed && carried && pose;
  if (is_ok) {
    count_motions(a, arcs, count, carried);
    km_poses_about(m, s, a->origin, pose);
    add_bodies(a, s, carried, pose);
    set_drives(a);
  }
  km_free(carried);
  km_free(pose);
  return is_ok;
}

double km_arm_force_to_units(const km_arm *a, int column, double force) {
  return force / a->unit[column];
}
