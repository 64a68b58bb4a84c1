/* Equations of motion: workspace, one evaluation, energies, driving forces, inertia forces (docs/theory.md 11.1 to
 * 11.3). */
#include "dynamics/dynamics.h"

#include "base/arguments.h"
#include "kmech/continuation.h"

#include <gsl/gsl_errno.h>
#include <string.h>

static void set_armatures(km_dynamics *d) {
  const km_mechanism *m = d->mechanism;
  bool any = false;
  for (int c = 0; c < m->coordinate_count; ++c)
    any = any || (m->armature[c] != 0.0 && !m->held[c]);
  d->armature = any ? KM_ARENA_NEW(&d->arena, double, (size_t)m->coordinate_count) : NULL;
  for (int c = 0; d->armature && c < m->coordinate_count; ++c)
    d->armature[c] = km_inertial_factor(m->model) * m->armature[c];
}

/* Allocates tree, nodes, clusters and work arrays. */
static bool allocate(km_dynamics *d) {
  const km_mechanism *m = d->mechanism;
  km_arena *arena = &d->arena;
  size_t coordinates = (size_t)m->coordinate_count;
  if (!km_tree_build(m, arena, &d->tree))
    return false;
  size_t nodes = (size_t)d->tree.node_count;
  d->node = KM_ARENA_NEW(arena, km_node_motion, nodes);
  d->articulated = KM_ARENA_NEW(arena, km_articulated, nodes);
  d->column = KM_ARENA_NEW(arena, km_twist, coordinates);
  d->cluster = KM_ARENA_NEW(arena, km_cluster_motion, (size_t)d->tree.cluster_count);
  d->row = KM_ARENA_NEW(arena, double, (size_t)m->largest_rows);
  d->step = KM_ARENA_NEW(arena, double, (size_t)m->largest_columns);
  d->driven_velocity = KM_ARENA_NEW(arena, km_twist, nodes);
  d->driven = KM_ARENA_NEW(arena, bool, coordinates);
  d->repartitions = KM_ARENA_NEW(arena, int, (size_t)m->topology.substructure_count);
  d->driven_acceleration = KM_ARENA_NEW(arena, double, coordinates);
  for (int i = 0; i < d->tree.cluster_count && !arena->failed; ++i)
    d->cluster[i].gamma = KM_ARENA_NEW(arena, double, (size_t)d->tree.clusters[i].coordinate_count);
  set_armatures(d);
  return !arena->failed;
}

km_status km_dynamics_create(const km_mechanism *m, km_forces *forces, km_dynamics **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(m != NULL, "mechanism", error);
  if (!status)
    status = km_check_given(forces != NULL, "forces", error);
  if (!status && forces->mechanism != m)
    status = km_fail(error, KM_USAGE, "the forces are those of another mechanism");
  if (!status)
    status = km_forces_prepare_motion(forces, error);
  if (status)
    return status;
  gsl_set_error_handler_off();
  km_dynamics *d = KM_NEW(km_dynamics, 1);
  if (d) {
    d->mechanism = m;
    d->forces = forces;
    d->closing_tolerance = 1e-13;
  }
  if (!d || !allocate(d))
    status = km_fail(error, KM_MEMORY, "out of memory for the equations of motion");
  if (!status)
    status = km_prescribed_create(m, &d->prescribed, error);
  if (status) {
    km_dynamics_free(d);
    return status;
  }
  *out = d;
  return KM_OK;
}

void km_dynamics_free(km_dynamics *d) {
  if (!d)
    return;
  km_prescribed_free(d->prescribed);
  km_arena_free(&d->arena);
  km_free(d);
}

