/* Forces of a mechanism that moves, beside springs: their list, their sum, and the power that they take and give. */
#include "forces/motion_forces.h"

#include <string.h>

static void touch(km_moving_forces *out, bool *seen, int body) {
  if (!seen[body])
    out->touched[out->touched_count++] = body;
  seen[body] = true;
}

static void touch_port(const km_model *model, km_moving_forces *out, bool *seen, const km_module_port *port) {
  for (int side = 0; side < 2 && port->coordinate < 0; ++side)
    touch(out, seen, model->frames[port->frame[side]].body);
}

static void list_bodies(const km_model *model, const km_forces *f, bool *seen) {
  km_moving_forces *out = f->moving;
  for (int i = 0; i < f->load_count; ++i)
    touch(out, seen, model->frames[f->loads[i].frame].body);
  for (int i = 0; i < model->module_count; ++i) {
    touch_port(model, out, seen, &model->modules[i].input);
    touch_port(model, out, seen, &model->modules[i].output);
  }
}

static bool has_stop(const km_mechanism *m, int c) {
  const km_joint_stop *stop = &m->model->joints[m->model->coordinates[c].joint].stop;
  return (stop->stiffness > 0.0 || stop->damping > 0.0) && km_is_limited(m, c);
}

static void list_coordinates(const km_mechanism *m, km_moving_forces *out) {
  for (int c = 0; c < m->coordinate_count; ++c) {
    const km_model_coordinate *def = &m->model->coordinates[c];
    if (m->held[c])
      continue;
    if (def->damping != 0.0)
      out->dampers[out->damper_count++] = c;
    if (has_stop(m, c))
      out->stops[out->stop_count++] = c;
    if (def->friction > 0.0)
      out->rubbing[out->rubbing_count++] = c;
  }
}

static int memory_need(km_module_type type) {
  return type == KM_MODULE_PID ? 1 : type == KM_MODULE_TIRE ? 2 : 0;
}

static void list_modules(const km_model *model, km_moving_forces *out) {
  for (int i = 0; i < model->module_count; ++i) {
    const km_model_module *module = &model->modules[i];
    if (module->type == KM_MODULE_STIFFNESS)
      continue;
    out->memory_of[out->module_count] = out->memory_count;
    out->modules[out->module_count++] = module;
    out->memory_count += memory_need(module->type);
  }
}

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

/* A ball's component isn't what a torque about its axis turns: a stop of it would give or take energy by the way. */
static km_status check_stops(const km_mechanism *m, km_error *error) {
  for (int c = 0; c < m->coordinate_count; ++c)
    if (m->ball_of[c] >= 0 && !m->held[c] && has_stop(m, c) && (isfinite(m->low[c]) || isfinite(m->high[c])))
      return km_fail(error, KM_MODEL, "joint %s: a stop of one component of a ball; expected one range of its angle",
                     m->model->coordinates[c].label);
  return KM_OK;
}

