/* Table of a motion over time: columns, rows, energies, shaking force, reactions. */
#include "history/history_table.h"

#include "base/arguments.h"
#include "base/table.h"
#include "base/text.h"
#include "kinematics/loop_equations.h"
#include "statics/statics.h"

#include <string.h>

/* Adds a column with the name prefix + name + suffix, such as "frame." "crank/tip" ".x". */
static void add_column(km_table *table, bool *failed, const char *unit, const char *prefix, const char *name,
                       const char *suffix) {
  *failed = !km_table_add_joined_column(table, prefix, name, suffix, unit) || *failed;
}

/* Unit of a rate or acceleration of a coordinate; valid while `text` is. */
static const char *rate_unit(const km_model *model, int coordinate, const char *suffix, km_text *text) {
  text->size = 0;
  km_text_format(text, "%s/%s%s", km_model_coordinate_unit(model, coordinate), model->units.time->suffix, suffix);
  return text->failed ? "" : text->data;
}

/* Columns of coordinates, rates, accelerations and driving forces. */
static void coordinate_columns(const km_history_writer *w, km_table *table, bool *failed) {
  const km_model *model = w->m->model;
  km_text unit = {0};
  for (int c = 0; c < model->coordinate_count; ++c)
    add_column(table, failed, km_model_coordinate_unit(model, c), "q.", model->coordinates[c].label, "");
  for (int c = 0; c < model->coordinate_count; ++c)
    add_column(table, failed, rate_unit(model, c, "", &unit), "v.", model->coordinates[c].label, "");
  for (int c = 0; c < model->coordinate_count; ++c)
    add_column(table, failed, rate_unit(model, c, "^2", &unit), "a.", model->coordinates[c].label, "");
  for (int c = 0; c < model->coordinate_count; ++c) {
    if (!w->dynamics->driven[c])
      continue;
    unit.size = 0;
    km_force_unit(model, c, &unit);
    add_column(table, failed, unit.failed ? "" : unit.data, "f.", model->coordinates[c].label, "");
  }
  *failed = *failed || unit.failed;
  km_text_free(&unit);
}

/* Columns of energies, loop error and counts. */
static void figure_columns(const km_history_writer *w, km_table *table, bool *failed) {
  static const char *const energies[] = {"energy_kinetic", "energy_potential", "energy_dissipated", "motor_work"};
  km_text unit = {0};
  km_torque_unit(w->m->model, &unit);
  for (int i = 0; i < (w->simulation ? 4 : 2); ++i)
    add_column(table, failed, unit.failed ? "" : unit.data, energies[i], "", "");
  *failed = *failed || unit.failed;
  km_text_free(&unit);
  add_column(table, failed, NULL, "loop_error", "", "");
  if (!w->simulation)
    return;
  add_column(table, failed, NULL, "evaluations", "", "");
  add_column(table, failed, NULL, "repartitions", "", "");
  add_column(table, failed, w->m->model->units.time->suffix, "integrator_step", "", "");
  add_column(table, failed, NULL, "integrator_order", "", "");
  km_history_internal_columns(w, table, failed);
}

/* Columns of the shaking force and moment. */
static void shaking_columns(const km_history_writer *w, km_table *table, bool *failed) {
  static const char *const parts[6] = {"fx", "fy", "fz", "tx", "ty", "tz"};
  const km_model *model = w->m->model;
  km_text torque = {0};
  km_torque_unit(model, &torque);
  for (int k = 0; k < 6; ++k)
    add_column(table, failed,
               k < 3           ? model->units.force->suffix
               : torque.failed ? ""
                               : torque.data,
               "shaking.", parts[k], "");
  *failed = *failed || torque.failed;
  km_text_free(&torque);
}

/* Columns of position, velocity and acceleration of the tabulated frames, and of their rotation. */
static void frame_columns(const km_history_writer *w, km_table *table, bool *failed) {
  static const char *const parts[5][3] = {{".x", ".y", ".z"},
                                          {".vx", ".vy", ".vz"},
                                          {".ax", ".ay", ".az"},
                                          {".wx", ".wy", ".wz"},
                                          {".alphax", ".alphay", ".alphaz"}};
  static const int orders[5] = {0, 1, 2, 1, 2};
  const km_units *units = &w->m->model->units;
  int groups = w->frame_rotations ? 5 : 3;
  for (int i = 0; i < 3 * groups * w->frame_count; ++i) {
    int group = i / 3 % groups, order = orders[group];
    km_text unit = {0};
    km_text_format(&unit, "%s%s%s%s", group < 3 ? units->length->suffix : "rad", order ? "/" : "",
                   order ? units->time->suffix : "", order == 2 ? "^2" : "");
    add_column(table, failed, unit.failed ? "" : unit.data, "frame.", w->frames[i / (3 * groups)].name,
               parts[group][i % 3]);
    *failed = *failed || unit.failed;
    km_text_free(&unit);
  }
}