km_status km_dynamics_prescribe(km_dynamics *d, int coordinate, double value, double rate, km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_index(coordinate, d->mechanism->coordinate_count, "coordinate", error);
  if (status)
    return status;
  const km_mechanism *m = d->mechanism;
  const char *label = m->model->coordinates[coordinate].label;
  if (m->held[coordinate] || m->ball_of[coordinate] >= 0)
    return km_fail(error, KM_USAGE, "joint \"%s\" is held, or a ball; expected a hinge, a slide or a screw", label);
  if (!isfinite(value) || !isfinite(rate))
    return km_fail(error, KM_USAGE, "%g at a rate of %g for %s; expected finite values", value, rate, label);
  double factor = km_model_coordinate_factor(m->model, coordinate);
  km_prescribed_set(d->prescribed, coordinate, factor * value, factor * rate);
  return KM_OK;
}

void km_dynamics_apply_prescribed(km_dynamics *d, km_state *s, bool position) {
  for (int i = 0; i < km_prescribed_count(d->prescribed); ++i) {
    double motion[3];
    int c = km_prescribed_at(d->prescribed, i, s->time, motion);
    d->driven[c] = true;
    d->driven_acceleration[c] = motion[2];
    s->rate[c] = motion[1];
    if (position)
      s->q[c] = motion[0];
  }
}

km_status km_dynamics_move_to_prescribed(km_dynamics *d, km_state *s, km_error *error) {
  static const double near = 1e-3; /* radians or characteristic lengths: loops close from this distance without
                                    * continuation */
  const km_mechanism *m = d->mechanism;
  int count = km_prescribed_count(d->prescribed);
  km_hold *goals = KM_NEW(km_hold, (size_t)count + 1);
  bool away = false;
  if (!goals)
    return km_fail(error, KM_MEMORY, "out of memory for the prescribed motions");
  for (int i = 0; i < count; ++i) {
    double motion[3];
    int c = km_prescribed_at(d->prescribed, i, s->time, motion);
    goals[i] = (km_hold){c, km_convert_unit(motion[0], m->factor[c])};
    away = away || !(fabs(motion[0] - s->q[c]) * m->scale[c] <= near);
  }
  km_status status = away ? km_state_move_to(m, s, goals, count, error) : KM_OK;
  km_free(goals);
  return status;
}

/* Moves the origin of moments to the mechanism if it is farther than the characteristic length, since moments of
 * weights lose digits with distance. False: unchanged. */
static bool update_origin(km_dynamics *d) {
  const km_tree *tree = &d->tree;
  for (int n = 1; n < tree->node_count; ++n) {
    km_vec3 away = d->node[n].pose.p;
    if (!tree->nodes[n].has_mass)
      continue;
    if (!(km_vec3_norm(away) > d->mechanism->length) || !isfinite(away.x + away.y + away.z))
      return false;
    d->forces->origin = km_vec3_add(away, d->forces->origin);
    return true;
  }
  return false;
}

void km_dynamics_locate_bodies(const km_dynamics *d) {
  km_forces *f = d->forces;
  for (int i = 0; i < f->moving->loaded_body_count; ++i) {
    int body = f->moving->loaded_bodies[i];
    const km_node_motion *node = &d->node[d->tree.node_of_body[body]];
    f->pose[body] = km_pose_product(&node->pose, &d->tree.body_in_node[body]);
    f->twist[body] = node->V;
  }
}

/* Evaluates the forces at the nodes' poses and twists: subtracts wrenches from p of the nodes, sets τ of the
 * coordinates. */
static void apply_forces(km_dynamics *d, const km_state *s) {
  const km_tree *tree = &d->tree;
  km_forces *f = d->forces;
  const km_moving_forces *moving = f->moving;
  km_dynamics_locate_bodies(d);
  km_forces_update_moving(d->mechanism, s, f);
  for (int i = 0; i < moving->loaded_body_count; ++i) {
    int body = moving->loaded_bodies[i];
    km_node_motion *node = &d->node[tree->node_of_body[body]];
    node->p = km_wrench_axpy(-1.0, f->body[body], node->p);
  }
}

/* Sets the accelerations of the bodies on which forces act. The nodes' contain −g. */
static void read_accelerations(const km_dynamics *d) {
  const km_forces *f = d->forces;
  for (int i = 0; i < f->moving->loaded_body_count; ++i) {
    int body = f->moving->loaded_bodies[i];
    km_twist A = d->node[d->tree.node_of_body[body]].A;
    f->acceleration[body] = (km_twist){km_vec3_add(A.v, f->stated_gravity), A.w};
  }
}

