/* Forces that act during a motion: dampers, friction, motors, controllers, tyres, with dissipated and supplied power
 * (docs/theory.md 11.8).
 *
 *   friction: −F s(v),  s = 1 above the stiction speed, else x (2 − x)      PID: k_p e + k_i ∫e + k_d ė */
#include "forces/motion_forces.h"

#include "base/arguments.h"
#include "kmech/dynamics.h"

#include <string.h>

static void add_loaded_body(km_moving_forces *out, bool *is_listed, int body) {
  if (!is_listed[body])
    out->loaded_bodies[out->loaded_body_count++] = body;
  is_listed[body] = true;
}

static void add_loaded_port(const km_model *model, km_moving_forces *out, bool *is_listed, const km_module_port *port) {
  int frames = port->coordinate == KM_MODULE_PORT_FRAMES ? 2 : port->coordinate == KM_MODULE_PORT_FRAME ? 1 : 0;
  for (int side = 0; side < frames; ++side)
    add_loaded_body(out, is_listed, model->frames[port->frame[side]].body);
}

static void list_loaded_bodies(const km_model *model, const km_forces *f, bool *is_listed) {
  km_moving_forces *out = f->moving;
  for (int i = 0; i < f->load_count; ++i)
    add_loaded_body(out, is_listed, model->frames[f->loads[i].frame].body);
  for (int i = 0; i < f->user.frame_count; ++i)
    add_loaded_body(out, is_listed, model->frames[f->user.frames[i]].body);
  for (int i = 0; i < model->module_count; ++i) {
    for (int k = 0; k < model->modules[i].input_count; ++k)
      add_loaded_port(model, out, is_listed, &model->modules[i].inputs[k].port);
    add_loaded_port(model, out, is_listed, &model->modules[i].output);
  }
}

/* Lists coordinates with dampers and constant friction. */
static void list_coordinates(const km_mechanism *m, km_moving_forces *out) {
  for (int c = 0; c < m->coordinate_count; ++c) {
    const km_model_coordinate *def = &m->model->coordinates[c];
    if (m->held[c])
      continue;
    if (def->damping != 0.0)
      out->dampers[out->damper_count++] = c;
    if (def->friction > 0.0)
      out->constant_friction[out->constant_friction_count++] = c;
  }
}

/* True if the force depends on an acceleration: by its variable, or as the derivative of a controlled velocity. */
static bool is_implicit(const km_model_module *module) {
  bool differentiates = module->type == KM_MODULE_PID && module->kd != 0.0;
  return module->variable == KM_VARIABLE_ACCELERATION || (module->variable == KM_VARIABLE_VELOCITY && differentiates);
}

/* Lists the force modules except springs and contacts, and numbers their internal states. */
static void list_modules(const km_model *model, km_moving_forces *out) {
  for (int i = 0; i < model->module_count; ++i) {
    const km_model_module *module = &model->modules[i];
    if (module->type == KM_MODULE_CONTACT ||
        (module->type == KM_MODULE_STIFFNESS && module->variable == KM_VARIABLE_DISPLACEMENT))
      continue;
    if (is_implicit(module))
      out->implicit[out->implicit_count++] = out->module_count;
    out->first_state_of[out->module_count] = out->state_count;
    out->modules[out->module_count++] = module;
    out->state_count += km_module_internal_count(module);
  }
}

/* Checks that tyres act between frames and have positive parameters. */
static km_status check_tires(const km_model *model, km_error *error) {
  for (int i = 0; i < model->module_count; ++i) {
    const km_model_module *module = &model->modules[i];
    const km_tire *t = &module->tire;
    if (module->type != KM_MODULE_TIRE)
      continue;
    if (module->output.coordinate >= 0)
      return km_fail(error, KM_MODEL, "%s: a tyre acts in a joint; expected the frames of the road and the wheel",
                     module->where);
    const struct {
      const char *key;
      double value;
    } needed[] = {{"unloaded_radius", t->radius},
                  {"vertical_stiffness", t->stiffness},
                  {"longitudinal_stiffness", t->longitudinal},
                  {"lateral_stiffness", t->lateral},
                  {"relaxation_length_x", t->relaxation[0]},
                  {"relaxation_length_y", t->relaxation[1]}};
    for (size_t k = 0; k < sizeof needed / sizeof *needed; ++k)
      if (!(needed[k].value > 0.0))
        return km_fail(error, KM_MODEL, "%s.tire.%s: found %g; a simulation expects a positive number", module->where,
                       needed[k].key, needed[k].value);
  }
  return KM_OK;
}