km_status km_forces_follow_motion(km_forces *f, km_error *error) {
  if (f->moving)
    return KM_OK;
  const km_mechanism *m = f->mechanism;
  km_status status = check_tires(m->model, error);
  if (!status)
    status = check_stops(m, error);
  if (status)
    return status;
  km_arena *arena = &f->arena, scratch = {0};
  size_t bodies = (size_t)m->topology.body_count, coordinates = (size_t)m->coordinate_count;
  size_t modules = (size_t)m->model->module_count;
  bool *seen = KM_ARENA_NEW(&scratch, bool, bodies);
  km_moving_forces *out = KM_ARENA_NEW(arena, km_moving_forces, 1);
  if (out)
    *out = (km_moving_forces){.touched = KM_ARENA_NEW(arena, int, bodies),
                              .dampers = KM_ARENA_NEW(arena, int, coordinates),
                              .stops = KM_ARENA_NEW(arena, int, coordinates),
                              .rubbing = KM_ARENA_NEW(arena, int, coordinates),
                              .modules = KM_ARENA_NEW(arena, const km_model_module *, modules),
                              .memory_of = KM_ARENA_NEW(arena, int, modules),
                              .memory = KM_ARENA_NEW(arena, double, 2 * modules),
                              .rate = KM_ARENA_NEW(arena, double, 2 * modules),
                              .drive = KM_ARENA_NEW(arena, double, coordinates)};
  if (!arena->failed && !scratch.failed) {
    f->moving = out;
    list_bodies(m->model, f, seen);
    list_coordinates(m, out);
    list_modules(m->model, out);
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

/* How far a coordinate is beyond its limits: above (> 0) or below (< 0). */
static double beyond(const km_mechanism *m, const km_state *s, int c) {
  return s->q[c] > m->high[c] ? s->q[c] - m->high[c] : s->q[c] < m->low[c] ? s->q[c] - m->low[c] : 0.0;
}

/* A push against a rate, k x + b v, that never pulls. What it takes is what it doesn't store. */
static double push_of(const km_joint_stop *stop, double x, double v, km_forces *f) {
  double push = stop->stiffness * x + stop->damping * v;
  push = push * x > 0.0 ? push : 0.0;
  f->moving->dissipation += (push - stop->stiffness * x) * v;
  return push;
}

/* The angle of a ball grows along its own axis, q/|q|: the same in both frames. */
static void add_stop_of_ball(const km_mechanism *m, const km_state *s, int c, km_forces *f) {
  const km_joint_stop *stop = &m->model->joints[m->model->coordinates[c].joint].stop;
  double x = km_state_ball_excess(m, c, &s->q[c]);
  if (!(x > 0.0))
    return;
  km_vec3 q = km_vec3_from_array(&s->q[c]), u = km_vec3_scale(1.0 / km_vec3_norm(q), q);
  double push = push_of(stop, x, km_vec3_dot(u, km_vec3_from_array(&s->rate[c])), f);
  f->joint[c] -= push * u.x;
  f->joint[c + 1] -= push * u.y;
  f->joint[c + 2] -= push * u.z;
}

static void add_stops(const km_mechanism *m, const km_state *s, km_forces *f) {
  for (int i = 0; i < f->moving->stop_count; ++i) {
    int c = f->moving->stops[i];
    const km_joint_stop *stop = &m->model->joints[m->model->coordinates[c].joint].stop;
    double x = beyond(m, s, c);
    if (x != 0.0)
      f->joint[c] -= push_of(stop, x, s->rate[c], f);
    add_stop_of_ball(m, s, c, f);
  }
}

double km_stops_energy(const km_mechanism *m, const km_state *s, const km_forces *f) {
  double energy = 0.0;
  for (int i = 0; i < f->moving->stop_count; ++i) {
    int c = f->moving->stops[i];
    double x = beyond(m, s, c);
    double turned = fmax(km_state_ball_excess(m, c, &s->q[c]), 0.0);
    energy += 0.5 * m->model->joints[m->model->coordinates[c].joint].stop.stiffness * (x * x + turned * turned);
  }
  return energy;
}

double km_stiction_speed(const km_mechanism *m, const km_joint_friction *friction) {
  return friction && friction->stiction_velocity > 0.0 ? friction->stiction_velocity
                                                       : 1e-3 * m->length * m->model->units.time->si;
}

double km_slip_share(double speed, double stiction) {
  double x = fabs(speed) / stiction;
  return copysign(x < 1.0 ? x * (2.0 - x) : 1.0, speed);
}

/* Below which rate a coordinate counts as sticking; -1: of a distance between frames. A hinge's surfaces slide at its friction's
 * radius, or at the characteristic length. */
static double sticking_rate(const km_mechanism *m, int c) {
  if (c < 0)
    return km_stiction_speed(m, NULL);
  const km_model_coordinate *def = &m->model->coordinates[c];
  const km_joint_friction *friction = &m->model->joints[def->joint].friction;
  double radius = friction->radius > 0.0 ? friction->radius : m->length;
  return km_stiction_speed(m, friction) / (km_model_coordinate_is_length(m->model, c) ? 1.0 : radius);
}

/* Constant friction. */
static void add_friction(const km_mechanism *m, const km_state *s, km_forces *f) {
  for (int i = 0; i < f->moving->rubbing_count && !f->moving->frictionless; ++i) {
    int c = f->moving->rubbing[i];
    double force = -m->model->coordinates[c].friction * km_slip_share(s->rate[c], sticking_rate(m, c));
    f->joint[c] += force;
    f->moving->dissipation -= force * s->rate[c];
  }
}

static void add_pressed(const km_mechanism *m, const km_state *s, km_forces *f) {
  const double *pressed = f->moving->pressed;
  for (int c = 0; pressed && c < m->coordinate_count; ++c) {
    f->joint[c] += pressed[c];
    f->moving->dissipation -= pressed[c] * s->rate[c];
  }
}

/* A table's rows are joined by lines; before its first and past its last row the force stays. */
double km_motor_force(const km_model_module *module, double time) {
  const double *t = module->table;
  int rows = module->table_count;
  if (rows == 0)
    return km_law_force(&module->law, time);
  if (time <= t[0])
    return t[1];
  for (int i = 1; i < rows; ++i)
    if (time <= t[2 * i])
      return t[2 * i - 1] + (t[2 * i + 1] - t[2 * i - 1]) * (time - t[2 * i - 2]) / (t[2 * i] - t[2 * i - 2]);
  return t[2 * rows - 1];
}

/* A motor's force or a controller's, and its power. */
static void drive(const km_mechanism *m, const km_state *s, km_forces *f, const km_model_module *module, double force) {
  int c = module->output.coordinate;
  f->moving->motor_power += force * km_module_push(m, s, f, module, force);
  if (c >= 0)
    f->moving->drive[c] += km_length_sense(m, s, c) * force;
}

static void add_module(const km_mechanism *m, const km_state *s, km_forces *f, int index) {
  km_moving_forces *moving = f->moving;
  const km_model_module *module = moving->modules[index];
  int memory = moving->memory_of[index];
  double rate;
  switch (module->type) {
  case KM_MODULE_DAMPING:
  case KM_MODULE_FRICTION: {
    if (module->type == KM_MODULE_FRICTION && moving->frictionless)
      break;
    km_module_input(m, s, f, module, &rate);
    double force = km_law_resistance(&module->law, rate, sticking_rate(m, module->input.coordinate));
    moving->dissipation -= force * km_module_push(m, s, f, module, force);
    break;
  }
  case KM_MODULE_MOTOR:
    drive(m, s, f, module, km_motor_force(module, s->time));
    break;
  case KM_MODULE_PID: {
    double error = module->reference - km_module_input(m, s, f, module, &rate);
    moving->rate[memory] = error;
    drive(m, s, f, module, module->kp * error + module->ki * moving->memory[memory] - module->kd * rate);
    break;
  }
  case KM_MODULE_TIRE:
    km_tire_push(m, f, index);
    break;
  default:
    break;
  }
}

static double power_of_loads(const km_mechanism *m, const km_forces *f) {
  double power = 0.0;
  for (int i = 0; i < f->load_count; ++i) {
    const km_load *load = &f->loads[i];
    const km_model_frame *frame = &m->model->frames[load->frame];
    km_pose X = km_pose_product(&f->pose[frame->body], &frame->pose);
    km_twist V = f->twist[frame->body];
    km_vec3 force = km_vec3_from_array(load->force), torque = km_vec3_from_array(load->torque);
    if (load->turning) {
      force = km_rotate(&X.R, force);
      torque = km_rotate(&X.R, torque);
    }
    power += km_wrench_power(km_wrench_at(force, torque, X.p), V);
  }
  return power;
}

void km_forces_update_moving(const km_mechanism *m, const km_state *s, km_forces *f) {
  km_moving_forces *moving = f->moving;
  moving->dissipation = moving->motor_power = 0.0;
  for (int i = 0; i < moving->touched_count; ++i)
    f->body[moving->touched[i]] = (km_wrench){{0, 0, 0}, {0, 0, 0}};
  memcpy(f->joint, f->extra, (size_t)m->coordinate_count * sizeof *f->joint);
  moving->motor_power += km_springs_add(m, s, f);
  add_dampers(m, s, f);
  add_stops(m, s, f);
  add_friction(m, s, f);
  add_pressed(m, s, f);
  for (int i = 0; i < moving->module_count; ++i)
    if (moving->modules[i]->output.coordinate >= 0)
      moving->drive[moving->modules[i]->output.coordinate] = 0.0;
  for (int i = 0; i < moving->module_count; ++i)
    add_module(m, s, f, i);
  if (f->load_count) {
    km_loads_add(m, f);
    moving->motor_power += power_of_loads(m, f);
  }
}
