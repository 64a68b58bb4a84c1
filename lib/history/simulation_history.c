/* Table of a simulation: start, rows at equal intervals, crossings, changed initial rates. */
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "history/history_table.h"
#include "history/motion_cycle.h"
#include "kmech/inspect.h"
#include "kmech/sweep.h"

#include <string.h>

static const double default_span = 10.0; /* default duration, seconds */

/* Words of integration_type in files: ksim's own, those of the thesis, and MATLAB's for the same methods. */
static const struct {
  const char *word;
  km_integrator integrator;
} methods[] = {{"adams", KM_INTEGRATOR_ADAMS},
               {"ode113", KM_INTEGRATOR_ADAMS},
               {"ode113b", KM_INTEGRATOR_ADAMS},
               {"bdf", KM_INTEGRATOR_BDF},
               {"ode15s", KM_INTEGRATOR_BDF}};

bool km_model_integrator(const km_model *model, km_integrator *out) {
  const char *stated = km_model_integration_type(model);
  for (size_t i = 0; stated && out && i < sizeof methods / sizeof *methods; ++i)
    if (strcmp(stated, methods[i].word) == 0) {
      *out = methods[i].integrator;
      return true;
    }
  return false;
}

/* One period of the loads over a coordinate that starts with a rate, else at least 10 s and one period of all. */
static double default_end(const km_model *model, const km_constant_rate *rates, int rate_count) {
  bool over_joint;
  const double period = km_longest_period(model, rates, rate_count, &over_joint);
  return over_joint ? period : fmax(period, default_span / model->units.time->si);
}

km_history_def km_history_default_at(const km_model *model, const km_constant_rate *rates, int rate_count) {
  km_history_def def = {.simulation = km_simulation_default()};
  if (!model)
    return def;
  const km_simulation_settings *settings = &model->simulation;
  def.until = settings->span > 0.0 ? settings->span : default_end(model, rates, rate_count);
  def.every = settings->step > 0.0 ? settings->step : def.until / KM_HISTORY_ROWS;
  km_model_integrator(model, &def.simulation.integrator);
  if (settings->relative > 0.0)
    def.simulation.relative = settings->relative;
  if (settings->absolute > 0.0)
    def.simulation.absolute = settings->absolute;
  return def;
}

km_history_def km_history_default(const km_model *model) {
  return km_history_default_at(model, NULL, 0);
}

/* Checks times and frames of a simulation. */
static km_status check_def(const km_mechanism *m, const km_history_def *def, km_error *error) {
  if (!isfinite(def->start) || !(def->until > def->start) || !isfinite(def->until))
    return km_fail(error, KM_USAGE, "end %g; expected a time after the start at %g", def->until, def->start);
  if (!(def->every > 0.0) || !isfinite(def->every))
    return km_fail(error, KM_USAGE, "%g between rows; expected a positive time", def->every);
  if ((def->until - def->start) / def->every > KM_MAX_SWEEP_STEPS)
    return km_fail(error, KM_USAGE, "%g between rows up to %g; expected at most %d rows", def->every, def->until,
                   KM_MAX_SWEEP_STEPS);
  double longest = def->simulation.max_step;
  if (longest > 0.0 && def->until + longest == def->until) /* rounding would leave the time unchanged */
    return km_fail(error, KM_USAGE, "longest step %g; expected one that a time of %g can grow by", longest, def->until);
  return km_history_check_frames(m, def->frames, def->frame_count, error);
}

/* Lists the stated rates that were changed by the projection on the loops; `stated` are the rates before it. */
static void list_changed_rates(const km_history_writer *w, const double *stated) {
  const km_mechanism *m = w->m;
  km_history *h = w->out;
  double largest = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c)
    largest = fmax(largest, m->scale[c] * fmax(fabs(stated[c]), fabs(w->state->rate[c])));
  for (int c = 0; c < m->coordinate_count; ++c) {
    km_rate_source source = w->state->rate_source[c];
    if (source == KM_RATE_FOLLOWS || w->dynamics->driven[c] ||
        !(m->scale[c] * fabs(w->state->rate[c] - stated[c]) > km_relative_zero * largest))
      continue;
    double factor = km_model_coordinate_factor(m->model, c);
    h->changed_rates[h->changed_rate_count++] =
        (km_changed_rate){c, stated[c] / factor, w->state->rate[c] / factor, source == KM_RATE_MODEL};
  }
}