/* Forces and accelerations at the present implicit forces; requires km_tree_update. */
static km_dynamics_outcome solve_explicit(km_dynamics *d, km_state *s) {
  apply_forces(d, s);
  if (d->forces->moving->user_stopped)
    return KM_DYNAMICS_STOPPED;
  km_dynamics_outcome outcome = km_tree_solve(d, s);
  if (outcome == KM_DYNAMICS_DONE && d->forces->moving->implicit_count > 0)
    read_accelerations(d);
  return outcome;
}

km_dynamics_outcome km_dynamics_solve_explicit(km_dynamics *d, km_state *s) {
  km_tree_update(d, s);
  return solve_explicit(d, s);
}

/* Forces and accelerations; requires km_tree_update. */
static km_dynamics_outcome solve_forces_and_accelerations(km_dynamics *d, km_state *s) {
  km_dynamics_outcome outcome = solve_explicit(d, s);
  return outcome == KM_DYNAMICS_DONE && d->forces->moving->implicit_count > 0 ? km_implicit_forces_solve(d, s)
                                                                              : outcome;
}

km_dynamics_outcome km_dynamics_close(km_dynamics *d, km_state *s, bool search) {
  km_dynamics_apply_prescribed(d, s, true);
  return km_constraints_close(d, s, search) ? KM_DYNAMICS_DONE : KM_DYNAMICS_OPEN;
}

/* Velocity products, kinematics, forces, accelerations, then friction by reactions. */
km_dynamics_outcome km_dynamics_accelerate_closed(km_dynamics *d, km_state *s, bool search) {
  km_constraints_velocity_products(d, s);
  km_tree_update(d, s);
  if (search && update_origin(d))
    km_tree_update(d, s);
  km_dynamics_outcome outcome = solve_forces_and_accelerations(d, s);
  return outcome == KM_DYNAMICS_DONE && d->update_friction ? d->update_friction(d->friction_context, s) : outcome;
}

km_dynamics_outcome km_dynamics_evaluate(km_dynamics *d, km_state *s, bool search) {
  km_dynamics_outcome outcome = km_dynamics_close(d, s, search);
  return outcome == KM_DYNAMICS_DONE ? km_dynamics_accelerate_closed(d, s, search) : outcome;
}

km_dynamics_outcome km_dynamics_resolve(km_dynamics *d, km_state *s) {
  km_tree_update(d, s);
  return solve_forces_and_accelerations(d, s);
}

