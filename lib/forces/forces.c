/* Applied forces of a static balance at a configuration: weights, loads, springs, contacts, stops (docs/theory.md 9.1,
 * 11.8 and 11.15). */
#include "forces/forces.h"

#include "base/arguments.h"
#include "kinematics/body_poses.h"

#include <string.h>

/* Allocates the arrays of forces. */
static bool allocate(km_forces *f, const km_mechanism *m, int load_count) {
  size_t bodies = (size_t)m->topology.body_count;
  f->loads = KM_ARENA_NEW(&f->arena, km_load, (size_t)load_count);
  f->pose = KM_ARENA_NEW(&f->arena, km_pose, bodies);
  f->twist = KM_ARENA_NEW(&f->arena, km_twist, bodies);
  f->body = KM_ARENA_NEW(&f->arena, km_wrench, bodies);
  f->joint = KM_ARENA_NEW(&f->arena, double, (size_t)m->coordinate_count);
  f->extra = KM_ARENA_NEW(&f->arena, double, (size_t)m->coordinate_count);
  f->report = KM_ARENA_NEW(&f->arena, km_module_report, (size_t)m->model->module_count);
  f->springs = KM_ARENA_NEW(&f->arena, const km_model_module *, (size_t)m->model->module_count);
  f->contacts = KM_ARENA_NEW(&f->arena, const km_model_module *, (size_t)m->model->module_count);
  f->stops = KM_ARENA_NEW(&f->arena, int, (size_t)m->coordinate_count);
  f->reference = KM_ARENA_NEW(&f->arena, double, (size_t)m->model->module_count);
  for (int i = 0; f->reference && i < m->model->module_count; ++i)
    f->reference[i] = nan("");
  return !f->arena.failed;
}

static km_status check_loads(const km_model *model, const km_load *loads, int count, km_error *error) {
  km_status status = km_check_list(loads, count, "loads", error);
  for (int i = 0; i < count && !status; ++i)
    status = km_check_index(loads[i].frame, model->frame_count, "frame", error);
  return status;
}

/* Creates the forces without force modules and stops. */
static km_status create(const km_mechanism *m, const double *gravity, const km_load *loads, int load_count,
                        km_forces **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_given(m != NULL, "mechanism", error);
  if (!fits)
    fits = check_loads(m->model, loads, load_count, error);
  if (fits)
    return fits;
  static const km_dimension acceleration = {.length = 1, .mass = 1, .time = -2, .force = -1};
  km_forces *f = KM_NEW(km_forces, 1);
  if (!f || !allocate(f, m, load_count)) {
    km_forces_free(f);
    return km_fail(error, KM_MEMORY, "out of memory for the forces");
  }
  f->mechanism = m;
  f->stated_gravity = gravity ? km_vec3_from_array(gravity) : m->model->gravity;
  f->gravity = km_vec3_scale(km_units_factor(&m->model->units, acceleration), f->stated_gravity);
  f->load_count = load_count;
  if (load_count)
    memcpy(f->loads, loads, (size_t)load_count * sizeof *loads);
  *out = f;
  return KM_OK;
}

km_status km_forces_create(const km_mechanism *m, const double gravity[3], const km_load *loads, int load_count,
                           km_forces **out, km_error *error) {
  km_status status = create(m, gravity, loads, load_count, out, error);
  if (!status)
    status = km_contacts_check(m->model, error);
  if (!status)
    status = km_stops_check(m, error);
  if (!status) {
    km_springs_collect(m->model, *out);
    km_contacts_collect(m->model, *out);
    km_stops_list(m, *out);
  } else if (out) {
    km_forces_free(*out);
    *out = NULL;
  }
  return status;
}

km_status km_forces_create_loads_only(const km_mechanism *m, const km_load *loads, int load_count, km_forces **out,
                                      km_error *error) {
  static const double weightless[3] = {0, 0, 0};
  return create(m, weightless, loads, load_count, out, error);
}

void km_forces_free(km_forces *f) {
  if (!f)
    return;
  km_arena_free(&f->arena);
  km_free(f);
}

int km_model_load_count(const km_model *model) {
  if (!model)
    return 0;
  return model->load_count;
}

km_load km_model_load_at(const km_model *model, int index) {
  if (!model || index < 0 || index >= model->load_count)
    return (km_load){.frame = -1};
  const km_applied_load *d = &model->loads[index];
  return (km_load){
      d->frame, {d->force.x, d->force.y, d->force.z}, {d->torque.x, d->torque.y, d->torque.z}, d->turning, d->scale};
}

