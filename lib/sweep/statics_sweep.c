/* Static balance along a sweep (theory 9.6): actuator force = n/d.
 *
 *   zero of n: the load balances itself;   zero of d: dead point, unbounded force;   extrema between rows: peaks */
#include "base/arguments.h"
#include "base/table.h"
#include "base/text.h"
#include "statics/statics.h"
#include "sweep/events/event_search.h"
#include "sweep/sweep_observer.h"

#include <string.h>

typedef struct sweep_events {
  km_statics_sweep *out;
  km_observer observer;
  km_forces *forces;
  km_statics *statics;
  km_event_search search;
  km_events events;
  bool has_rates;       /* r->rates is the motion */
  bool gained_freedoms; /* the actuators hold more freedoms than before */
  bool is_valid; /* the balance belongs to the state's configuration, with this version of the moving partition */
  unsigned version;
} sweep_events;

static bool add_forces(const sweep_events *w, const km_model *model, km_table *table) {
  bool added = true;
  km_text unit = {0};
  for (int i = 0; i < w->statics->actuator_count && added; ++i) {
    const km_port *actuator = &w->statics->actuators[i];
    unit.size = 0;
    km_push_unit(model, actuator, &unit);
    added = !unit.failed && km_table_add_joined_column(table, "f.", actuator->name, "", unit.data);
  }
  for (int c = 0; c < model->coordinate_count && added; ++c) {
    unit.size = 0;
    km_force_unit(model, c, &unit);
    added = !unit.failed && km_table_add_joined_column(table, "fbar.", model->coordinates[c].label, "", unit.data);
  }
  km_text_free(&unit);
  return added;
}

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  static const char *const parts[6] = {".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};
  const sweep_events *w = self;
  const km_model *model = r->m->model;
  km_text torque = {0};
  km_torque_unit(model, &torque);
  bool added = !torque.failed && add_forces(w, model, table);
  for (int j = 0; j < model->joint_count; ++j)
    for (int k = 0; k < 6; ++k)
      added = added && km_table_add_joined_column(table, "r.", model->joints[j].label, parts[k],
                                                  k < 3 ? model->units.force->suffix : torque.data);
  km_text_free(&torque);
  return added && km_table_add_joined_column(table, "held", "", "", NULL);
}

static unsigned moving_version(const km_sweeper *r) {
  return r->substructure >= 0 ? km_factor_get_evidence(r->s->factor[r->substructure]).version : 0;
}

static double *write_cells(void *self, km_sweeper *r, double *cell) {
  sweep_events *w = self;
  const km_statics *st = w->statics;
  km_statics_find(r->m, r->s, w->forces, w->statics);
  w->is_valid = true;
  w->version = moving_version(r);
  if (km_table_rows(w->out->motion.table) == 1)
    w->out->degree = st->degree;
  for (int i = 0; i < st->actuator_count; ++i)
    *cell++ = st->actuator_forces[i];
  for (int c = 0; c < r->m->coordinate_count; ++c)
    *cell++ = st->least_norm[c];
  for (int j = 0; j < r->m->topology.joint_count; ++j) {
    memcpy(cell, st->reactions[j].force, sizeof st->reactions[j].force);
    memcpy(cell + 3, st->reactions[j].torque, sizeof st->reactions[j].torque);
    cell += 6;
  }
  *cell++ = st->held ? 1.0 : 0.0;
  return cell;
}

/* Returns an actuator's force, 0 if it is rounding. */
static double force_above_rounding(const sweep_events *w, const km_mechanism *m, int actuator) {
  const km_port *port = &w->statics->actuators[actuator];
  double unit = port->kind == KM_PORT_JOINT ? m->unit[port->coordinate] : m->length;
  double size = km_load_rounding * (w->forces->force_size * unit + w->forces->couple_size) / unit;
  double force = w->statics->actuator_forces[actuator];
  return fabs(force) <= size ? 0.0 : force;
}

static void compute_values(void *self, km_sweeper *r, double *n, double *d) {
  sweep_events *w = self;
  km_sweeper_update_motions(r);
  if (km_sweeper_has_more_freedoms(r)) { /* no actuator holds them */
    for (int i = 0; i < w->search.count; ++i)
      n[i] = nan("");
    return;
  }
  if (!w->is_valid || w->version != moving_version(r)) {
    km_forces_compute(r->m, r->s, w->forces);
    km_statics_actuators_compute(r->m, r->s, w->forces, w->statics);
  }
  w->is_valid = false;
  bool clears = !w->search.is_probing; /* a root would be a stretch */
  w->gained_freedoms =
      !km_statics_ratios(r->m, w->statics, w->has_rates ? r->rates : NULL, clears, n, d) || w->gained_freedoms;
}

