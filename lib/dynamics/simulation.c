/* Simulation runs: workspace, advance to a time, crossings on the way (docs/theory.md 11.5 and 11.6). */
#include "dynamics/simulation.h"

#include "base/arguments.h"

#include <string.h>

/* Errors of steps accumulate: a step may have this part of the stated error. */
static const double error_share = 0.05;
/* Least relative error of a step: 45 units of rounding. Below it, rounding errors would control the steps. */
static const double least_step_error = 1e-14;

km_simulation_def km_simulation_default(void) {
  return (km_simulation_def){.relative = 1e-7, .absolute = 1e-7, .end = HUGE_VAL};
}

/* Checks tolerances, steps, method and crossings of a run. */
static km_status check_def(const km_mechanism *m, const km_simulation_def *def, double time, km_error *error) {
  if (!(def->relative >= 0.0) || !(def->absolute > 0.0) || !(def->relative < 1.0) || !isfinite(def->absolute))
    return km_fail(error, KM_USAGE, "tolerances %g and %g; expected a relative one below 1 and a positive absolute one",
                   def->relative, def->absolute);
  if (!(def->max_step >= 0.0) || !isfinite(def->max_step))
    return km_fail(error, KM_USAGE, "longest step %g; expected 0 or a positive number", def->max_step);
  if (def->integrator == KM_INTEGRATOR_FIXED && !(def->max_step > 0.0))
    return km_fail(error, KM_USAGE, "no step is given; expected one for steps of fixed length");
  if ((unsigned)def->integrator > KM_INTEGRATOR_FIXED || (unsigned)def->stabilisation > KM_STABILISE_BAUMGARTE)
    return km_fail(error, KM_USAGE, "integrator %d, stabilisation %d; expected one that exists", (int)def->integrator,
                   (int)def->stabilisation);
  if (!(def->end >= time))
    return km_fail(error, KM_USAGE, "end %g; expected a time from %g on", def->end, time);
  km_status status = km_check_list(def->crossings, def->crossing_count, "crossings", error);
  for (int i = 0; i < def->crossing_count && !status; ++i) {
    if (!def->crossings[i].function)
      status = km_check_index(def->crossings[i].coordinate, m->coordinate_count, "coordinate", error);
    if (!status && !def->crossings[i].function && m->ball_of[def->crossings[i].coordinate] >= 0)
      status = km_fail(error, KM_USAGE,
                       "crossing of \"%s\", a coordinate of a ball; expected a hinge's, a slide's or a screw's",
                       m->model->coordinates[def->crossings[i].coordinate].label);
    if (!status && !isfinite(def->crossings[i].value))
      status = km_fail(error, KM_USAGE, "crossing at %g; expected a finite value", def->crossings[i].value);
  }
  return status;
}

/* Assigns the indices in the vector and allocates the arrays. */
static bool allocate_arrays(km_simulation *run) {
  const km_mechanism *m = run->dynamics->mechanism;
  int next = 0;
  run->value_index = KM_ARENA_NEW(&run->arena, int, (size_t)m->coordinate_count);
  for (int c = 0; run->value_index && c < m->coordinate_count; ++c) {
    int ball = m->ball_of[c];
    run->value_index[c] = ball >= 0 && m->ball_coordinate[ball] != c ? -1 : next;
    next += ball < 0 ? 1 : m->ball_coordinate[ball] == c ? 4 : 0;
  }
  run->rate_start = next;
  run->memory_start = run->rate_start + m->coordinate_count;
  run->work_start = run->memory_start + run->dynamics->forces->moving->state_count;
  run->work_count = KM_WORKS + (run->def.module_works ? m->model->module_count : 0);
  run->size = (run->work_start + run->work_count + KM_VECTOR_LANES - 1) / KM_VECTOR_LANES * KM_VECTOR_LANES;
  size_t n = (size_t)run->size, crossings = (size_t)run->def.crossing_count;
  run->y = KM_ARENA_NEW(&run->arena, double, n);
  run->ydot = KM_ARENA_NEW(&run->arena, double, n);
  run->at = KM_ARENA_NEW(&run->arena, double, n);
  run->shift = KM_ARENA_NEW(&run->arena, double, n);
  run->shifted = KM_ARENA_NEW(&run->arena, double, n);
  run->closed = KM_ARENA_NEW(&run->arena, double, n);
  run->before = KM_ARENA_NEW(&run->arena, double, n);
  run->slope = KM_ARENA_NEW(&run->arena, double, n);
  run->accepted = KM_ARENA_NEW(&run->arena, double, n);
  run->accepted_shift = KM_ARENA_NEW(&run->arena, double, n);
  run->tolerance = KM_ARENA_NEW(&run->arena, double, n);
  run->stage = KM_ARENA_NEW(&run->arena, double, (KM_STAGES + 2) * n);
  run->kept_stages = KM_ARENA_NEW(&run->arena, double, KM_STAGES *n);
  run->crossings = KM_ARENA_NEW(&run->arena, km_crossing, crossings);
  run->side = KM_ARENA_NEW(&run->arena, double, crossings);
  bool listed = km_corners_list(run->dynamics, &run->arena, &run->corners);
  bool adams = run->def.integrator == KM_INTEGRATOR_ADAMS;
  return listed && km_method_choice_create(&run->choice, adams ? KM_ADAMS : KM_BDF, !adams, run->size, &run->arena);
}