/* Columns of the reactions of all joints. */
static void reaction_columns(const km_history_writer *w, km_table *table, bool *failed) {
  static const char *const parts[6] = {".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};
  const km_model *model = w->m->model;
  km_text torque = {0};
  km_torque_unit(model, &torque);
  for (int j = 0; j < model->joint_count; ++j)
    for (int k = 0; k < 6; ++k)
      add_column(table, failed,
                 k < 3           ? model->units.force->suffix
                 : torque.failed ? ""
                                 : torque.data,
                 "r.", model->joints[j].label, parts[k]);
  *failed = *failed || torque.failed;
  km_text_free(&torque);
}

/* Creates the table with all its columns. */
static km_status create_table(km_history_writer *w, km_error *error) {
  const km_model *model = w->m->model;
  bool failed = false;
  km_table *table = w->out->table = km_table_create();
  if (!table)
    return km_fail(error, KM_MEMORY, "out of memory for the table");
  add_column(table, &failed, model->units.time->suffix, "t", "", "");
  coordinate_columns(w, table, &failed);
  figure_columns(w, table, &failed);
  if (w->shaking)
    shaking_columns(w, table, &failed);
  frame_columns(w, table, &failed);
  km_history_module_columns(w, table, &failed);
  if (w->reactions)
    reaction_columns(w, table, &failed);
  for (int c = 0; w->mobility && c < model->coordinate_count; ++c)
    add_column(table, &failed, NULL, "m.", model->coordinates[c].label, "");
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the table") : KM_OK;
}

/* Cells of coordinates and rates. */
static double *write_rates(const km_history_writer *w, double *out) {
  const km_mechanism *m = w->m;
  km_state *s = w->state;
  for (int b = 0; b < m->ball_count; ++b) { /* the rotation vector closest to that of the last row */
    double *q = &s->q[m->ball_coordinate[b]];
    km_vec3 v = km_quaternion_log_near(s->ball[b], km_vec3_from_array(q));
    km_vec3_write(v, q);
  }
  for (int c = 0; c < m->coordinate_count; ++c)
    *out++ = km_state_coordinate(s, c);
  for (int c = 0; c < m->coordinate_count; ++c)
    *out++ = km_state_rate(s, c);
  return out;
}

/* Cells of coordinates, rates, accelerations and driving forces. */
static double *write_coordinates(const km_history_writer *w, double *out) {
  const km_mechanism *m = w->m;
  km_state *s = w->state;
  out = write_rates(w, out);
  for (int c = 0; c < m->coordinate_count; ++c)
    *out++ = km_state_acceleration(s, c);
  for (int c = 0; c < m->coordinate_count; ++c)
    if (w->dynamics->driven[c])
      *out++ = km_dynamics_driving_force(w->dynamics, s, c);
  return out;
}

static double loop_error(const km_history_writer *w) {
  double worst = 0.0;
  for (int i = 0; i < w->m->topology.substructure_count; ++i)
    worst = fmax(worst, km_loops_residual(w->m, w->state, &w->m->substructures[i]));
  return worst;
}

/* Cells of energies, loop error and counts; updates the largest errors. */
static double *write_figures(km_history_writer *w, double *out) {
  km_history *h = w->out;
  km_energy energy;
  km_dynamics_energy(w->dynamics, w->state, &energy, NULL);
  double potential = energy.potential - w->potential;
  *out++ = energy.kinetic;
  *out++ = potential;
  h->energy_scale = fmax(h->energy_scale, energy.kinetic);
  if (w->simulation) {
    h->figures = km_simulation_figures_of(w->simulation);
    double balance = energy.kinetic + potential + h->figures.dissipated - h->figures.motor_work;
    h->energy_error = fmax(h->energy_error, fabs(balance - w->balance));
    *out++ = h->figures.dissipated;
    *out++ = h->figures.motor_work;
  }
  *out = loop_error(w);
  h->worst_loop = fmax(h->worst_loop, *out++);
  if (w->simulation) {
    *out++ = (double)h->figures.evaluations;
    *out++ = (double)h->figures.repartitions;
    *out++ = h->figures.last_step;
    *out++ = (double)h->figures.order;
    out = km_history_write_internal(w, out);
  }
  return out;
}

/* Shaking force and moment: minus the sum of the rates of all momenta, about the inertial origin. */
static double *write_shaking(const km_history_writer *w, double *out) {
  km_wrench sum =
      km_wrench_about(km_dynamics_inertia_forces(w->dynamics), km_vec3_scale(-1.0, w->dynamics->forces->origin));
  const double values[6] = {sum.f.x, sum.f.y, sum.f.z, sum.t.x, sum.t.y, sum.t.z};
  memcpy(out, values, sizeof values);
  return out + 6;
}

/* Position, velocity and acceleration of a frame's origin, with the gravity term removed; and its angular velocity and
 * acceleration, with which all but the position are along the frame's axes. */
static double *write_frame(const km_history_writer *w, int frame, double *out) {
  const km_dynamics *d = w->dynamics;
  const km_model_frame *def = &w->m->model->frames[frame];
  int n = d->tree.node_of_body[def->body];
  const km_node_motion *node = &d->node[n];
  km_pose body = km_pose_product(&node->pose, &d->tree.body_in_node[def->body]);
  km_pose X = km_pose_product(&body, &def->pose);
  km_twist A = {km_vec3_add(node->A.v, d->forces->stated_gravity), node->A.w};
  const km_vec3 all[5] = {km_vec3_add(X.p, d->forces->origin), km_point_velocity(node->V, X.p),
                          km_point_acceleration(node->V, A, X.p), node->V.w, node->A.w};
  for (int i = 0; i < (w->frame_rotations ? 5 : 3); ++i) {
    km_vec3 part = w->frame_rotations && i > 0 ? km_rotate_back(&X.R, all[i]) : all[i];
    *out++ = part.x;
    *out++ = part.y;
    *out++ = part.z;
  }
  return out;
}

/* Cells of the reactions, by a static balance with inertia forces. */
static km_status write_reactions(km_history_writer *w, double **cells, km_error *error) {
  double *out = *cells;
  km_dynamics_balance(w->dynamics, w->state);
  if (km_statics_balance(w->m, w->probe, w->forces, &w->statics))
    return km_fail(error, KM_MEMORY, "out of memory for the reactions");
  for (int j = 0; j < w->m->model->joint_count; ++j) {
    memcpy(out, w->statics.reactions[j].force, 3 * sizeof *out);
    memcpy(out + 3, w->statics.reactions[j].torque, 3 * sizeof *out);
    out += 6;
  }
  *cells = out;
  return KM_OK;
}

/* Force of the drive of a coordinate: driving force of a prescribed motion plus motors and controllers. */
static double drive_force(const km_history_writer *w, int c) {
  const km_dynamics *d = w->dynamics;
  double settings = d->forces->moving->drive_force[c];
  return d->driven[c] ? settings + km_dynamics_driving_force(d, w->state, c) : settings;
}

/* Updates the largest forces and rates of the drives. */
static void monitor_drives(km_history_writer *w) {
  for (int i = 0; i < w->monitored_count; ++i) {
    km_exceeded *e = &w->monitored[i];
    double now = e->of_force ? drive_force(w, e->coordinate) : km_state_rate(w->state, e->coordinate);
    if (!(fabs(now) > fabs(e->most)))
      continue;
    e->most = now;
    e->time = w->state->time;
  }
}

/* Lists the drives that have a bound of force or rate. */
static bool list_monitored(km_history_writer *w) {
  const km_mechanism *m = w->m;
  w->monitored = KM_NEW(km_exceeded, 2 * (size_t)m->coordinate_count + 1);
  for (int c = 0; w->monitored && c < m->coordinate_count; ++c) {
    if (isfinite(m->max_force[c]))
      w->monitored[w->monitored_count++] = (km_exceeded){.coordinate = c, .of_force = true, .bound = m->max_force[c]};
    if (isfinite(m->max_rate[c]))
      w->monitored[w->monitored_count++] =
          (km_exceeded){.coordinate = c, .bound = m->max_rate[c] / km_model_coordinate_factor(m->model, c)};
  }
  return w->monitored != NULL;
}

/* Moves the drives that exceeded their bounds to the result. */
static void move_exceeded(km_history_writer *w) {
  km_history *h = w->out;
  h->exceeded = w->monitored;
  for (int i = 0; i < w->monitored_count; ++i)
    if (fabs(w->monitored[i].most) > w->monitored[i].bound * (1.0 + 1e-9))
      h->exceeded[h->exceeded_count++] = w->monitored[i];
}

km_status km_history_monitor_limits(km_history_writer *w, km_simulation_def *simulation, km_error *error) {
  km_status status = km_limits_monitor_begin(&w->limits, w->m, w->forces, simulation, error);
  if (!status && simulation) {
    simulation->crossings = w->limits.crossings;
    simulation->crossing_count = w->limits.crossing_count;
  }
  return status;
}

/* Cells of coordinates and rates; NaN in all that follow. */
static void write_kinematics(km_history_writer *w, double *out, const double *end) {
  w->out->figures = km_simulation_figures_of(w->simulation);
  w->out->energy_error = w->out->worst_loop = nan("");
  km_limits_row(&w->limits, w->state);
  for (out = write_rates(w, out); out < end; ++out)
    *out = nan("");
}

/* Writes one row at the present state. */
km_status km_history_row(km_history_writer *w, km_error *error) {
  double *out = km_table_add_row(w->out->table);
  if (!out)
    return km_fail(error, KM_MEMORY, "out of memory for the table");
  const double *end = out + km_table_columns(w->out->table);
  *out++ = w->state->time;
  if (w->kinematics_only) {
    write_kinematics(w, out, end);
    return KM_OK;
  }
  monitor_drives(w);
  km_limits_row(&w->limits, w->state);
  out = write_coordinates(w, out);
  out = write_figures(w, out);
  if (w->shaking)
    out = write_shaking(w, out);
  for (int i = 0; i < w->frame_count; ++i)
    out = write_frame(w, w->frames[i].frame, out);
  out = km_history_write_modules(w, out);
  if (!w->probe)
    return KM_OK;
  km_mobility mobility;
  km_state_copy(w->m, w->probe, w->state);
  km_status status = km_mobility_compute(w->m, w->probe, &mobility)
                         ? km_fail(error, KM_MEMORY, "out of memory for the mobility")
                         : KM_OK;
  if (!status && w->reactions)
    status = write_reactions(w, &out, error);
  for (int c = 0; w->mobility && c < w->m->coordinate_count && !status; ++c)
    *out++ = km_mobility_number(w->probe, c);
  if (status)
    km_table_drop_row(w->out->table);
  return status;
}

/* Creates the static balance; prescribed joints are its actuators. */
static km_status create_statics(km_history_writer *w, km_error *error) {
  int *driven = KM_NEW(int, (size_t)w->m->coordinate_count + 1), count = 0;
  if (!driven)
    return km_fail(error, KM_MEMORY, "out of memory for the reactions");
  for (int c = 0; c < w->m->coordinate_count; ++c)
    if (w->dynamics->driven[c])
      driven[count++] = c;
  km_status status = km_statics_create(w->m, driven, count, w->axes, &w->statics, error);
  km_free(driven);
  return status;
}

km_status km_history_begin(km_history_writer *w, km_error *error) {
  km_energy energy;
  km_status status = KM_OK;
  if (w->reactions || w->mobility)
    status = km_state_create(w->m, &w->probe, error);
  if (!status && w->reactions)
    status = create_statics(w, error);
  if (!status && !list_monitored(w))
    status = km_fail(error, KM_MEMORY, "out of memory for what drives give");
  if (!status)
    status = create_table(w, error);
  if (status)
    return status;
  km_dynamics_energy(w->dynamics, w->state, &energy, NULL);
  const km_run_memory *memory = w->memory ? w->memory : &(const km_run_memory){0};
  w->potential = energy.potential - memory->potential;
  w->balance = energy.kinetic + memory->potential + memory->dissipated - memory->motor_work;
  w->out->energy_start = energy.kinetic;
  w->out->effort = km_dynamics_effort(w->dynamics, w->state);
  return KM_OK;
}

km_status km_history_check(const km_mechanism *m, const km_forces *forces, const km_state *state, const void *def,
                           km_history *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_history){0};
  km_status status = km_check_given(def != NULL && forces != NULL, "definition or forces", error);
  return status ? status : km_check_state(m, state, error);
}

km_status km_history_end(km_history_writer *w, km_status status, const km_error *why, km_error *error) {
  if (status && why) {
    w->out->why = *why;
    km_fail(error, status, "%s", why->text);
  }
  move_exceeded(w);
  km_limits_report(&w->limits, w->out);
  km_statics_free(&w->statics);
  km_state_free(w->probe);
  km_simulation_free(w->simulation);
  km_dynamic_friction_free(w->friction);
  km_dynamics_free(w->dynamics);
  return status;
}

km_status km_history_check_frames(const km_mechanism *m, const km_traced_frame *frames, int count, km_error *error) {
  km_status status = km_check_list(frames, count, "frames", error);
  for (int i = 0; i < count && !status; ++i) {
    status = km_check_index(frames[i].frame, m->model->frame_count, "frame", error);
    if (!status)
      status = km_check_given(frames[i].name != NULL, "name of a frame", error);
  }
  return status;
}