static void set_reference(void *self, km_sweeper *r) {
  const sweep_events *w = self;
  km_statics_set_reference(r->m, w->statics);
}

/* Adds a pole at the first configuration, where the actuators held one freedom less than elsewhere. */
static km_status add_start_pole(sweep_events *w, km_error *error) {
  double s = w->search.first.s[0];
  km_status status = KM_OK;
  for (int i = 0; i < w->search.count && !status; ++i)
    if (isnan(km_event_numerator(&w->search, i, 1)) && !isnan(km_event_numerator(&w->search, i, 0)))
      status = km_events_add(&w->events, (km_event){KM_EVENT_POLE, i, s, HUGE_VAL}, error);
  return status;
}

static km_status sample_forces(sweep_events *w, km_sweeper *r, double s, km_error *error) {
  if (w->statics->work->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the balance");
  if (km_sweeper_has_more_freedoms(r))
    return KM_OK;
  bool has_sample = km_event_search_has_sample(&w->search);
  w->gained_freedoms = false;
  w->has_rates = r->is_batched ? r->mover.rates(r->mover.self, r->rates) : km_sweeper_update_rates(r);
  km_status status = km_event_search_sample(&w->search, r, s, error);
  if (w->gained_freedoms && has_sample && !status)
    status = add_start_pole(w, error);
  if (w->gained_freedoms)
    km_event_search_restart_at_row(&w->search);
  return status;
}

static km_status handle_sample(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  w->is_valid = false;
  return sample_forces(w, r, s, error);
}

static km_status handle_row(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  if (!w->statics->held && w->out->unheld++ == 0)
    w->out->first_unheld = s;
  memcpy(w->out->gravity, &w->forces->stated_gravity, sizeof w->out->gravity);
  w->out->loaded = w->out->loaded || w->forces->force_size > 0.0 || w->forces->couple_size > 0.0;
  for (int i = 0; i < w->statics->actuator_count; ++i) {
    double f = force_above_rounding(w, r->m, i);
    const km_force_event *largest = &w->out->largest[i];
    if (!isnan(f) && (isnan(largest->s) || fabs(f) > fabs(largest->value)))
      w->out->largest[i] = (km_force_event){KM_FORCE_PEAK, i, s, f};
  }
  return sample_forces(w, r, s, error);
}

/* Writes a row near a pole, for pictures. */
static bool write_between(void *self, km_sweeper *r, double s) {
  sweep_events *w = self;
  bool written = km_sweeper_write_between(r, s);
  w->is_valid = false;
  return written;
}

static km_status handle_end(void *self, km_sweeper *r, double s, km_error *error) {
  return km_event_at_end(&((sweep_events *)self)->search, r, s, error);
}

static void handle_branch_switch(void *self) {
  km_event_search_restart(&((sweep_events *)self)->search);
}

/* Converts an event of the ratio n/d to one of the actuator's force; false if it is not reported. */
static bool convert_event(const km_statics_sweep *out, const km_event *e, km_force_event *event) {
  *event = (km_force_event){KM_FORCE_BALANCED, e->function, e->s, e->value};
  if (e->kind == KM_EVENT_ZERO)
    return out->largest[e->function].value != 0.0; /* an actuator without force has no such events */
  if (e->kind == KM_EVENT_UNDEFINED)
    return false; /* neither actuator nor load moves: the force is continuous */
  event->kind = e->kind == KM_EVENT_POLE ? KM_FORCE_UNBOUNDED : KM_FORCE_PEAK;
  bool is_peak = e->kind == KM_EVENT_MAXIMUM ? e->value > 0.0 : e->value < 0.0;
  return e->kind == KM_EVENT_POLE || is_peak;
}

/* True if a zero of the same actuator lies at a pole, or a pole at a zero: neither actuator nor load moves there, and
 * the force is continuous. */
static bool is_undefined(const km_events *events, const km_event *e) {
  const km_event_kind other = e->kind == KM_EVENT_POLE   ? KM_EVENT_ZERO
                              : e->kind == KM_EVENT_ZERO ? KM_EVENT_POLE
                                                         : KM_EVENT_UNDEFINED;
  for (size_t i = 0; i < events->count; ++i)
    if (events->items[i].kind == other && events->items[i].function == e->function &&
        fabs(events->items[i].s - e->s) <= km_same_position * (1.0 + fabs(e->s)))
      return true;
  return false;
}

static km_status collect_events(sweep_events *w, const km_sweep_plan *plan, km_error *error) {
  km_statics_sweep *out = w->out;
  km_events_sort(&w->events, plan);
  out->events = KM_NEW(km_force_event, w->events.count);
  if (!out->events)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  for (size_t i = 0; i < w->events.count; ++i) {
    km_force_event event;
    if (is_undefined(&w->events, &w->events.items[i]) || !convert_event(out, &w->events.items[i], &event))
      continue;
    out->events[out->event_count++] = event;
    km_force_event *largest = &out->largest[event.actuator];
    /* a row is preferred to a peak that equals it to rounding */
    if (event.kind != KM_FORCE_BALANCED && fabs(event.value) > (1.0 + km_load_rounding) * fabs(largest->value))
      *largest = event;
  }
  return KM_OK;
}

static km_status check_job(const km_sweep_job *job, const km_forces *forces, const km_statics *statics) {
  km_status status = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (!status)
    status = km_check_given(forces && forces->mechanism == job->m, "forces of this mechanism", job->error);
  if (!status)
    status = km_check_given(statics && statics->work && statics->work->mechanism == job->m, "balance of this mechanism",
                            job->error);
  return status;
}

static km_status finish(void *self, const km_sweep_job *job) {
  sweep_events *w = self;
  km_statics_mark(job->m, w->statics); /* marks of the last row */
  km_status taken = collect_events(w, job->plan, job->error);
  return taken ? taken : w->out->unheld ? KM_PARTIAL : job->status;
}

static void close_observer(void *self) {
  sweep_events *w = self;
  w->statics->work->keeps_factors = false;
  km_event_search_free(&w->search);
  km_free(w->events.items);
  km_free(w);
}

static km_observer observer_of(sweep_events *w) {
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_cells,
                       .row_written = handle_row,
                       .sampled_between = handle_sample,
                       .corner = handle_branch_switch,
                       .end_reached = handle_end,
                       .finish = finish,
                       .close = close_observer,
                       .reads_jacobian = !w->statics->work->no_reactions,
                       .reads_basis = true};
}

