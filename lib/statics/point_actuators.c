/* Actuators that push points of bodies (theory 9.3): r, the rates of the point along its direction d per unit rate of
 * each coordinate, so that a force f along d does the work f r · δq; Z_A has the row r D⁻¹ Z/L. */
#include "statics/statics.h"

static int body_of(const km_mechanism *m, const km_port *point) {
  return m->model->frames[point->frame].body;
}

void km_point_each_mover(const km_mechanism *m, const km_port *point, km_mover_visitor visit, void *context) {
  for (int b = body_of(m, point); b > 0; b = m->topology.parent[b]) {
    int joint = m->topology.arc[b], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c)
      if (!m->held[c])
        visit(context, c, m->topology.is_reversed[joint]);
  }
}

/* Returns the wrench of a point's unit force about the forces' origin. */
static km_wrench unit_push(const km_mechanism *m, const km_forces *f, const km_port *point) {
  km_vec3 d = km_vec3_from_array(point->direction), none = {0, 0, 0};
  return km_wrench_at(d, none, km_frame_origin(m->model, f->pose, point->frame));
}

typedef struct row {
  const km_twist *twist;
  km_wrench push;
  double *out;
} row;

static void fill_row(void *context, int c, bool is_reversed) {
  row *r = context;
  r->out[c] = (is_reversed ? -1.0 : 1.0) * km_wrench_power(r->push, r->twist[c]);
}

void km_pushed_points_update(const km_mechanism *m, const km_forces *f, km_statics *st) {
  km_statics_workspace *w = st->work;
  for (int a = 0; a < st->actuator_count; ++a) {
    const km_port *point = &st->actuators[a];
    if (point->kind != KM_PORT_POINT)
      continue;
    row r = {w->twist, unit_push(m, f, point), w->row[a]};
    km_point_each_mover(m, point, fill_row, &r);
  }
}

void km_pushed_points_apply(const km_mechanism *m, const km_forces *f, km_statics *st) {
  km_statics_workspace *w = st->work;
  for (int a = 0; a < st->actuator_count; ++a) {
    const km_port *point = &st->actuators[a];
    double force = st->actuator_forces[a];
    if (point->kind != KM_PORT_POINT)
      continue;
    for (int b = body_of(m, point); b > 0; b = m->topology.parent[b])
      w->subtree[b] = km_wrench_axpy(force, unit_push(m, f, point), w->subtree[b]);
    for (int c = 0; c < m->coordinate_count; ++c)
      w->tau[c] += force * w->row[a][c];
  }
}

bool km_actuator_has_force(const km_model *model, const km_port *actuator) {
  if (actuator->kind == KM_PORT_POINT)
    return true;
  return km_model_coordinate_is_length(model, actuator->coordinate);
}

double km_actuator_most(const km_mechanism *m, const km_port *actuator) {
  bool joint = m && actuator && actuator->kind == KM_PORT_JOINT;
  return joint && actuator->coordinate >= 0 && actuator->coordinate < m->coordinate_count
             ? m->max_force[actuator->coordinate]
             : HUGE_VAL;
}

bool km_actuator_passes(const km_mechanism *m, const km_port *actuator, double force) {
  return fabs(force) > (1.0 + 1e-9) * km_actuator_most(m, actuator);
}

void km_push_unit(const km_model *model, const km_port *actuator, km_text *out) {
  bool is_valid = model && actuator && actuator->coordinate < model->coordinate_count;
  if (!is_valid || (actuator->kind == KM_PORT_JOINT && actuator->coordinate < 0))
    return;
  if (actuator->kind == KM_PORT_POINT)
    km_text_add(out, model->units.force->suffix);
  else
    km_force_unit(model, actuator->coordinate, out);
}