km_status km_forces_create_own(const km_mechanism *m, km_forces **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(m != NULL, "mechanism", error);
  if (status)
    return status;
  int count = m->model->load_count;
  km_load *loads = KM_NEW(km_load, (size_t)count + 1);
  for (int i = 0; i < count && loads; ++i)
    loads[i] = km_model_load_at(m->model, i);
  status = loads ? km_forces_create(m, NULL, loads, count, out, error)
                 : km_fail(error, KM_MEMORY, "out of memory for the loads");
  km_free(loads);
  return status;
}

const char *km_model_load_name(const km_model *model, int index) {
  if (!model || index < 0 || index >= model->load_count)
    return "";
  return model->loads[index].name;
}

void km_forces_add_joint(const km_model *model, km_forces *f, int c, double force) {
  f->joint[c] += force;
  if (km_model_coordinate_is_length(model, c))
    f->force_size += fabs(force);
  else
    f->couple_size += fabs(force);
}

static void add_weights(const km_mechanism *m, km_forces *f) {
  for (int b = 1; b < m->topology.body_count; ++b) {
    const km_model_body *body = &m->model->bodies[b];
    if (body->mass > 0.0)
      km_forces_add(f, b, km_vec3_scale(body->mass, f->gravity), (km_vec3){0, 0, 0},
                    km_pose_point(&f->pose[b], body->center_of_mass));
  }
}

/* Factor of a load at the state's coordinates and time. */
static double load_factor(const km_mechanism *m, const km_state *s, const km_load_scale *scale) {
  if (!scale)
    return 1.0;
  int c = scale->coordinate;
  return km_curve_value(&scale->curve, c < 0 ? s->time : km_length_sense(m, s, c) * s->q[c]);
}

double km_loads_add(const km_mechanism *m, const km_state *s, km_forces *f) {
  double power = 0.0;
  for (int i = 0; i < f->load_count; ++i) {
    const km_load *load = &f->loads[i];
    const km_model_frame *frame = &m->model->frames[load->frame];
    km_pose X = km_pose_product(&f->pose[frame->body], &frame->pose);
    double factor = load_factor(m, s, load->scale);
    km_vec3 force = km_vec3_scale(factor, km_vec3_from_array(load->force));
    km_vec3 torque = km_vec3_scale(factor, km_vec3_from_array(load->torque));
    if (load->turning) {
      force = km_rotate(&X.R, force);
      torque = km_rotate(&X.R, torque);
    }
    km_forces_add(f, frame->body, force, torque, X.p);
    power += km_wrench_power(km_wrench_at(force, torque, X.p), f->twist[frame->body]);
  }
  return power;
}

/* Sums weights, loads, springs, contacts, stops and additional joint forces at the state's configuration at rest. */
void km_forces_compute(const km_mechanism *m, const km_state *s, km_forces *f) {
  if (!f || f->mechanism != m || !km_state_belongs_to(m, s))
    return;
  f->origin = km_poses_about_mechanism(m, s, f->pose);
  memset(f->body, 0, (size_t)m->topology.body_count * sizeof *f->body);
  memset(f->twist, 0, (size_t)m->topology.body_count * sizeof *f->twist);
  memset(f->joint, 0, (size_t)m->coordinate_count * sizeof *f->joint);
  f->force_size = f->couple_size = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (f->extra[c] != 0.0)
      km_forces_add_joint(m->model, f, c, f->extra[c]);
  add_weights(m, f);
  km_loads_add(m, s, f);
  km_springs_add(m, s, f);
  km_contacts_add(m, f, true);
  km_stops_add(m, s, false, f);
}

void km_forces_on_body(const km_forces *f, int body, double wrench[6]) {
  if (!wrench)
    return;
  for (int i = 0; i < 6; ++i)
    wrench[i] = nan("");
  if (!f || body < 0 || body >= f->mechanism->topology.body_count)
    return;
  km_wrench w = km_wrench_about(f->body[body], km_vec3_scale(-1.0, f->origin));
  const double values[6] = {w.f.x, w.f.y, w.f.z, w.t.x, w.t.y, w.t.z};
  memcpy(wrench, values, sizeof values);
}

double km_forces_in_joint(const km_forces *f, int coordinate) {
  if (!f || coordinate < 0 || coordinate >= f->mechanism->coordinate_count)
    return nan("");
  return f->joint[coordinate];
}

void km_torque_unit(const km_model *model, km_text *out) {
  km_text_format(out, "%s*%s", model->units.force->suffix, model->units.length->suffix);
}

void km_force_unit(const km_model *model, int coordinate, km_text *out) {
  if (km_model_coordinate_is_length(model, coordinate))
    km_text_add(out, model->units.force->suffix);
  else
    km_torque_unit(model, out);
}
