/* Static balance over a sweep: where actuators rest, peak, or can't hold. */
#include "base/arguments.h"
#include "base/table.h"
#include "base/text.h"
#include "statics/statics.h"
#include "sweep/event_search.h"
#include "sweep/sweep_observer.h"

#include <string.h>

static const double rounding = 1e-11; /* of all applied forces: an actuator's force below this is 0 */

typedef struct watch {
  km_statics_sweep *out;
  km_observer observer;
  km_forces *forces;
  km_statics *statics;
  km_event_search scan;
  km_events events;
  bool moves; /* r->rates is the motion */
  bool grown; /* the actuators reach more freedoms than before */
  bool known; /* the balance is that of the state's pose, by this edition of the partition that moves: */
  unsigned edition;
} watch;

static bool add_forces(const watch *w, const km_model *model, km_table *table) {
  bool added = true;
  km_text unit = {0};
  for (int i = 0; i < w->statics->actuator_count && added; ++i) {
    const km_port *actuator = &w->statics->actuators[i];
    unit.size = 0;
    km_push_unit(model, actuator, &unit);
    added = !unit.failed && km_table_join_column(table, "f.", actuator->name, "", unit.data);
  }
  for (int c = 0; c < model->coordinate_count && added; ++c) {
    unit.size = 0;
    km_force_unit(model, c, &unit);
    added = !unit.failed && km_table_join_column(table, "fbar.", model->coordinates[c].label, "", unit.data);
  }
  km_text_free(&unit);
  return added;
}

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  static const char *const parts[6] = {".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};
  const watch *w = self;
  const km_model *model = r->m->model;
  km_text torque = {0};
  km_torque_unit(model, &torque);
  bool added = !torque.failed && add_forces(w, model, table);
  for (int j = 0; j < model->joint_count; ++j)
    for (int k = 0; k < 6; ++k)
      added = added && km_table_join_column(table, "r.", model->joints[j].label, parts[k],
                                            k < 3 ? model->units.force->suffix : torque.data);
  km_text_free(&torque);
  return added && km_table_join_column(table, "held", "", "", NULL);
}

static unsigned edition_of(const km_sweeper *r) {
  return r->substructure >= 0 ? r->s->partition[r->substructure].version : 0;
}