/* Copies the actuators and clears their largest forces. */
static bool copy_actuators(const sweep_events *w) {
  km_statics_sweep *out = w->out;
  const km_statics *st = w->statics;
  out->actuators = KM_NEW(km_port, (size_t)st->actuator_count);
  out->largest = KM_NEW(km_force_event, (size_t)st->actuator_count);
  if (!out->actuators || !out->largest)
    return false;
  for (int i = 0; i < st->actuator_count; ++i) {
    out->actuators[out->actuator_count++] = st->actuators[i];
    out->largest[i] = (km_force_event){KM_FORCE_PEAK, i, nan(""), 0.0};
  }
  return true;
}

static km_status open_observer(km_sweep_job *job, km_forces *forces, km_statics *statics, km_statics_sweep *out) {
  km_status status = check_job(job, forces, statics);
  if (status)
    return status;
  sweep_events *w = KM_NEW(sweep_events, 1);
  if (w) {
    *w = (sweep_events){.out = out, .forces = forces, .statics = statics};
    w->observer = observer_of(w);
    w->search = km_event_search_of_ratios(w, compute_values, job->table_only ? NULL : &w->events);
    w->search.sampled = set_reference;
    w->search.between = write_between;
    job->observer = &w->observer;
    statics->work->keeps_factors = true;
  }
  if (!w || !copy_actuators(w) || !km_event_search_reserve(&w->search, statics->actuator_count, job->plan))
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  return KM_OK;
}

void km_statics_sweep_open(km_sweep_job *job, km_forces *forces, km_statics *statics, km_statics_sweep *out) {
  *out = (km_statics_sweep){.motion = {.substructure = -1}, .first_unheld = nan("")};
  job->out = &out->motion;
  job->status = open_observer(job, forces, statics, out);
}

km_status km_statics_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_forces *forces,
                               km_statics *statics, km_statics_sweep *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  km_sweep_job job = {.m = m, .s = s, .plan = plan, .error = error};
  km_statics_sweep_open(&job, forces, statics, out);
  km_sweeps_run(&job, 1);
  return job.status;
}

void km_statics_sweep_free(km_statics_sweep *sweep) {
  if (!sweep)
    return;
  km_sweep_free(&sweep->motion);
  km_free(sweep->actuators);
  km_free(sweep->events);
  km_free(sweep->largest);
  *sweep = (km_statics_sweep){0};
}
