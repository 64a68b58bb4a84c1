/* Static balance (theory 9): creation, generalised forces, minimum-norm joint forces.
 *
 *   τ = Hᵀ C⁻ᵀ g   generalised forces of the loads: τ_j += h_jᵀ (wrench of the subtree), from the leaves
 *   f̄ = -D Z Zᵀ D⁻¹ τ   minimum-norm joint forces */
#include "statics/statics.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"

#include <string.h>

static km_status add_joint_actuator(const km_mechanism *m, int coordinate, km_statics *st, km_error *error) {
  km_statics_workspace *w = st->work;
  const char *label = m->model->coordinates[coordinate].label;
  if (m->held[coordinate])
    return km_fail(error, KM_USAGE, "actuator \"%s\" is held; expected a joint that is free to move", label);
  if (w->actuated[coordinate])
    return km_fail(error, KM_USAGE, "actuator \"%s\" is named twice; expected each joint once", label);
  int i = st->actuator_count++;
  w->actuators[i] = (km_port){.kind = KM_PORT_JOINT, .coordinate = coordinate, .name = label};
  w->actuated[coordinate] = true;
  return KM_OK;
}

static km_status add_point_actuator(const km_mechanism *m, const km_port *point, km_statics *st, km_error *error) {
  km_statics_workspace *w = st->work;
  int i = st->actuator_count++;
  w->actuators[i] = *point;
  w->row[i] = KM_ARENA_NEW(&w->arena, double, (size_t)m->coordinate_count);
  return w->row[i] ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the balance of forces");
}

/* Adds the actuators; NULL: every free coordinate. */
static km_status add_actuators(const km_mechanism *m, const km_port *actuators, int count, km_statics *st,
                               km_error *error) {
  km_status status = KM_OK;
  st->actuators = st->work->actuators;
  for (int c = 0; c < m->coordinate_count && !actuators && !status; ++c)
    if (!m->held[c])
      status = add_joint_actuator(m, c, st, error);
  for (int i = 0; i < count && actuators && !status; ++i)
    status = actuators[i].kind == KM_PORT_JOINT ? add_joint_actuator(m, actuators[i].coordinate, st, error)
                                                : add_point_actuator(m, &actuators[i], st, error);
  return status;
}

static km_status allocate(const km_mechanism *m, int requested, km_statics *st, km_error *error) {
  km_statics_workspace *w = st->work;
  size_t coordinates = (size_t)m->coordinate_count, actuators = coordinates + (size_t)requested;
  w->actuators = KM_ARENA_NEW(&w->arena, km_port, actuators);
  w->part = KM_ARENA_NEW(&w->arena, int, actuators);
  w->tree_joint = KM_ARENA_NEW(&w->arena, int, actuators);
  w->tree_load = KM_ARENA_NEW(&w->arena, double, actuators);
  w->column = KM_ARENA_NEW(&w->arena, int, actuators);
  w->row = KM_ARENA_NEW(&w->arena, double *, actuators);
  w->actuated = KM_ARENA_NEW(&w->arena, bool, coordinates);
  w->twist = KM_ARENA_NEW(&w->arena, km_twist, coordinates);
  w->subtree = KM_ARENA_NEW(&w->arena, km_wrench, (size_t)m->topology.body_count);
  w->tau = KM_ARENA_NEW(&w->arena, double, coordinates);
  w->force = KM_ARENA_NEW(&w->arena, double, coordinates);
  w->least_load = KM_ARENA_NEW(&w->arena, double, coordinates);
  st->actuator_forces = KM_ARENA_NEW(&w->arena, double, actuators);
  st->friction = KM_ARENA_NEW(&w->arena, double, actuators);
  st->contacts = KM_ARENA_NEW(&w->arena, km_contact_force, (size_t)m->model->module_count + coordinates);
  w->squares = KM_ARENA_NEW(&w->arena, double, actuators);
  st->least_norm = KM_ARENA_NEW(&w->arena, double, coordinates);
  st->directions = KM_ARENA_NEW(&w->arena, double, KM_MAX_DIRECTIONS *coordinates);
  st->falls = KM_ARENA_NEW(&w->arena, bool, KM_MAX_DIRECTIONS);
  st->reactions = KM_ARENA_NEW(&w->arena, km_reaction, (size_t)m->topology.joint_count);
  return w->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the balance of forces")
                         : km_reaction_workspace_reserve(m, w, error);
}

static km_status check_actuators(const km_mechanism *m, const km_port *actuators, int count, km_error *error) {
  km_status status = actuators ? km_check_list(actuators, count, "actuators", error) : KM_OK;
  for (int i = 0; i < count && actuators && !status; ++i) {
    const km_port *h = &actuators[i];
    double length = km_vec3_norm(km_vec3_from_array(h->direction));
    if (h->kind == KM_PORT_JOINT)
      status = km_check_index(h->coordinate, m->coordinate_count, "coordinate", error);
    else if (h->kind != KM_PORT_POINT || !h->name || !(fabs(length - 1.0) < 1e-6))
      status = km_fail(error, KM_USAGE, "an actuator that is neither a joint nor a point with a name and a direction");
    else
      status = km_check_index(h->frame, m->model->frame_count, "frame", error);
  }
  return status;
}

