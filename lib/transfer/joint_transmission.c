/* Transmission and pressure angles of the hinges of a planar linkage, and the joint force index, by the forces of a
 * unit load at the output.
 *
 *   F_j force in hinge j that balances a unit load at the output by the input;   v_j velocity of its point
 *   joint force index : max_j |F_j| over the load, all joints of the input's substructure
 *   pressure angle α_j : cos α_j = |F_j · v_j| / (|F_j| |v_j|), 0 to 90°;   transmission angle μ_j = 90° − α_j
 *
 * The force in a link with two hinges and no load is along their line. So in a four-bar μ at the joint of coupler and
 * output link is the angle between these links, or its supplement. Sources: H. Alt 1932; J. Holte and T. Chase 1994
 * (K. Wehage 2016, equation 253). */
#include "transfer/joint_transmission.h"
#include "base/number/tolerances.h"

#include "spatial/wrench.h"
#include "statics/statics.h"
#include "topology/mechanism.h"
#include "transfer/transfer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* True for a hinge of the substructure between two moving links. */
static bool is_listed(const km_mechanism *m, int substructure, int joint) {
  const km_model_joint *def = &m->model->joints[joint];
  const km_joint_type type = def->type;
  if (type != KM_RX && type != KM_RY && type != KM_RZ)
    return false;
  const bool is_grounded = km_joint_body(m->model, joint, 0) == 0 || km_joint_body(m->model, joint, 1) == 0;
  return !is_grounded && m->substructure_of[def->first_coordinate] == substructure;
}

static km_status create_parts(const km_mechanism *m, const km_port *input, const km_port *output,
                              km_joint_transmission *w, km_error *error) {
  w->mechanism = m;
  w->output = *output;
  w->joint = KM_ARENA_NEW(&w->arena, int, (size_t)m->model->joint_count);
  w->zero = KM_ARENA_NEW(&w->arena, double, (size_t)m->coordinate_count);
  w->motion = KM_ARENA_NEW(&w->arena, km_body_motion, (size_t)m->topology.body_count);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the transmission");
  w->substructure = input->kind == KM_PORT_JOINT ? m->substructure_of[input->coordinate] : -1;
  if (w->substructure < 0)
    return KM_OK;
  w->planar = km_substructure_is_planar(m, w->substructure);
  for (int j = 0; j < m->model->joint_count && w->planar; ++j)
    if (is_listed(m, w->substructure, j))
      w->joint[w->count++] = j;
  return km_unit_load_create(m, input, output, &w->forces, &w->statics, error);
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

/* Unit of a force over the output's load; NULL: none. */
static const char *index_unit(const km_joint_transmission *w, char out[32]) {
  const km_model *model = w->mechanism->model;
  if (w->output.kind != KM_PORT_JOINT || !km_coordinate_turns(w->mechanism, w->output.coordinate))
    return NULL;
  snprintf(out, 32, "1/%s", model->units.length->suffix);
  return out;
}

bool km_joint_transmission_columns(const km_joint_transmission *w, km_table *table) {
  char per_length[32];
  const char *unit = w->mechanism->model->units.angle->suffix;
  bool added = true;
  for (int i = 0; i < w->count && added; ++i) {
    const char *label = w->mechanism->model->joints[w->joint[i]].label;
    added = km_table_add_joined_column(table, "transmission.", label, "", unit) &&
            km_table_add_joined_column(table, "pressure.", label, "", unit);
  }
  return added && km_table_add_joined_column(table, "joint_force_index", "", "", index_unit(w, per_length));
}

size_t km_joint_transmission_count(const km_joint_transmission *w) {
  return 2 * (size_t)w->count + 1;
}

/* Velocity of a hinge's point. */
static km_vec3 hinge_velocity(const km_joint_transmission *w, const km_state *s, int joint) {
  const km_mechanism *m = w->mechanism;
  int body = km_joint_body(m->model, joint, 0);
  return km_point_velocity(w->motion[body].V, km_joint_pose(m, s, joint).p);
}

static km_vec3 hinge_force(const km_joint_transmission *w, int joint) {
  return km_vec3_from_array(w->statics.reactions[joint].force);
}

/* Largest force in a joint of the substructure over the load; NaN where a component is statically indeterminate, but
 * for those across the plane of a planar linkage, which are 0. */
static double joint_force_index(const km_joint_transmission *w) {
  const km_mechanism *m = w->mechanism;
  double largest = 0.0;
  for (int j = 0; j < m->model->joint_count; ++j) {
    const bool *open = w->statics.reactions[j].indeterminate;
    const int freedom = km_model_freedom(m->model, j), first = m->model->joints[j].first_coordinate;
    if (freedom == 0 || m->substructure_of[first] != w->substructure)
      continue;
    if (!w->planar && (open[0] || open[1] || open[2]))
      return nan("");
    largest = fmax(largest, km_vec3_norm(hinge_force(w, j)));
  }
  return largest;
}

bool km_joint_transmission_compute(km_state *s, km_joint_transmission *w, const double *rates, double *cells) {
  const km_mechanism *m = w->mechanism;
  if (w->substructure < 0) {
    *cells = nan("");
    return true;
  }
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
    bool defined = balanced && speed > km_relative_zero * fastest && force > km_relative_zero * strongest;
    double pressure = defined ? atan2(across, fabs(km_vec3_dot(F, v))) / m->model->units.angle->si : nan("");
    cells[2 * i] = 0.5 * M_PI / m->model->units.angle->si - pressure;
    cells[2 * i + 1] = pressure;
  }
  cells[2 * w->count] = balanced ? joint_force_index(w) : nan("");
  return status != KM_MEMORY;
}