/* Computes initial rates that satisfy the loops, closest to the stated ones. */
static km_status start_rates(km_history_writer *w, km_error *error) {
  size_t count = (size_t)w->m->coordinate_count;
  double *stated = KM_NEW(double, count + 1);
  w->out->changed_rates = KM_NEW(km_changed_rate, count + 1);
  km_status status = stated && w->out->changed_rates ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the rates");
  if (!status) {
    memcpy(stated, w->state->rate, count * sizeof *stated);
    status = km_dynamics_project_rates(w->dynamics, w->state, &w->out->rate_change, error);
  }
  if (!status)
    list_changed_rates(w, stated);
  km_free(stated);
  return status;
}

/* Creates equations of motion, friction, initial rates, limits and run, and writes the first row. */
static km_status start(km_history_writer *w, const km_history_def *def, km_error *error) {
  km_simulation_def simulation = def->simulation;
  simulation.end = def->until;
  simulation.module_works = def->module_count > 0;
  w->state->time = def->start;
  km_status status = km_dynamics_create(w->m, w->forces, &w->dynamics, error);
  if (!status)
    status = km_dynamic_friction_create(w->dynamics, &w->friction, error);
  if (!status)
    status = start_rates(w, error);
  if (!status)
    status = km_history_monitor_limits(w, &simulation, error);
  if (!status)
    status = km_simulation_create(w->dynamics, w->state, &simulation, &w->simulation, error);
  if (!status)
    status = km_history_begin(w, error);
  if (!status)
    km_simulation_skip_accelerations(w->simulation, w->kinematics_only);
  return status ? status : km_history_row(w, error);
}

/* Writes rows at multiples of `every` and at the end; the last row is where the run stopped. */
static km_status write_rows(km_history_writer *w, const km_history_def *def, km_error *error) {
  double until = def->until, every = def->every;
  km_status status = KM_OK;
  for (long row = 1; !status && w->state->time < until; ++row) {
    double time = def->start + (double)row * every;
    time = time > until - 1e-9 * every ? until : time;
    status = km_simulation_advance(w->simulation, time, NULL, NULL, error);
    if (status && status != KM_PARTIAL && status != KM_DIVERGED)
      return status;
    km_status written = km_history_row(w, status ? NULL : error);
    if (!status)
      status = written;
    if (!status && def->progress && !def->progress(def->context, (time - def->start) / (until - def->start)))
      return km_fail(error, KM_CANCELLED, "cancelled at time %g", time);
  }
  return status;
}

/* Copies the crossings of the caller to the result and those of limits to the monitor. */
static km_status copy_crossings(km_history_writer *w, km_status status, km_error *error) {
  km_history *h = w->out;
  int count = km_simulation_crossing_count(w->simulation);
  h->crossings = KM_NEW(km_crossing_met, (size_t)count + 1);
  if (!h->crossings)
    return km_fail(error, KM_MEMORY, "out of memory for the crossings");
  for (int i = 0; i < count; ++i) {
    km_crossing_met met = km_simulation_crossing(w->simulation, i);
    if (!km_limits_crossed(&w->limits, &met))
      h->crossings[h->crossing_count++] = met;
  }
  return status;
}

km_status km_history_run(const km_mechanism *m, km_forces *forces, km_state *state, const km_history_def *def,
                         km_history *out, km_error *error) {
  km_status status = km_history_check(m, forces, state, def, out, error);
  if (!status)
    status = check_def(m, def, error);
  if (status)
    return status;
  km_error own;
  km_history_writer w = {.m = m,
                         .frames = def->frames,
                         .frame_count = def->frame_count,
                         .frame_rotations = def->frame_rotations,
                         .modules = def->modules,
                         .module_count = def->module_count,
                         .reactions = def->reactions,
                         .mobility = def->mobility,
                         .kinematics_only = def->kinematics_only,
                         .axes = def->axes,
                         .memory = def->simulation.memory,
                         .forces = forces,
                         .state = state,
                         .out = out};
  status = start(&w, def, &own);
  if (!status)
    status = write_rows(&w, def, &own);
  if (w.simulation)
    status = copy_crossings(&w, status, &own);
  return km_history_end(&w, status, status == KM_PARTIAL ? NULL : &own, error);
}

void km_history_free(km_history *h) {
  if (!h)
    return;
  km_table_free(h->table);
  km_free(h->crossings);
  km_free(h->exceeded);
  km_free(h->limits);
  km_free(h->peaks);
  km_free(h->changed_rates);
  *h = (km_history){0};
}