km_status km_statics_create_for(const km_mechanism *m, const km_port *actuators, int actuator_count, km_axes axes,
                                km_statics *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_statics){0};
  km_status fits = km_check_given(m != NULL, "mechanism", error);
  if (!fits)
    fits = check_actuators(m, actuators, actuator_count, error);
  if (!fits)
    fits = axes == KM_AXES_JOINT || axes == KM_AXES_FIXED ? KM_OK
                                                          : km_fail(error, KM_USAGE, "%d names no axes", (int)axes);
  if (fits)
    return fits;
  *out = (km_statics){.work = KM_NEW(km_statics_workspace, 1)};
  if (!out->work)
    return km_fail(error, KM_MEMORY, "out of memory for the balance of forces");
  out->work->mechanism = m;
  out->axes = axes;
  km_status status = allocate(m, actuators ? actuator_count : 0, out, error);
  if (!status)
    status = add_actuators(m, actuators, actuator_count, out, error);
  if (!status)
    status = km_blocks_make(m, out, error);
  if (!status && !km_actuator_workspace_reserve(out))
    status = km_fail(error, KM_MEMORY, "out of memory for the actuators");
  return status;
}

km_status km_statics_create(const km_mechanism *m, const int *actuators, int actuator_count, km_axes axes,
                            km_statics *out, km_error *error) {
  if (!actuators)
    return km_statics_create_for(m, NULL, 0, axes, out, error);
  km_status status = km_check_list(actuators, actuator_count, "actuators", error);
  km_port *ports = KM_NEW(km_port, (size_t)(status ? 0 : actuator_count));
  if (out)
    *out = (km_statics){0};
  if (!status && !ports)
    status = km_fail(error, KM_MEMORY, "out of memory for the actuators");
  for (int i = 0; i < actuator_count && !status; ++i)
    ports[i] = (km_port){.kind = KM_PORT_JOINT, .coordinate = actuators[i]};
  if (!status)
    status = km_statics_create_for(m, ports, actuator_count, axes, out, error);
  km_free(ports);
  return status;
}

void km_statics_free(km_statics *st) {
  if (!st)
    return;
  if (st->work) {
    km_reaction_workspace_free(st->work);
    km_arena_free(&st->work->arena);
  }
  km_free(st->work);
  *st = (km_statics){0};
}

/* Returns the mechanism's extent from its origin, the scale between forces and moments. */
static double extent(const km_mechanism *m, const km_forces *f) {
  double square = 0.0;
  for (int b = 1; b < m->topology.body_count; ++b)
    square = fmax(square, km_vec3_dot(f->pose[b].p, f->pose[b].p));
  double size = sqrt(square);
  for (int i = 0; i < m->topology.substructure_count; ++i)
    size = fmax(size, m->substructures[i].size);
  return size > 0.0 ? size : 1.0;
}

/* Computes τ = Hᵀ C⁻ᵀ g by one pass from the leaves (theory 9.1), and its rounding. */
static void compute_generalised_forces(const km_mechanism *m, const km_state *s, const km_forces *f,
                                       km_statics_workspace *w) {
  const km_topology *t = &m->topology;
  double size = extent(m, f);
  km_twists_about(m, s, f->pose, w->twist);
  memcpy(w->subtree, f->body, (size_t)t->body_count * sizeof *f->body);
  memcpy(w->tau, f->joint, (size_t)m->coordinate_count * sizeof *w->tau);
  for (int c = 0; c < m->coordinate_count; ++c) {
    bool length = km_model_coordinate_is_length(m->model, c);
    w->least_load[c] =
        km_load_rounding * (length ? f->force_size + f->couple_size / size : f->force_size * size + f->couple_size);
  }
  for (int i = t->body_count - 2; i >= 0; --i) {
    const km_arc *arc = &m->arcs[i];
    int first = m->model->joints[arc->joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, arc->joint); ++c)
      w->tau[c] += (arc->is_reversed ? -1.0 : 1.0) * km_wrench_power(w->subtree[arc->body], w->twist[c]);
    w->subtree[arc->parent] = km_wrench_axpy(1.0, w->subtree[arc->body], w->subtree[arc->parent]);
  }
}

/* Computes f̄ = −D Z Zᵀ D⁻¹ τ; Z is 1 outside loops and couplings. */
static void compute_minimum_norm_forces(const km_mechanism *m, km_state *s, km_statics *st) {
  const double *tau = st->work->tau;
  for (int c = 0; c < m->coordinate_count; ++c)
    st->least_norm[c] = m->substructure_of[c] < 0 && !m->held[c] ? 0.0 - tau[c] : 0.0;
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    const km_substructure *sub = &m->substructures[i];
    const int *coordinate = m->column_coordinate + sub->column_start;
    if (km_state_project_onto_motions(m, s, i, tau, s->work)) {
      for (int j = 0; j < sub->columns; ++j)
        st->least_norm[coordinate[j]] = 0.0 - m->scale[coordinate[j]] * s->work[j];
      continue;
    }
    const double *z = km_state_basis(s, i);
    for (int k = 0; k < km_factor_freedom(s->factor[i]); ++k, z += sub->columns) {
      double g = 0.0;
      for (int j = 0; j < sub->columns; ++j)
        g += z[j] * tau[coordinate[j]] / m->scale[coordinate[j]];
      for (int j = 0; j < sub->columns; ++j)
        st->least_norm[coordinate[j]] -= m->scale[coordinate[j]] * z[j] * g;
    }
  }
}

