/* Steps of a run with inputs that a program sets between them (docs/theory.md 11.5). */
#include "history/dynamic_friction.h"

#include "base/arguments.h"
#include "forces/motion_forces.h"
#include "history/history_limits.h"
#include "kinematics/state.h"
#include "kmech/dynamics.h"

#include <math.h>

struct km_session {
  const km_mechanism *m;
  km_state *state;
  km_forces *forces;
  km_dynamics *dynamics;
  km_dynamic_friction *friction;
  km_simulation *run;
  km_limit_monitor limits;
  km_load *loads; /* [frame_count] wrenches on the frames, behind the loads of the model */
  int frame_count, first_load;
  double start, step; /* time of the first step; length of a step */
  long steps;         /* steps made, with the one that a crossing has stopped */
  bool fixed_steps;
  bool changed; /* inputs have changed since the last step */
};

km_session_def km_session_default(const km_model *model) {
  km_session_def def = {.simulation = km_history_default(model).simulation};
  def.simulation.integrator = KM_INTEGRATOR_FIXED;
  def.step = model ? 1e-3 / model->units.time->si : 1e-3;
  return def;
}

/* Creates the forces: loads of the model, then one load of 0 for each frame. */
static km_status create_forces(km_session *s, const int *frames, km_error *error) {
  const km_model *model = s->m->model;
  s->first_load = model->load_count;
  int count = s->first_load + s->frame_count;
  s->loads = KM_NEW(km_load, (size_t)count + 1);
  if (!s->loads)
    return km_fail(error, KM_MEMORY, "out of memory for the loads");
  for (int i = 0; i < count; ++i)
    s->loads[i] = i < s->first_load ? km_model_load_at(model, i) : (km_load){.frame = frames[i - s->first_load]};
  return km_forces_create(s->m, NULL, s->loads, count, &s->forces, error);
}

static km_status create_run(km_session *s, const km_session_def *def, km_error *error) {
  km_simulation_def simulation = def->simulation;
  if (s->fixed_steps)
    simulation.max_step = def->step;
  km_status status = create_forces(s, def->frames, error);
  if (!status && def->user)
    status = km_forces_set_user(s->forces, def->user, error);
  if (!status && (def->limit_stop[0] != 0.0 || def->limit_stop[1] != 0.0))
    status = km_forces_set_limit_stops(s->forces, def->limit_stop[0], def->limit_stop[1], error);
  if (!status)
    status = km_dynamics_create(s->m, s->forces, &s->dynamics, error);
  if (!status)
    status = km_limits_monitor_begin(&s->limits, s->m, s->forces, NULL, error);
  if (!status)
    status = km_dynamic_friction_create(s->dynamics, &s->friction, error);
  return status ? status : km_simulation_create(s->dynamics, s->state, &simulation, &s->run, error);
}

static km_status check_def(const km_mechanism *m, const km_session_def *def, km_error *error) {
  km_status status = km_check_list(def->frames, def->frame_count, "frames", error);
  for (int i = 0; i < def->frame_count && !status; ++i)
    status = km_check_index(def->frames[i], m->model->frame_count, "frame", error);
  if (!status && (!(def->step > 0.0) || !isfinite(def->step)))
    status = km_fail(error, KM_USAGE, "step %g; expected a positive time", def->step);
  return status;
}

km_status km_session_create(const km_mechanism *m, const km_state *state, const km_session_def *def, km_session **out,
                            km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(def != NULL, "definition", error);
  if (!status)
    status = km_check_state(m, state, error);
  if (!status)
    status = check_def(m, def, error);
  if (status)
    return status;
  km_session *s = KM_NEW(km_session, 1);
  if (!s)
    return km_fail(error, KM_MEMORY, "out of memory for the session");
  *s = (km_session){.m = m,
                    .frame_count = def->frame_count,
                    .start = state->time,
                    .step = def->step,
                    .fixed_steps = def->simulation.integrator == KM_INTEGRATOR_FIXED};
  status = km_state_create(m, &s->state, error);
  if (!status) {
    km_state_copy(m, s->state, state);
    status = create_run(s, def, error);
  }
  if (status)
    km_session_free(s);
  else
    *out = s;
  return status;
}

