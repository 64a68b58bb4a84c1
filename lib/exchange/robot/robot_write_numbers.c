/* Data of a coordinate in SI units, and the part that a format can't hold. */
#include "exchange/robot/robot_write.h"

#include <math.h>

static const double no_limit = 1e30;

static bool is_length(const km_written *w, int c) {
  return km_model_coordinate_is_length(w->model, c);
}

double km_written_force(const km_written *w, int c) {
  return w->force * (is_length(w, c) ? 1.0 : w->length);
}

double km_written_rate(const km_written *w, int c) {
  return (is_length(w, c) ? w->length : w->model->units.angle->si) / w->time;
}

double km_written_damping(const km_written *w, int c) {
  return w->force * w->time * (is_length(w, c) ? 1.0 / w->length : w->length);
}

double km_written_inertia(const km_written *w, int c) {
  return w->mass * (is_length(w, c) ? 1.0 : w->length * w->length);
}

bool km_written_is_limited(const km_model *m, int c) {
  return isfinite(m->coordinates[c].low) || isfinite(m->coordinates[c].high) || km_written_held_at(m, c);
}

const double *km_written_held_at(const km_model *m, int c) {
  for (int h = 0; h < m->hold_count; ++h)
    if (m->holds[h].coordinate == c)
      return &m->holds[h].value;
  return NULL;
}

void km_written_range(const km_written *w, int c, double range[2]) {
  const double *held = km_written_held_at(w->model, c);
  double unit = is_length(w, c) ? w->length : w->model->units.angle->si;
  range[0] = fmax(-no_limit, unit * (held ? *held : w->model->coordinates[c].low));
  range[1] = fmin(no_limit, unit * (held ? *held : w->model->coordinates[c].high));
}

double km_written_tolerance(const km_written *w) {
  return w->model->closure_tolerance_given ? w->model->closure_tolerance : 0.0;
}

/* A law k (rest - x), one piece of two coefficients, in a joint's coordinate. */
static bool is_spring(const km_model_module *module) {
  const km_law *law = &module->law;
  return km_module_is_spring_in_joint(module) && law->knot_count == 0 && law->start[1] - law->start[0] == 2 &&
         law->coefficients[law->start[0] + 1] != 0.0;
}

bool km_written_spring(const km_written *w, int c, double *stiffness, double *rest) {
  double slope = 0.0, constant = 0.0;
  for (int i = 0; i < w->model->module_count; ++i) {
    const km_model_module *module = &w->model->modules[i];
    if (!is_spring(module) || module->input.coordinate != c)
      continue;
    const double *a = module->law.coefficients + module->law.start[0];
    constant += a[0];
    slope += a[1];
  }
  double size = km_written_unit(w, c);
  *stiffness = -slope * km_written_force(w, c) / size;
  *rest = slope != 0.0 ? -constant / slope * size : 0.0;
  return slope != 0.0;
}

bool km_written_ball_spring(km_written *w, int first, double *stiffness) {
  bool any = false, alike = true;
  for (int k = 0; k < 3; ++k) {
    double own, rest;
    any = km_written_spring(w, first + k, &own, &rest) || any;
    *stiffness = k == 0 ? own : *stiffness;
    alike = alike && own == *stiffness && rest == 0.0 && w->q[first + k] == 0.0;
  }
  if (any && !alike)
    km_written_omit(w, "springs not written", w->model->coordinates[first].label);
  return any && alike;
}

/* Springs that add up to a constant force are none of the format's. */
static bool is_written(const km_written *w, const km_model_module *module) {
  double stiffness, rest;
  return is_spring(module) && km_written_spring(w, module->input.coordinate, &stiffness, &rest);
}

void km_written_omit_forces(km_written *w) {
  const km_model *m = w->model;
  for (int i = 0; i < m->module_count; ++i)
    if (!is_written(w, &m->modules[i]))
      km_written_omit(w, "force modules not written, as the format has none of their kind", m->modules[i].name);
  for (int i = 0; i < m->load_count; ++i)
    km_written_omit(w, "loads not written", m->loads[i].name);
  for (int j = 0; j < m->joint_count; ++j) {
    const km_model_joint *def = &m->joints[j];
    if (def->friction.coefficient > 0.0 || def->prescribed.law != KM_MOTION_FREE)
      km_written_omit(w, "friction coefficients and prescribed motions not written", w->joints[j]);
    if (def->stop.stiffness > 0.0 || def->stop.damping > 0.0)
      km_written_omit(w, "stiffness and damping of stops not written", w->joints[j]);
  }
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->coordinates[c].rate != 0.0)
      km_written_omit(w, "initial velocities not written", m->coordinates[c].label);
}

static void hold(km_written *w, int c, unsigned held) {
  const km_model_coordinate *def = &w->model->coordinates[c];
  const km_model_joint *joint = &w->model->joints[def->joint];
  const struct {
    unsigned what;
    bool stated;
    const char *kind;
  } all[] = {{KM_HELD_LIMITS, km_written_is_limited(w->model, c), "limits not written"},
             {KM_HELD_TURN, joint->most_turn > 0.0 && c == joint->first_coordinate, "limits not written"},
             {KM_HELD_FORCE, isfinite(def->max_force), "largest forces not written"},
             {KM_HELD_RATE, isfinite(def->max_rate), "largest rates not written"},
             {KM_HELD_DAMPING, def->damping != 0.0, "damping not written"},
             {KM_HELD_FRICTION, def->friction != 0.0, "constant friction not written"},
             {KM_HELD_ARMATURE, def->armature != 0.0, "inertias of rotors not written"}};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    if (all[i].stated && !(held & all[i].what))
      km_written_omit(w, all[i].kind, def->label);
}

void km_written_hold(km_written *w, int first, int count, unsigned held) {
  for (int c = first; c < first + count; ++c)
    hold(w, c, held);
}

void km_written_hold_none(km_written *w, int joint) {
  km_written_hold(w, w->model->joints[joint].first_coordinate, km_model_freedom(w->model, joint), 0);
}