/* Sets the absolute tolerances: radians and characteristic lengths, rates per second; works by work_error.c. */
static void set_tolerances(km_simulation *run) {
  const km_mechanism *m = run->dynamics->mechanism;
  double absolute = run->def.absolute, second = m->model->units.time->si;
  for (int i = 0; i < run->size; ++i)
    run->tolerance[i] = absolute;
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (run->value_index[c] >= 0)
      run->tolerance[run->value_index[c]] = absolute / m->scale[c];
    run->tolerance[run->rate_start + c] = absolute / m->scale[c] * second;
  }
  for (int i = run->work_start; i < run->size; ++i)
    run->tolerance[i] = HUGE_VAL;
}

/* Initialises internal states and works: 0, or those of the run that this one continues. */
static void begin_memory(km_simulation *run) {
  const km_moving_forces *moving = run->dynamics->forces->moving;
  const km_run_memory *memory = run->def.memory;
  size_t states = (size_t)moving->state_count * sizeof(double);
  memset(moving->internal_state, 0, states);
  if (!memory)
    return;
  memcpy(moving->internal_state, memory->internal, states);
  memcpy(run->at + run->memory_start, memory->internal, states);
  run->at[run->work_start] = memory->dissipated;
  run->at[run->work_start + 1] = memory->motor_work;
  memcpy(run->at + run->work_start + KM_WORKS, memory->module_works,
         (size_t)(run->work_count - KM_WORKS) * sizeof(double));
}

/* Starts the vector from the state, with the internal states and works of `at`, by projected rates. */
static km_status start_from_state(km_simulation *run, km_error *error) {
  km_state *s = run->state;
  km_dynamics *d = run->dynamics;
  run->time = run->last_time = s->time;
  d->omega = 0.0;
  km_status status = km_dynamics_project_rates(d, s, NULL, error);
  if (!status)
    status = km_dynamics_accelerate(d, s, error);
  if (status)
    return status;
  memcpy(run->y, run->at, (size_t)run->size * sizeof *run->y);
  memset(run->shift, 0, (size_t)run->size * sizeof *run->shift);
  km_simulation_pack(run, run->y);
  memcpy(run->at, run->y, (size_t)run->size * sizeof *run->y);
  km_crossings_begin(run);
  return KM_OK;
}

/* Initialises vector, crossings, works and integrator at the start of a run. */
static km_status begin(km_simulation *run, km_error *error) {
  km_dynamics *d = run->dynamics;
  const km_simulation_def *def = &run->def;
  for (int i = 0; i < def->crossing_count; ++i) {
    run->crossings[i] = def->crossings[i];
    if (!def->crossings[i].function)
      run->crossings[i].value *= km_model_coordinate_factor(d->mechanism->model, def->crossings[i].coordinate);
  }
  run->origin = run->state->time;
  d->uses_baumgarte = def->stabilisation == KM_STABILISE_BAUMGARTE;
  d->closing_tolerance = fmin(fmax(1e-2 * def->relative, 1e-13), 1e-7);
  begin_memory(run);
  km_status status = start_from_state(run, error);
  if (status)
    return status;
  km_dynamics_reset_repartitions(d);
  km_simulation_begin_works(run);
  return def->integrator == KM_INTEGRATOR_FIXED ? KM_OK : km_cvode_create(run, error);
}