void km_session_free(km_session *s) {
  if (!s)
    return;
  km_simulation_free(s->run);
  km_dynamic_friction_free(s->friction);
  km_dynamics_free(s->dynamics);
  km_limits_monitor_free(&s->limits);
  km_forces_free(s->forces);
  km_state_free(s->state);
  km_free(s->loads);
  km_free(s);
}

/* Notes a changed input. */
static km_status change(km_session *s, km_status status) {
  s->changed = s->changed || !status;
  return status;
}

km_status km_session_set_force(km_session *s, int coordinate, double force, km_error *error) {
  km_status status = km_check_given(s != NULL, "session", error);
  return status ? status : change(s, km_forces_set_joint_force(s->forces, coordinate, force, error));
}

km_status km_session_set_wrench(km_session *s, int index, const double wrench[6], km_error *error) {
  km_status status = km_check_given(s != NULL && wrench != NULL, "session or wrench", error);
  if (!status)
    status = km_check_index(index, s->frame_count, "frame", error);
  if (status)
    return status;
  km_load load = s->loads[s->first_load + index];
  for (int k = 0; k < 3; ++k) {
    load.force[k] = wrench[k];
    load.torque[k] = wrench[3 + k];
  }
  return change(s, km_forces_set_load(s->forces, s->first_load + index, &load, error));
}

km_status km_session_set_reference(km_session *s, int module, double value, km_error *error) {
  km_status status = km_check_given(s != NULL, "session", error);
  return status ? status : change(s, km_forces_set_reference(s->forces, module, value, error));
}

km_status km_session_set_rate(km_session *s, int coordinate, double rate, km_error *error) {
  km_status status = km_check_given(s != NULL, "session", error);
  if (!status)
    status = km_state_set_rate(s->m, s->state, coordinate, rate, error);
  return status ? status : km_simulation_restart(s->run, error);
}

/* Makes a step, or its rest after a crossing. Changed inputs restart a run whose last step ends elsewhere or whose
 * method uses earlier steps. */
static km_status make_step(km_session *s, km_error *error) {
  bool is_complete = s->state->time >= s->start + (double)s->steps * s->step;
  km_status status = KM_OK;
  s->steps += is_complete;
  if (s->changed && !(s->fixed_steps && is_complete))
    status = km_simulation_restart(s->run, error);
  s->changed = false;
  double to = s->start + (double)s->steps * s->step;
  if (!status)
    status = km_simulation_advance(s->run, to, NULL, NULL, error);
  if (!status || status == KM_PARTIAL)
    km_limits_row(&s->limits, s->state);
  return status;
}

km_status km_session_step(km_session *s, int count, km_error *error) {
  km_status status = km_check_given(s != NULL, "session", error);
  if (!status && count < 0)
    status = km_fail(error, KM_USAGE, "%d steps; expected at least 0", count);
  for (int i = 0; i < count && !status; ++i)
    status = make_step(s, error);
  return status;
}

const km_state *km_session_state(const km_session *s) {
  return s ? s->state : NULL;
}

double km_session_time(const km_session *s) {
  return s ? s->state->time : nan("");
}

const km_simulation *km_session_run(const km_session *s) {
  return s ? s->run : NULL;
}

int km_session_limit_count(const km_session *s) {
  return s ? km_limits_passed_count(&s->limits) : 0;
}

km_passed_limit km_session_limit(const km_session *s, int index) {
  if (index < 0 || index >= km_session_limit_count(s))
    return (km_passed_limit){.coordinate = -1, .limit = nan(""), .time = nan(""), .beyond = nan("")};
  return *km_limits_passed(&s->limits, index);
}

km_frame_motion km_session_frame(const km_session *s, int index) {
  if (!s || index < 0 || index >= s->frame_count)
    return (km_frame_motion){.origin = {nan("")}};
  return km_frame_motion_of(s->forces, s->loads[s->first_load + index].frame);
}