static void compute_loads(const km_mechanism *m, const km_state *s, const km_forces *f, km_statics *st) {
  compute_generalised_forces(m, s, f, st->work);
  km_pushed_points_update(m, f, st);
}

void km_statics_actuators_compute(const km_mechanism *m, const km_state *s, const km_forces *f, km_statics *st) {
  compute_loads(m, s, f, st);
  km_actuator_forces_solve(m, s, st);
}

static void clear_reactions(const km_mechanism *m, km_statics *st) {
  const double unknown = nan("");
  for (int j = 0; j < m->topology.joint_count; ++j)
    st->reactions[j] = (km_reaction){{unknown, unknown, unknown}, {unknown, unknown, unknown}, {false}};
  for (int i = 0; i < m->topology.substructure_count; ++i)
    st->work->reactions_of[i].degree = 0;
  st->degree = 0;
}

/* Sets all results to NaN: the mobility of the state is unknown. */
static void clear_results(const km_mechanism *m, km_statics *st) {
  const double unknown = nan("");
  for (int i = 0; i < st->actuator_count; ++i)
    st->actuator_forces[i] = st->friction[i] = unknown;
  st->contact_count = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    st->least_norm[c] = unknown;
  clear_reactions(m, st);
  st->held = st->redundant = false;
  st->direction_count = 0;
}

void km_statics_skip_reactions(const km_mechanism *m, km_statics *st) {
  clear_reactions(m, st);
  st->work->no_reactions = true;
}

/* Applies the actuators' forces if they hold, else f̄. */
static void apply_balancing_forces(const km_mechanism *m, const km_forces *f, km_statics *st) {
  km_statics_workspace *w = st->work;
  size_t bytes = (size_t)m->coordinate_count * sizeof *w->force;
  memcpy(w->force, st->least_norm, bytes);
  if (!st->held)
    return;
  memset(w->force, 0, bytes);
  for (int i = 0; i < st->actuator_count; ++i)
    if (st->actuators[i].kind == KM_PORT_JOINT)
      w->force[st->actuators[i].coordinate] = st->actuator_forces[i];
  km_pushed_points_apply(m, f, st);
}

void km_statics_forces_balance(const km_mechanism *m, km_state *s, km_forces *f, km_statics *st) {
  compute_loads(m, s, f, st);
  compute_minimum_norm_forces(m, s, st);
  km_actuator_forces_solve(m, s, st);
}

km_status km_statics_balance(const km_mechanism *m, km_state *s, km_forces *f, km_statics *st) {
  km_statics_workspace *w = st->work;
  km_statics_forces_balance(m, s, f, st);
  if (!w->no_reactions) {
    apply_balancing_forces(m, f, st);
    km_reactions_compute(m, s, f, st);
  }
  return w->arena.failed ? KM_MEMORY : KM_OK;
}

void km_statics_reactions_compute(const km_mechanism *m, km_state *s, const km_forces *f, const double *driving,
                                  km_statics *st) {
  compute_generalised_forces(m, s, f, st->work);
  memcpy(st->work->force, driving, (size_t)m->coordinate_count * sizeof *driving);
  km_reactions_compute(m, s, f, st);
}

static bool is_for(const km_mechanism *m, const km_forces *f, const km_statics *st) {
  return st && st->work && st->work->mechanism == m && f && f->mechanism == m;
}

static bool can_balance(const km_mechanism *m, km_state *s, const km_forces *f, const km_statics *st) {
  return is_for(m, f, st) && km_state_mobility_is_known(m, s);
}

km_status km_statics_find(const km_mechanism *m, km_state *s, km_forces *f, km_statics *st) {
  if (!is_for(m, f, st))
    return KM_USAGE;
  if (!km_state_mobility_is_known(m, s)) {
    clear_results(m, st);
    return KM_USAGE;
  }
  km_forces_compute(m, s, f);
  return km_statics_balance(m, s, f, st);
}

km_status km_statics_compute(const km_mechanism *m, km_state *s, km_forces *f, km_statics *st) {
  const bool is_valid = can_balance(m, s, f, st);
  if (is_valid)
    km_statics_find_friction(m, s, f, st);
  km_status status = km_statics_find(m, s, f, st);
  if (is_valid)
    km_statics_list_contacts(m, s, f, st);
  if (!status)
    km_statics_mark(m, st);
  if (status != KM_USAGE)
    memcpy(st->gravity, &f->stated_gravity, sizeof st->gravity);
  return status;
}