km_status km_simulation_create(km_dynamics *d, km_state *s, const km_simulation_def *def, km_simulation **out,
                               km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(d != NULL && def != NULL, "equations of motion or definition", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (!status)
    status = check_def(d->mechanism, def, s->time, error);
  if (status)
    return status;
  km_simulation *run = KM_NEW(km_simulation, 1);
  if (!run)
    return km_fail(error, KM_MEMORY, "out of memory for the run");
  *run = (km_simulation){.dynamics = d, .state = s, .def = *def, .stop = HUGE_VAL, .due_time = HUGE_VAL};
  run->def.relative = fmax(error_share * def->relative, least_step_error);
  run->def.absolute *= error_share;
  status = allocate_arrays(run) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the run");
  if (!status) {
    set_tolerances(run);
    status = begin(run, error);
  }
  if (status)
    km_simulation_free(run);
  else
    *out = run;
  return status;
}

void km_simulation_free(km_simulation *run) {
  if (!run)
    return;
  run->dynamics->uses_baumgarte = false;
  run->dynamics->closing_tolerance = 1e-13;
  km_cvode_free(run->cvode);
  km_free(run->crossings_met);
  km_arena_free(&run->arena);
  km_free(run);
}

bool km_simulation_interpolate(const km_simulation *run, double time, double *y) {
  if (!(run->time > run->last_time))
    memcpy(y, run->y, (size_t)run->size * sizeof *y);
  else if (run->step_method == KM_STEP_CVODE)
    return km_cvode_interpolate(run, time, y);
  else if (run->step_method == KM_STEP_COLLOCATION)
    km_collocation_interpolate(run, time, y);
  else
    km_fixed_interpolate(run, time, y);
  return true;
}

/* Returns to the start of the last step; the following steps end at `time`, where the step passed over a corner. */
static bool restore_step(km_simulation *run, double time) {
  memcpy(run->y, run->accepted, (size_t)run->size * sizeof *run->y);
  memcpy(run->shift, run->accepted_shift, (size_t)run->size * sizeof *run->shift);
  run->time = run->last_time;
  run->typical_step = run->typical_step_before;
  run->due_time = time;
  run->rejected_over++;
  return km_cvode_restart(run);
}

/* One step; repeated if it passed over a corner. */
static km_status make_step(km_simulation *run, km_error *error) {
  run->last_time = run->time;
  run->typical_step_before = run->typical_step;
  memcpy(run->accepted, run->y, (size_t)run->size * sizeof *run->y);
  memcpy(run->accepted_shift, run->shift, (size_t)run->size * sizeof *run->shift);
  if (!run->cvode)
    return km_fixed_step(run, error);
  km_status status = km_cvode_step(run, error);
  double missed = status ? HUGE_VAL : fmin(km_simulation_passed_over(run), km_contacts_passed_over(run));
  if (missed == HUGE_VAL)
    return status;
  return restore_step(run, missed) ? km_cvode_step(run, error)
                                   : km_fail(error, KM_MEMORY, "out of memory for the integrator");
}

static km_status step(km_simulation *run, km_error *error) {
  km_status status = make_step(run, error);
  if (status)
    return status;
  if (run->cvode && run->dynamics->stale && !km_simulation_accept(run, run->y, run->time, false))
    return km_dynamics_fail(run->dynamics, run->outcome, error);
  return km_crossings_find(run) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the crossings");
}

void km_simulation_skip_accelerations(km_simulation *run, bool skips) {
  const km_dynamics *d = run->dynamics;
  run->skips_accelerations =
      skips && d->forces->moving->implicit_count == 0 && !d->update_friction && !d->forces->user.compute;
}

/* Sets the state to a time within the last step. */
static km_status set_state_at(km_simulation *run, double time, km_error *error) {
  if (!km_simulation_interpolate(run, time, run->at))
    return km_fail(error, KM_INTERNAL, "time %g isn't within the last step", time);
  bool tight = !run->dynamics->uses_baumgarte;
  double closing_tolerance = run->dynamics->closing_tolerance;
  run->dynamics->closing_tolerance = tight ? 1e-13 : closing_tolerance;
  bool is_ok = run->skips_accelerations ? km_simulation_close(run, time, run->at)
                                        : km_simulation_derivative(run, time, run->at, run->ydot);
  run->dynamics->closing_tolerance = closing_tolerance;
  run->evaluations -= !run->skips_accelerations;
  if (is_ok && km_simulation_noise(run, run->typical_step) > 1.0) { /* the vector's rates are more accurate than the
                                                             * projected ones */
    memcpy(run->state->rate, run->shifted + run->rate_start,
           (size_t)run->dynamics->mechanism->coordinate_count * sizeof(double));
    km_tree_update(run->dynamics, run->state);
  }
  return is_ok ? KM_OK : km_dynamics_fail(run->dynamics, run->outcome, error);
}

/* Sets the state to a time, or to the crossing before it that stops the run. */
static km_status stop_at(km_simulation *run, double time, km_error *error) {
  bool stops = run->stop <= time; /* otherwise it lies later in the last step */
  km_status status = set_state_at(run, stops ? run->stop : time, error);
  run->halted = stops;
  return !status && stops ? KM_PARTIAL : status;
}

/* Sets the state to the start of a step that failed. */
static void return_to_accepted(km_simulation *run) {
  memcpy(run->y, run->accepted, (size_t)run->size * sizeof *run->y);
  km_simulation_derivative(run, run->last_time, run->y, run->ydot);
  memcpy(run->at, run->y, (size_t)run->size * sizeof *run->y);
}

/* Reports the crossings beyond the one that halted the run: the last step continues there. */
static void resume(km_simulation *run) {
  if (run->halted)
    km_crossings_report(run);
  run->halted = false;
}

km_status km_simulation_step(km_simulation *run, km_error *error) {
  km_status status = km_check_given(run != NULL, "run", error);
  if (status)
    return status;
  if (!(run->time < run->def.end))
    return km_fail(error, KM_USAGE, "the run has reached its end at time %g", run->def.end);
  resume(run);
  if (run->stop == HUGE_VAL)
    status = step(run, error);
  if (!status)
    return stop_at(run, run->time, error);
  return_to_accepted(run);
  return status;
}

km_status km_simulation_restart(km_simulation *run, km_error *error) {
  km_status status = km_check_given(run != NULL, "run", error);
  if (status)
    return status;
  while (run->reported > 0 && run->crossings_met[run->reported - 1].time > run->state->time)
    run->reported--;
  run->crossings_met_count = run->reported;
  run->stop = run->due_time = HUGE_VAL;
  run->halted = false;
  status = start_from_state(run, error);
  if (status || !run->cvode)
    return status;
  return km_cvode_restart(run) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the integrator");
}

/* Makes steps until a time or a stopping crossing, then sets the state there by dense output. */
km_status km_simulation_advance(km_simulation *run, double time, km_progress progress, void *context, km_error *error) {
  km_status status = km_check_given(run != NULL, "run", error);
  if (status)
    return status;
  if (!isfinite(time) || !(time >= run->last_time) || !(time <= run->def.end))
    return km_fail(error, KM_USAGE, "time %g; expected one from %g to %g", time, run->last_time, run->def.end);
  double from = run->time;
  resume(run);
  while (run->time < time && run->time < run->stop && !status) {
    status = step(run, error);
    if (!status && progress && !progress(context, (run->time - from) / (time - from)))
      return km_fail(error, KM_CANCELLED, "cancelled at time %g", run->time);
  }
  if (!status)
    return stop_at(run, time, error);
  return_to_accepted(run);
  return status;
}

km_simulation_figures km_simulation_figures_of(const km_simulation *run) {
  if (!run)
    return (km_simulation_figures){.time = nan("")};
  return (km_simulation_figures){.time = run->state->time,
                                 .steps = run->steps,
                                 .evaluations = run->evaluations,
                                 .rejected = run->rejected + run->rejected_over,
                                 .repartitions = km_dynamics_repartitions(run->dynamics),
                                 .dissipated = run->at[run->work_start],
                                 .motor_work = run->at[run->work_start + 1],
                                 .rest_energy = km_simulation_rest_energy(run),
                                 .relative = run->def.relative / error_share,
                                 .stiff = run->choice.method == KM_BDF,
                                 .order = run->order,
                                 .last_step = run->time - run->last_time};
}

double km_simulation_module_work(const km_simulation *run, int module) {
  if (!run || module < 0 || module >= run->work_count - KM_WORKS)
    return nan("");
  return run->at[run->work_start + KM_WORKS + module];
}

int km_simulation_crossing_count(const km_simulation *run) {
  return run ? (int)run->reported : 0;
}

km_crossing_met km_simulation_crossing(const km_simulation *run, int index) {
  if (!run || index < 0 || (size_t)index >= run->reported)
    return (km_crossing_met){.crossing = -1, .time = nan("")};
  return run->crossings_met[index];
}