km_status km_forces_prepare_motion(km_forces *f, km_error *error) {
  if (f->moving)
    return KM_OK;
  const km_mechanism *m = f->mechanism;
  km_status status = check_tires(m->model, error);
  if (status)
    return status;
  km_arena *arena = &f->arena, scratch = {0};
  size_t bodies = (size_t)m->topology.body_count, coordinates = (size_t)m->coordinate_count;
  size_t modules = (size_t)m->model->module_count;
  bool *is_listed = KM_ARENA_NEW(&scratch, bool, bodies);
  km_moving_forces *out = KM_ARENA_NEW(arena, km_moving_forces, 1);
  if (out)
    *out = (km_moving_forces){.loaded_bodies = KM_ARENA_NEW(arena, int, bodies),
                              .dampers = KM_ARENA_NEW(arena, int, coordinates),
                              .constant_friction = KM_ARENA_NEW(arena, int, coordinates),
                              .modules = KM_ARENA_NEW(arena, const km_model_module *, modules),
                              .first_state_of = KM_ARENA_NEW(arena, int, modules),
                              .implicit = KM_ARENA_NEW(arena, int, modules),
                              .implicit_force = KM_ARENA_NEW(arena, double, modules),
                              .internal_state = KM_ARENA_NEW(arena, double, 2 * modules),
                              .internal_rate = KM_ARENA_NEW(arena, double, 2 * modules),
                              .drive_force = KM_ARENA_NEW(arena, double, coordinates)};
  f->acceleration = KM_ARENA_NEW(arena, km_twist, bodies);
  if (!arena->failed && !scratch.failed) {
    f->moving = out;
    list_loaded_bodies(m->model, f, is_listed);
    list_coordinates(m, out);
    list_modules(m->model, out);
    size_t n = (size_t)out->implicit_count;
    out->implicit_work = KM_ARENA_NEW(arena, double, n *n + 4 * n);
    out->implicit_places = KM_ARENA_NEW(arena, size_t, n);
    f->moving = km_user_forces_prepare(f) ? out : NULL;
  }
  km_arena_free(&scratch);
  return f->moving ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the forces");
}

static void add_dampers(const km_mechanism *m, const km_state *s, km_forces *f) {
  for (int i = 0; i < f->moving->damper_count; ++i) {
    int c = f->moving->dampers[i];
    double force = -m->model->coordinates[c].damping * s->rate[c];
    f->joint[c] += force;
    f->moving->dissipation -= force * s->rate[c];
  }
}

double km_stiction_speed(const km_mechanism *m, const km_joint_friction *friction) {
  return friction && friction->stiction_velocity > 0.0 ? friction->stiction_velocity
                                                       : 1e-3 * m->length * m->model->units.time->si;
}

double km_slip_share(double speed, double stiction) {
  double x = fabs(speed) / stiction;
  return copysign(x < 1.0 ? x * (2.0 - x) : 1.0, speed);
}

/* Rate of a coordinate that corresponds to the stiction speed; −1: distance between frames. A hinge slides at its
 * friction radius, by default at the characteristic length. */
static double stiction_rate(const km_mechanism *m, int c) {
  if (c < 0)
    return km_stiction_speed(m, NULL);
  const km_model_coordinate *def = &m->model->coordinates[c];
  const km_joint_friction *friction = &m->model->joints[def->joint].friction;
  double radius = friction->radius > 0.0 ? friction->radius : m->length;
  return km_stiction_speed(m, friction) / (km_model_coordinate_is_length(m->model, c) ? 1.0 : radius);
}

/* Adds constant joint friction −F s(v). */
static void add_friction(const km_mechanism *m, const km_state *s, km_forces *f) {
  for (int i = 0; i < f->moving->constant_friction_count && !f->moving->frictionless; ++i) {
    int c = f->moving->constant_friction[i];
    double force = -m->model->coordinates[c].friction * km_slip_share(s->rate[c], stiction_rate(m, c));
    f->joint[c] += force;
    f->moving->dissipation -= force * s->rate[c];
  }
}

static void add_reaction_friction(const km_mechanism *m, const km_state *s, km_forces *f) {
  const double *friction = f->moving->reaction_friction;
  for (int c = 0; friction && c < m->coordinate_count; ++c) {
    f->joint[c] += friction[c];
    f->moving->dissipation -= friction[c] * s->rate[c];
  }
}

/* Value of the module's variable; of a time law its time. */
static double variable_of(const km_model_module *module, const km_measured *x, double time) {
  return module->variable == KM_VARIABLE_DISPLACEMENT ? x->displacement
         : module->variable == KM_VARIABLE_VELOCITY   ? x->velocity
         : module->variable == KM_VARIABLE_TIME       ? time
                                                      : x->acceleration;
}

/* Controller k_p e + k_i ∫e + k_d ė with e = reference − variable. */
static double controller_force(const km_forces *f, int index, const km_measured *x, double time, double *error) {
  const km_moving_forces *moving = f->moving;
  const km_model_module *module = moving->modules[index];
  double reference[3] = {f->reference[module - f->mechanism->model->modules]};
  if (isnan(reference[0]))
    km_curve_at(&module->reference, time, reference);
  *error = reference[0] - variable_of(module, x, time);
  double rate = module->kd == 0.0                              ? 0.0
                : module->variable == KM_VARIABLE_DISPLACEMENT ? reference[1] - x->velocity
                                                               : reference[1] - x->acceleration;
  double integral = moving->internal_state[moving->first_state_of[index]];
  return module->kp * *error + module->ki * integral + module->kd * rate;
}