km_status km_dynamics_fail(const km_dynamics *d, km_dynamics_outcome outcome, km_error *error) {
  const km_model *model = d->mechanism->model;
  if (outcome == KM_DYNAMICS_MASSLESS)
    return km_fail(error, KM_MODEL,
                   "joint \"%s\" can move without moving any mass, so that its acceleration isn't determined; expected "
                   "a mass or a moment of inertia on what it moves",
                   model->coordinates[d->massless].label);
  if (outcome == KM_DYNAMICS_JAMMED)
    return km_fail(error, KM_DIVERGED, "friction jams: no friction is consistent with the reactions");
  if (outcome == KM_DYNAMICS_STOPPED)
    return km_fail(error, KM_CANCELLED, "the program's force function stopped the run");
  if (outcome == KM_DYNAMICS_IMPLICIT)
    return km_fail(error, KM_DIVERGED, "no force of the modules that read an acceleration is consistent with it");
  if (d->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the equations of motion");
  if (outcome == KM_DYNAMICS_INFINITE)
    return km_fail(
        error, KM_DIVERGED,
        "rates or accelerations grow beyond all numbers, or an expression has no value; expected shorter steps, weaker "
        "forces, or another expression");
  if (d->overprescribed >= 0)
    return km_fail(
        error, KM_DIVERGED,
        "the prescribed motions depend on each other: joint \"%s\" can't move otherwise than the others make it; "
        "expected one motion less",
        model->coordinates[d->overprescribed].label);
  return km_fail(error, KM_DIVERGED, "a loop can't be closed: the largest error is %g of its size", d->open);
}

km_status km_dynamics_accelerate(km_dynamics *d, km_state *s, km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (status)
    return status;
  km_dynamics_outcome outcome = km_dynamics_evaluate(d, s, true);
  return outcome == KM_DYNAMICS_DONE ? KM_OK : km_dynamics_fail(d, outcome, error);
}

/* Kinetic energy: Σ ½ V·I V of the bodies plus ½ a q̇² of the rotors. */
double km_dynamics_kinetic(const km_dynamics *d, const km_state *s) {
  double sum = 0.0;
  for (int n = 1; n < d->tree.node_count; ++n)
    if (d->tree.nodes[n].has_mass)
      sum += 0.5 * km_wrench_power(km_inertia_times(&d->node[n].inertia, d->node[n].V), d->node[n].V);
  for (int c = 0; d->armature && c < d->mechanism->coordinate_count; ++c)
    sum += 0.5 * d->armature[c] * s->rate[c] * s->rate[c];
  return sum;
}

km_status km_dynamics_energy(km_dynamics *d, km_state *s, km_energy *out, km_error *error) {
  km_status status = km_check_given(d != NULL && out != NULL, "equations of motion or place for the result", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (status)
    return status;
  const km_forces *f = d->forces;
  *out = (km_energy){.kinetic = km_dynamics_kinetic(d, s),
                     .dissipation = f->moving->dissipation,
                     .motor_power = f->moving->motor_power};
  for (int n = 1; n < d->tree.node_count; ++n) {
    if (!d->tree.nodes[n].has_mass)
      continue;
    const km_node_motion *node = &d->node[n];
    km_vec3 mc = km_vec3_axpy(node->inertia.m, f->origin, node->inertia.mc);
    out->potential -= km_vec3_dot(mc, f->stated_gravity);
  }
  out->potential +=
      km_springs_energy(d->mechanism, s, f) + km_stops_energy(d->mechanism, s, f) + km_contacts_energy(d->mechanism, f);
  out->motor_power += km_dynamics_driving_power(d, s);
  return KM_OK;
}

/* Driving force Σ Pᵀ(p + I A) − Nᵀτ of the prescribed coordinate k of a cluster. */
static double driving_force(const km_dynamics *d, const km_state *s, const km_cluster *cluster,
                            const km_cluster_motion *c, int k) {
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  const double *N = c->N + (size_t)k * (size_t)cluster->coordinate_count;
  double force = 0.0;
  for (int i = 0; i < cluster->coordinate_count; ++i)
    force -= N[i] * (d->forces->joint[coordinates[i]] -
                     (d->armature ? d->armature[coordinates[i]] * s->acceleration[coordinates[i]] : 0.0));
  for (int i = 0; i < cluster->node_count; ++i) {
    int n = cluster->node_start + i;
    const km_node *node = &d->tree.nodes[n];
    km_twist P =
        node->parent >= cluster->node_start ? d->driven_velocity[node->parent] : (km_twist){{0, 0, 0}, {0, 0, 0}};
    for (int f = 0; f < node->freedom && node->local >= 0; ++f)
      P = km_twist_axpy(N[node->local + f], d->column[node->coordinate + f], P);
    d->driven_velocity[n] = P;
    force += km_wrench_power(d->node[n].p, P) + km_wrench_power(km_node_inertia_force(d, n, d->node[n].A), P);
  }
  return force;
}

double km_dynamics_driving_force(const km_dynamics *d, const km_state *s, int coordinate) {
  if (!d || !km_state_belongs_to(d->mechanism, s) || coordinate < 0 || coordinate >= d->mechanism->coordinate_count ||
      !d->driven[coordinate])
    return nan("");
  for (int i = 0; i < d->tree.cluster_count; ++i) {
    const km_cluster *cluster = &d->tree.clusters[i];
    const km_cluster_motion *c = &d->cluster[i];
    for (int k = c->freedom; k < c->freedom + c->driven; ++k)
      if (d->tree.coordinate_order[cluster->coordinate_start + c->independent[k]] == coordinate)
        return driving_force(d, s, cluster, c, k);
  }
  return nan("");
}

/* Adds weights and inertia forces −(I A + V ×* I V) of all bodies and rotors to the forces. */
void km_dynamics_balance(km_dynamics *d, const km_state *s) {
  const km_mechanism *m = d->mechanism;
  km_forces *f = d->forces;
  f->force_size = f->couple_size = 0.0;
  memset(f->body, 0, (size_t)m->topology.body_count * sizeof *f->body);
  f->pose[0] = d->node[0].pose;
  for (int b = 1; b < m->topology.body_count; ++b) {
    const km_node_motion *node = &d->node[d->tree.node_of_body[b]];
    f->pose[b] = km_pose_product(&node->pose, &d->tree.body_in_node[b]);
    f->twist[b] = node->V;
  }
  km_forces_update_moving(m, s, f);
  for (int b = 1; b < m->topology.body_count; ++b) {
    const km_model_body *def = &m->model->bodies[b];
    const km_node_motion *node = &d->node[d->tree.node_of_body[b]];
    km_inertia own = km_inertia_of_body(def->mass, def->center_of_mass, def->inertia);
    km_inertia there = km_inertia_transform(&f->pose[b], &own);
    km_wrench rate = km_wrench_axpy(1.0, km_inertia_times(&there, node->A),
                                    km_wrench_cross(node->V, km_inertia_times(&there, node->V)));
    km_wrench w = km_wrench_axpy(-km_inertial_factor(m->model), rate, (km_wrench){{0, 0, 0}, {0, 0, 0}});
    km_vec3 at = km_pose_point(&f->pose[b], def->center_of_mass);
    km_forces_add(f, b, w.f, km_wrench_about(w, at).t, at);
  }
  for (int c = 0; d->armature && c < m->coordinate_count; ++c)
    km_forces_add_joint(m->model, f, c, -d->armature[c] * s->acceleration[c]);
}

/* Sum of inertia forces −Σ (I A + V ×* I V), about km_forces.origin. */
km_wrench km_dynamics_inertia_forces(const km_dynamics *d) {
  km_wrench sum = {{0, 0, 0}, {0, 0, 0}};
  for (int n = 1; n < d->tree.node_count; ++n) {
    const km_node_motion *node = &d->node[n];
    if (!d->tree.nodes[n].has_mass)
      continue;
    km_twist a = node->A; /* the acceleration of the inertial frame, which represents gravity, is removed */
    a.v = km_vec3_add(a.v, d->forces->stated_gravity);
    km_wrench rate = km_wrench_axpy(1.0, km_inertia_times(&node->inertia, a),
                                    km_wrench_cross(node->V, km_inertia_times(&node->inertia, node->V)));
    sum = km_wrench_axpy(-1.0, rate, sum);
  }
  return sum;
}

double km_dynamics_driving_power(const km_dynamics *d, const km_state *s) {
  double power = 0.0, motion[3];
  for (int i = 0; i < km_prescribed_count(d->prescribed); ++i) {
    int c = km_prescribed_at(d->prescribed, i, s->time, motion);
    power += km_dynamics_driving_force(d, s, c) * s->rate[c];
  }
  return power;
}

double km_dynamics_loop_error(const km_dynamics *d) {
  return d ? d->residual : nan("");
}

int km_dynamics_repartitions(const km_dynamics *d) {
  int sum = 0;
  for (int i = 0; d && i < d->mechanism->topology.substructure_count; ++i)
    sum += d->repartitions[i];
  return sum;
}

void km_dynamics_reset_repartitions(km_dynamics *d) {
  for (int i = 0; i < d->mechanism->topology.substructure_count; ++i)
    d->repartitions[i] = 0;
}