static double *write_cells(void *self, km_sweeper *r, double *cell) {
  watch *w = self;
  const km_statics *st = w->statics;
  km_statics_find(r->m, r->s, w->forces, w->statics);
  w->known = true;
  w->edition = edition_of(r);
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

/* Force of an actuator, 0 where rounding is all there is. */
static double clear_force(const watch *w, const km_mechanism *m, int actuator) {
  const km_port *handle = &w->statics->actuators[actuator];
  double unit = handle->kind == KM_PORT_JOINT ? m->unit[handle->coordinate] : m->length;
  double size = rounding * (w->forces->force_size * unit + w->forces->couple_size) / unit;
  double force = w->statics->actuator_forces[actuator];
  return fabs(force) <= size ? 0.0 : force;
}

/* True where the configuration has freedoms for an instant that the motion hasn't: no actuator need hold them. */
static bool has_more_freedoms(const km_sweeper *r) {
  return r->substructure >= 0 && km_partition_freedom(&r->s->partition[r->substructure]) > r->out->freedom;
}

static void values(void *self, km_sweeper *r, double *n, double *d) {
  watch *w = self;
  if (has_more_freedoms(r)) {
    for (int i = 0; i < w->scan.count; ++i)
      n[i] = nan("");
    return;
  }
  if (!w->known || w->edition != edition_of(r)) {
    km_forces_compute(r->m, r->s, w->forces);
    km_statics_hold(r->m, r->s, w->forces, w->statics);
  }
  w->known = false;
  w->grown = !km_statics_ratios(r->m, w->statics, w->moves ? r->rates : NULL, n, d) || w->grown;
}

static void sampled(void *self, km_sweeper *r) {
  const watch *w = self;
  km_statics_refer(r->m, w->statics);
}

/* The first pose was one where the actuators had a freedom less within their reach than elsewhere. */
static km_status start_at_pole(watch *w, km_error *error) {
  double s = w->scan.first.s[0];
  km_status status = KM_OK;
  for (int i = 0; i < w->scan.count && !status; ++i)
    if (isnan(w->scan.n[1][i]) && !isnan(w->scan.n[0][i]))
      status = km_events_add(&w->events, (km_event){KM_EVENT_POLE, i, s, HUGE_VAL}, error);
  return status;
}

static km_status look(watch *w, km_sweeper *r, double s, km_error *error) {
  if (w->statics->work->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the balance");
  if (has_more_freedoms(r))
    return KM_OK;
  bool second = w->scan.have > 0;
  w->grown = false;
  w->moves = r->rides ? r->mover.rates(r->mover.self, r->rates) : km_sweeper_motion(r);
  km_status status = km_event_search_sample(&w->scan, r, s, error);
  if (w->grown && second && !status)
    status = start_at_pole(w, error);
  if (w->grown)
    w->scan.have = 1;
  return status;
}

static km_status pass(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  w->known = false;
  return look(w, r, s, error);
}

static km_status see(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  if (!w->statics->held && w->out->unheld++ == 0)
    w->out->first_unheld = s;
  memcpy(w->out->gravity, &w->forces->stated_gravity, sizeof w->out->gravity);
  w->out->loaded = w->out->loaded || w->forces->force_size > 0.0 || w->forces->couple_size > 0.0;
  for (int i = 0; i < w->statics->actuator_count; ++i) {
    double f = clear_force(w, r->m, i);
    const km_force_event *largest = &w->out->largest[i];
    if (!isnan(f) && (isnan(largest->s) || fabs(f) > fabs(largest->value)))
      w->out->largest[i] = (km_force_event){KM_FORCE_PEAK, i, s, f};
  }
  return look(w, r, s, error);
}

/* The forces beside a pole, for pictures. */
static bool between(void *self, km_sweeper *r, double s) {
  watch *w = self;
  bool written = km_sweeper_between(r, s);
  w->known = false;
  return written;
}

static km_status end_at(void *self, km_sweeper *r, double s, km_error *error) {
  return km_event_at_end(&((watch *)self)->scan, r, s, error);
}

static void forget(void *self) {
  ((watch *)self)->scan.have = 0;
}

static bool keep(const km_statics_sweep *out, const km_event *e, km_force_event *event) {
  *event = (km_force_event){KM_FORCE_BALANCED, e->function, e->s, e->value};
  if (e->kind == KM_EVENT_ZERO)
    return out->largest[e->function].value != 0.0; /* not of one that never holds anything */
  if (e->kind == KM_EVENT_UNDEFINED)
    return false; /* neither the actuator nor what it holds moves: its force goes on as it was */
  event->kind = e->kind == KM_EVENT_POLE ? KM_FORCE_UNBOUNDED : KM_FORCE_PEAK;
  bool outwards = e->kind == KM_EVENT_MAXIMUM ? e->value > 0.0 : e->value < 0.0;
  return e->kind == KM_EVENT_POLE || outwards;
}

static km_status take_events(watch *w, const km_sweep_plan *plan, km_error *error) {
  km_statics_sweep *out = w->out;
  km_events_sort(&w->events, plan);
  out->events = KM_NEW(km_force_event, w->events.count);
  if (!out->events)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  for (size_t i = 0; i < w->events.count; ++i) {
    km_force_event event;
    if (!keep(out, &w->events.items[i], &event))
      continue;
    out->events[out->event_count++] = event;
    km_force_event *largest = &out->largest[event.actuator];
    /* A row is told before a peak that is it but for rounding. */
    if (event.kind != KM_FORCE_BALANCED && fabs(event.value) > (1.0 + rounding) * fabs(largest->value))
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

static km_status tell(void *self, const km_sweep_job *job) {
  watch *w = self;
  km_statics_mark(job->m, w->statics); /* those of the last row */
  km_status taken = take_events(w, job->plan, job->error);
  return taken ? taken : w->out->unheld ? KM_PARTIAL : job->status;
}

static void close_watch(void *self) {
  watch *w = self;
  w->statics->work->compares = false;
  km_event_search_free(&w->scan);
  km_free(w->events.items);
  km_free(w);
}

static km_observer observer_of(watch *w) {
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_cells,
                       .seen = see,
                       .passed = pass,
                       .corner = forget,
                       .ended = end_at,
                       .tell = tell,
                       .close = close_watch,
                       .reads_jacobian = !w->statics->work->no_reactions,
                       .reads_basis = true};
}

static km_event_search scan_of(watch *w, bool table_only) {
  return (km_event_search){.self = w,
                           .values = values,
                           .sampled = sampled,
                           .between = between,
                           .ratios = true,
                           .extremes = true,
                           .events = table_only ? NULL : &w->events};
}

/* The actuators, and what each of them has to give: nothing yet. */
static bool take_actuators(const watch *w) {
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

static km_status open_watch(km_sweep_job *job, km_forces *forces, km_statics *statics, km_statics_sweep *out) {
  km_status status = check_job(job, forces, statics);
  if (status)
    return status;
  watch *w = KM_NEW(watch, 1);
  if (w) {
    *w = (watch){.out = out, .forces = forces, .statics = statics};
    w->observer = observer_of(w);
    w->scan = scan_of(w, job->table_only);
    job->observer = &w->observer;
    statics->work->compares = true;
  }
  if (!w || !take_actuators(w) || !km_event_search_reserve(&w->scan, statics->actuator_count))
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  return KM_OK;
}

void km_statics_sweep_open(km_sweep_job *job, km_forces *forces, km_statics *statics, km_statics_sweep *out) {
  *out = (km_statics_sweep){.motion = {.substructure = -1}, .first_unheld = nan("")};
  job->out = &out->motion;
  job->status = open_watch(job, forces, statics, out);
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