/* Rate of a controller's integral: its error, but 0 where the error only pushes further beyond a bound of the force. */
static double integrated_error(const km_forces *f, int index, const km_measured *x, double time) {
  const km_model_module *module = f->moving->modules[index];
  double error, force = controller_force(f, index, x, time, &error);
  bool is_bound = module->saturates && (force - km_module_saturate(module, force)) * module->ki * error > 0.0;
  return is_bound ? 0.0 : error;
}

/* Force of a module's law at what it measures, within its bounds. */
static double law_force(const km_mechanism *m, const km_state *s, const km_forces *f, int index, const km_measured *x) {
  const km_model_module *module = f->moving->modules[index];
  double error, value = variable_of(module, x, s->time);
  bool resists = module->variable == KM_VARIABLE_VELOCITY && !module->curve.form &&
                 (module->type == KM_MODULE_DAMPING || module->type == KM_MODULE_FRICTION);
  double force = module->type == KM_MODULE_PID ? controller_force(f, index, x, s->time, &error)
                 : resists ? km_law_resistance(&module->law, value, stiction_rate(m, module->input.coordinate))
                           : km_module_law_value(module, value);
  return km_module_saturate(module, force);
}

void km_implicit_forces_compute(const km_mechanism *m, const km_state *s, const km_forces *f, double *out) {
  const km_moving_forces *moving = f->moving;
  for (int k = 0; k < moving->implicit_count; ++k) {
    km_measured x = km_module_measure(m, s, f, moving->modules[moving->implicit[k]]);
    out[k] = law_force(m, s, f, moving->implicit[k], &x);
  }
}

/* Force of one module: of an implicit one the unknown of the equations of motion, else that of its law. */
static double module_force(const km_mechanism *m, const km_state *s, const km_forces *f, int index,
                           const km_measured *x) {
  const km_moving_forces *moving = f->moving;
  for (int k = 0; k < moving->implicit_count; ++k)
    if (moving->implicit[k] == index)
      return moving->implicit_force[k];
  return law_force(m, s, f, index, x);
}

/* True for dampers and friction that act where they measure a rate: they dissipate. */
static bool is_dissipative(const km_model_module *module) {
  return (module->type == KM_MODULE_DAMPING || module->type == KM_MODULE_FRICTION) &&
         module->variable == KM_VARIABLE_VELOCITY;
}

/* Adds the force of one module and its power. */
static void add_module(const km_mechanism *m, const km_state *s, km_forces *f, int index) {
  km_moving_forces *moving = f->moving;
  const km_model_module *module = moving->modules[index];
  const km_measured x = km_module_measure(m, s, f, module);
  *km_module_report_of(m, f, module) = (km_module_report){.variable = variable_of(module, &x, s->time)};
  if (module->type == KM_MODULE_TIRE) {
    km_tire_apply(m, f, index);
    return;
  }
  if (module->type == KM_MODULE_FRICTION && moving->frictionless)
    return;
  if (module->type == KM_MODULE_PID)
    moving->internal_rate[moving->first_state_of[index]] = integrated_error(f, index, &x, s->time);
  double force = module_force(m, s, f, index, &x), power = force * km_module_apply(m, s, f, module, force);
  int c = module->output.coordinate;
  km_module_report_of(m, f, module)->force = force;
  km_module_report_of(m, f, module)->power = power;
  if (is_dissipative(module)) {
    moving->dissipation -= power;
    return;
  }
  moving->motor_power += power;
  if (c >= 0 && (module->type == KM_MODULE_MOTOR || module->type == KM_MODULE_PID))
    moving->drive_force[c] += km_length_sense(m, s, c) * force;
}

/* Sums all forces of a motion with dissipated and supplied power. */
void km_forces_update_moving(const km_mechanism *m, const km_state *s, km_forces *f) {
  km_moving_forces *moving = f->moving;
  moving->dissipation = moving->motor_power = 0.0;
  for (int i = 0; i < moving->loaded_body_count; ++i)
    f->body[moving->loaded_bodies[i]] = (km_wrench){{0, 0, 0}, {0, 0, 0}};
  memcpy(f->joint, f->extra, (size_t)m->coordinate_count * sizeof *f->joint);
  moving->motor_power += km_springs_add(m, s, f);
  add_dampers(m, s, f);
  moving->dissipation += km_stops_add(m, s, true, f);
  add_friction(m, s, f);
  add_reaction_friction(m, s, f);
  for (int i = 0; i < moving->module_count; ++i)
    if (moving->modules[i]->output.coordinate >= 0)
      moving->drive_force[moving->modules[i]->output.coordinate] = 0.0;
  for (int i = 0; i < moving->module_count; ++i)
    add_module(m, s, f, i);
  moving->dissipation += km_contacts_add(m, f, !moving->frictionless);
  moving->motor_power += km_loads_add(m, s, f);
  for (int c = 0; c < m->coordinate_count; ++c)
    moving->motor_power += f->extra[c] * s->rate[c];
  if (f->user.compute)
    km_user_forces_add(m, s, f);
}
