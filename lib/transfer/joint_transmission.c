/* Transmission and pressure angles of the hinges of a planar linkage, by the forces of a unit load at the output.
 *
 *   F_j force in hinge j that balances a unit load at the output by the input;   v_j velocity of its point
 *   pressure angle α_j : cos α_j = |F_j · v_j| / (|F_j| |v_j|), 0 to 90°;   transmission angle μ_j = 90° − α_j
 *
 * The force in a link with two hinges and no load is along their line. So in a four-bar μ at the joint of coupler and
 * output link is the angle between these links, or its supplement. Source: H. Alt 1932. */
#include "transfer/joint_transmission.h"

#include "spatial/wrench.h"
#include "statics/statics.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

/* Forces and velocities below this part of the largest one are rounding. */
static const double relative_rounding = 1e-9;

/* True if all loops of the input's substructure are planar. */
static bool is_planar(const km_mechanism *m, const km_port *input) {
  int index = input->kind == KM_PORT_JOINT ? m->substructure_of[input->coordinate] : -1;
  if (index < 0 || m->substructures[index].program_count == 0)
    return false;
  const km_substructure *sub = &m->substructures[index];
  for (int p = sub->program_start; p < sub->program_start + sub->program_count; ++p)
    if (!m->programs[p].planar)
      return false;
  return true;
}

/* True for a hinge of the substructure between two moving links. */
static bool is_listed(const km_mechanism *m, int substructure, int joint) {
  const km_model_joint *def = &m->model->joints[joint];
  const km_joint_type type = def->type;
  if (type != KM_RX && type != KM_RY && type != KM_RZ)
    return false;
  const bool is_grounded = m->model->frames[def->frame[0]].body == 0 || m->model->frames[def->frame[1]].body == 0;
  return !is_grounded && m->substructure_of[def->first_coordinate] == substructure;
}

static km_status create_parts(const km_mechanism *m, const km_port *input, const km_port *output,
                              km_joint_transmission *w, km_error *error) {
  const double *d = output->direction;
  const km_load load = {.frame = output->frame, .force = {-d[0], -d[1], -d[2]}};
  w->mechanism = m;
  w->output = *output;
  w->joint = KM_ARENA_NEW(&w->arena, int, (size_t)m->model->joint_count);
  w->zero = KM_ARENA_NEW(&w->arena, double, (size_t)m->coordinate_count);
  w->motion = KM_ARENA_NEW(&w->arena, km_body_motion, (size_t)m->topology.body_count);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the transmission");
  if (!is_planar(m, input))
    return KM_OK;
  for (int j = 0; j < m->model->joint_count; ++j)
    if (is_listed(m, m->substructure_of[input->coordinate], j))
      w->joint[w->count++] = j;
  km_status status = km_forces_create_loads_only(m, &load, output->kind == KM_PORT_POINT, &w->forces, error);
  if (!status)
    status = km_statics_create(m, &input->coordinate, 1, KM_AXES_FIXED, &w->statics, error);
  if (!status && output->kind == KM_PORT_JOINT)
    w->forces->extra[output->coordinate] = -1.0;
  return status;
}

km_status km_joint_transmission_create(const km_mechanism *m, const km_port *input, const km_port *output,
                                       km_joint_transmission **out, km_error *error) {
  *out = KM_NEW(km_joint_transmission, 1);
  if (!*out)
    return km_fail(error, KM_MEMORY, "out of memory for the transmission");
  km_status status = create_parts(m, input, output, *out, error);
  if (status) {
    km_joint_transmission_free(*out);
    *out = NULL;
  }
  return status;
}

void km_joint_transmission_free(km_joint_transmission *w) {
  if (!w)
    return;
  km_forces_free(w->forces);
  km_statics_free(&w->statics);
  km_arena_free(&w->arena);
  km_free(w);
}

bool km_joint_transmission_columns(const km_joint_transmission *w, km_table *table) {
  const char *unit = w->mechanism->model->units.angle->suffix;
  bool added = true;
  for (int i = 0; i < w->count && added; ++i) {
    const char *label = w->mechanism->model->joints[w->joint[i]].label;
    added = km_table_add_joined_column(table, "transmission.", label, "", unit) &&
            km_table_add_joined_column(table, "pressure.", label, "", unit);
  }
  return added;
}

/* Velocity of a hinge's point. */
static km_vec3 hinge_velocity(const km_joint_transmission *w, const km_state *s, int joint) {
  const km_mechanism *m = w->mechanism;
  int body = m->model->frames[m->model->joints[joint].frame[0]].body;
  return km_point_velocity(w->motion[body].V, km_joint_pose(m, s, joint).p);
}

static km_vec3 hinge_force(const km_joint_transmission *w, int joint) {
  return km_vec3_from_array(w->statics.reactions[joint].force);
}

bool km_joint_transmission_compute(km_state *s, km_joint_transmission *w, const double *rates, double *cells) {
  const km_mechanism *m = w->mechanism;
  if (!w->count)
    return true;
  km_poses_compute(m, s);
  km_body_motions(m, s, rates, w->zero, w->motion);
  km_forces_compute(m, s, w->forces);
  const km_status status = km_statics_compute(m, s, w->forces, &w->statics);
  const bool balanced = status == KM_OK && w->statics.held;
  double fastest = 0.0, strongest = 0.0;
  for (int i = 0; i < w->count; ++i) {
    fastest = fmax(fastest, km_vec3_norm(hinge_velocity(w, s, w->joint[i])));
    strongest = fmax(strongest, km_vec3_norm(hinge_force(w, w->joint[i])));
  }
  for (int i = 0; i < w->count; ++i) {
    km_vec3 v = hinge_velocity(w, s, w->joint[i]), F = hinge_force(w, w->joint[i]);
    double speed = km_vec3_norm(v), force = km_vec3_norm(F), across = km_vec3_norm(km_vec3_cross(F, v));
    bool defined = balanced && speed > relative_rounding * fastest && force > relative_rounding * strongest;
    double pressure = defined ? atan2(across, fabs(km_vec3_dot(F, v))) / m->model->units.angle->si : nan("");
    cells[2 * i] = 0.5 * M_PI / m->model->units.angle->si - pressure;
    cells[2 * i + 1] = pressure;
  }
  return status != KM_MEMORY;
}
