/* Mechanical advantage over a sweep: its toggles are roots of the input's and the output's rate. */
#include "base/arguments.h"
#include "base/table.h"
#include "base/text.h"
#include "kmech/transfer.h"
#include "sweep/event_search.h"
#include "sweep/sweep_observer.h"
#include "transfer/transfer.h"
#include "transfer/transmission_metrics.h"

#include <string.h>

static const double rounding = 1e-12; /* of a rate: rates below this fraction count as zero */
static const double together = 1e-8;  /* a zero of both rates: neither 0 nor infinite */

typedef struct watch {
  km_advantage_sweep *out;
  km_observer observer;
  km_transfer *lever;
  km_transmission_workspace *transmission; /* NULL: not asked for */
  km_losses_workspace *losses;             /* NULL: no joint has friction */
  bool followed;                           /* r->rates is the motion at the pose that is looked at */
  bool between;                            /* that pose lies between rows */
  bool failed;                             /* the losses of the last row found no memory */
  double *reference;        /* [coordinate] the motion at the last sample: a basis has no sense of its own */
  double sense;             /* of the lever's motion at the pose that was looked at last, beside the sweep's: ±1 */
  km_advantage_state state; /* at the row that was written last */
  km_event_search scan;
  km_events events;
  km_advantage_state last_state; /* of the row before */
} watch;

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  const watch *w = self;
  km_text name = {0};
  const char *unit = km_advantage_unit(r->m->model, &w->out->input, &w->out->output);
  km_text_format(&name, "%s/%s", w->out->input.name, w->out->output.name);
  w->out->column = km_table_columns(table);
  bool added = !name.failed && km_table_join_column(table, "ma.", name.data, "", unit[0] ? unit : NULL);
  if (w->losses)
    added = added && km_table_join_column(table, "force_ratio.", name.data, "", unit[0] ? unit : NULL);
  km_text_free(&name);
  for (int i = 0; i < KM_METRIC_COLUMNS && w->transmission; ++i) {
    unit = km_transmission_unit(r->m->model, &w->out->output, i);
    added = added && km_table_join_column(table, km_transmission_name(i), "", "", unit[0] ? unit : NULL);
  }
  return added;
}

/* In a lane there is one freedom, whose unit direction is known. */
static void look_in_lane(const watch *w, const km_sweeper *r, km_advantage *out) {
  const km_mechanism *m = r->m;
  memset(r->scratch, 0, (size_t)m->coordinate_count * sizeof *r->scratch);
  r->mover.direction(r->mover.self, r->scratch);
  for (int c = 0; c < m->coordinate_count; ++c)
    r->scratch[c] /= m->scale[c];
  km_transfer_along(m, r->s, w->lever, r->scratch, out);
}

/* At a branch point there are more freedoms for an instant: the motion that is followed counts, r->rates. */
static void look(const watch *w, const km_sweeper *r, km_advantage *out) {
  if (r->rides) {
    look_in_lane(w, r, out);
    return;
  }
  const km_substructure *sub = r->substructure >= 0 ? &r->m->substructures[r->substructure] : NULL;
  bool meeting = sub && km_partition_freedom(&r->s->partition[r->substructure]) > r->out->freedom &&
                 w->lever->moves[r->m->column_coordinate[sub->column_start]];
  if (meeting && w->followed)
    km_transfer_along(r->m, r->s, w->lever, r->rates, out);
  else
    km_transfer_compute(r->m, r->s, w->lever, out);
}

static double *write_value(void *self, km_sweeper *r, double *cell) {
  watch *w = self;
  km_advantage a;
  w->followed = w->between || r->rides || km_sweeper_motion(r);
  look(w, r, &a);
  if (!w->between)
    w->state = a.state;
  if (km_table_rows(w->out->motion.table) == 1)
    w->out->method = a.method;
  *cell++ = a.value;
  if (w->losses) {
    km_losses losses;
    w->failed = km_losses_compute(r->m, r->s, w->losses, &losses) == KM_MEMORY;
    *cell++ = losses.ratio;
  }
  if (w->transmission) {
    km_transmission t;
    km_transmission_compute(r->m, r->s, w->transmission, &t);
    km_transmission_values(&t, cell);
    if (!w->between)
      w->out->last = t;
    cell += KM_METRIC_COLUMNS;
  }
  return cell;
}

/* -1 if the lever's motion runs against that of the sweep, or with several freedoms against that of the last sample. */
static double sense_of(const watch *w, const km_sweeper *r) {
  if (r->rides) /* the direction in which the driver moves forwards */
    return 1.0;
  double along = 0.0;
  const double *way = w->followed && r->out->freedom == 1 ? r->rates : w->reference;
  for (int c = 0; c < r->m->coordinate_count; ++c)
    along += w->lever->rates[c] * way[c] / (r->m->unit[c] * r->m->unit[c]);
  return along < 0.0 ? -1.0 : 1.0;
}

/* Both rates, in one sense along the sweep. */
static void values(void *self, km_sweeper *r, double *n, double *d) {
  watch *w = self;
  km_advantage a;
  look(w, r, &a);
  w->sense = sense_of(w, r);
  const km_transfer_end *ends[2] = {&w->lever->input, &w->lever->output};
  double *const out[2] = {n, d};
  for (int i = 0; i < 2; ++i)
    *out[i] = fabs(ends[i]->rate) > rounding * ends[i]->size ? w->sense * ends[i]->rate : 0.0;
}

static void sampled(void *self, km_sweeper *r) {
  const watch *w = self;
  for (int c = 0; c < r->m->coordinate_count; ++c)
    w->reference[c] = w->sense * w->lever->rates[c];
}

/* The leverage beside a pole, for pictures. */
static bool between(void *self, km_sweeper *r, double s) {
  watch *w = self;
  w->between = true;
  bool written = km_sweeper_between(r, s);
  w->between = false;
  return written;
}

static bool is_toggle(const km_event *e) {
  return e->kind == KM_EVENT_ZERO || e->kind == KM_EVENT_POLE || e->kind == KM_EVENT_UNDEFINED;
}

static km_status add_toggle(watch *w, km_advantage_state state, double s, km_error *error) {
  km_event_kind kind = state == KM_ADVANTAGE_ZERO ? KM_EVENT_ZERO : KM_EVENT_POLE;
  return km_events_add(&w->events, (km_event){kind, 0, s, 0.0}, error);
}

/* A row at the dead centre of its own driver: the rate that vanishes there comes no nearer to 0 than the driver's
 * digits allow, and the search between rows has nothing to find. */
static km_status note_dead_centre(watch *w, double s, km_error *error) {
  bool toggle = w->state == KM_ADVANTAGE_ZERO || w->state == KM_ADVANTAGE_INFINITE, known = w->state == w->last_state;
  for (size_t i = 0; i < w->events.count; ++i)
    known = known || (is_toggle(&w->events.items[i]) && fabs(w->events.items[i].s - s) <= 1e-6 * (1.0 + fabs(s)));
  w->last_state = w->state;
  return toggle && !known ? add_toggle(w, w->state, s, error) : KM_OK;
}

static km_status pass(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  w->followed = r->rides || km_sweeper_motion(r);
  return km_event_search_sample(&w->scan, r, s, error);
}

static km_status see(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  km_status status = w->failed ? km_fail(error, KM_MEMORY, "out of memory for the losses") : pass(self, r, s, error);
  return status || !w->scan.events ? status : note_dead_centre(w, s, error);
}

static void forget(void *self) {
  ((watch *)self)->scan.have = 0;
}

static km_status end_at(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  return km_event_at_end(&w->scan, r, s, error);
}

/* Zeros and poles as toggles: two in one place leave the advantage undefined there. */
static km_status take_toggles(watch *w, km_error *error) {
  km_advantage_sweep *out = w->out;
  out->toggles = KM_NEW(km_advantage_toggle, w->events.count);
  if (!out->toggles)
    return km_fail(error, KM_MEMORY, "out of memory for the dead points");
  for (size_t i = 0; i < w->events.count; ++i) {
    const km_event *e = &w->events.items[i];
    km_advantage_toggle *before = out->toggle_count ? &out->toggles[out->toggle_count - 1] : NULL;
    km_advantage_state state = e->kind == KM_EVENT_ZERO   ? KM_ADVANTAGE_ZERO
                               : e->kind == KM_EVENT_POLE ? KM_ADVANTAGE_INFINITE
                                                          : KM_ADVANTAGE_UNDEFINED;
    if (!is_toggle(e))
      continue;
    if (!before || fabs(before->s - e->s) > together * (1.0 + fabs(e->s)))
      out->toggles[out->toggle_count++] = (km_advantage_toggle){state, e->s};
    else if (before->state != state)
      before->state = KM_ADVANTAGE_UNDEFINED;
  }
  return KM_OK;
}

static void widen(km_advantage_sweep *out, double value, double s) {
  if (!isfinite(value))
    return;
  if (!(out->lowest.value <= value))
    out->lowest = (km_peak){value, s};
  if (!(out->highest.value >= value))
    out->highest = (km_peak){value, s};
  if (!(fabs(out->least.value) <= fabs(value)))
    out->least = (km_peak){value, s};
}

/* Beside a pose of infinite advantage it has no bound: which way, the nearest rows tell. */
static void open_bounds(km_advantage_sweep *out, double s) {
  const km_table *const tables[2] = {out->motion.table, out->motion.between};
  for (int side = -1; side <= 1; side += 2) {
    const double *nearest = NULL;
    for (int i = 0; i < 2; ++i)
      for (size_t r = 0; r < km_table_rows(tables[i]); ++r) {
        const double *row = km_table_row(tables[i], r);
        bool there = (row[1] - s) * side > 0.0 && isfinite(row[out->column]);
        if (there && (!nearest || fabs(row[1] - s) < fabs(nearest[1] - s)))
          nearest = row;
      }
    if (nearest && nearest[out->column] > 0.0)
      out->highest = (km_peak){HUGE_VAL, s};
    if (nearest && nearest[out->column] < 0.0)
      out->lowest = (km_peak){-HUGE_VAL, s};
  }
}

static void take_extremes(watch *w) {
  const km_table *table = w->out->motion.table;
  for (size_t r = 0; r < km_table_rows(table); ++r)
    widen(w->out, km_table_row(table, r)[w->out->column], km_table_row(table, r)[1]);
  for (size_t i = 0; i < w->events.count; ++i)
    if (!is_toggle(&w->events.items[i]))
      widen(w->out, w->events.items[i].value, w->events.items[i].s);
  for (size_t i = 0; i < w->out->toggle_count; ++i)
    if (w->out->toggles[i].state == KM_ADVANTAGE_INFINITE)
      open_bounds(w->out, w->out->toggles[i].s);
    else if (w->out->toggles[i].state == KM_ADVANTAGE_ZERO)
      widen(w->out, 0.0, w->out->toggles[i].s);
}

static km_status check_job(const km_sweep_job *job, const km_port *input, const km_port *output) {
  km_status status = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (!status)
    status = km_check_ports(job->m, input, output, job->error);
  if (!status)
    status = km_check_given(input->name && output->name, "name of input or output", job->error);
  return status;
}

/* Does the lever belong to what moves by the plan's driver, and to nothing else? Then the direction of motion tells all. */
static bool moves_with_driver(const km_mechanism *m, const km_sweep_plan *plan, const km_transfer *lever) {
  if (!km_plan_is_driven(plan))
    return false;
  int moving = m->substructure_of[plan->coordinate];
  for (int c = 0; c < m->coordinate_count && moving >= 0; ++c)
    if (lever->moves[c] && m->substructure_of[c] != moving)
      return false;
  return moving >= 0;
}

static km_status open_instruments(watch *w, const km_sweep_job *job, bool transmission) {
  const km_mechanism *m = job->m;
  const km_port *input = &w->out->input, *output = &w->out->output;
  km_status status = km_transfer_create(m, input, output, &w->lever, job->error);
  if (!status && transmission)
    status = km_transmission_create(m, input, output, &w->transmission, job->error);
  w->out->friction = km_model_has_friction(m->model);
  if (!status && w->out->friction)
    status = km_losses_create(m, input, output, &w->losses, job->error);
  return status;
}

static km_status tell(void *self, const km_sweep_job *job) {
  watch *w = self;
  if (job->table_only)
    return job->status;
  km_events_sort(&w->events, job->plan);
  km_status taken = take_toggles(w, job->error);
  take_extremes(w);
  return taken ? taken : job->status;
}

static void close_watch(void *self) {
  watch *w = self;
  km_losses_free(w->losses);
  km_transmission_free(w->transmission);
  km_transfer_free(w->lever);
  km_event_search_free(&w->scan);
  km_free(w->reference);
  km_free(w->events.items);
  km_free(w);
}

static km_observer observer_of(watch *w) {
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_value,
                       .seen = see,
                       .passed = pass,
                       .corner = forget,
                       .ended = end_at,
                       .tell = tell,
                       .close = close_watch,
                       .reads_basis = true,
                       .asks_direction = true};
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

static km_status open_watch(km_sweep_job *job, bool transmission, km_advantage_sweep *out) {
  watch *w = KM_NEW(watch, 1);
  if (!w)
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  w->out = out;
  w->observer = observer_of(w);
  w->scan = scan_of(w, job->table_only);
  job->observer = &w->observer;
  km_status status = open_instruments(w, job, transmission);
  if (status)
    return status;
  w->observer.reads_jacobian = w->transmission || w->losses || !moves_with_driver(job->m, job->plan, w->lever);
  w->reference = KM_NEW(double, (size_t)job->m->coordinate_count);
  if (!w->reference || !km_event_search_reserve(&w->scan, 1))
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  return KM_OK;
}

void km_advantage_sweep_open(km_sweep_job *job, const km_port *input, const km_port *output, bool transmission,
                             km_advantage_sweep *out) {
  const km_peak none = {nan(""), nan("")};
  *out = (km_advantage_sweep){.motion = {.substructure = -1}, .lowest = none, .highest = none, .least = none};
  job->out = &out->motion;
  job->status = check_job(job, input, output);
  if (job->status)
    return;
  out->input = *input;
  out->output = *output;
  job->status = open_watch(job, transmission, out);
}

km_status km_advantage_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, const km_port *input,
                                 const km_port *output, bool transmission, km_advantage_sweep *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  km_sweep_job job = {.m = m, .s = s, .plan = plan, .error = error};
  km_advantage_sweep_open(&job, input, output, transmission, out);
  km_sweeps_run(&job, 1);
  return job.status;
}

void km_advantage_sweep_free(km_advantage_sweep *sweep) {
  if (!sweep)
    return;
  km_sweep_free(&sweep->motion);
  km_free(sweep->toggles);
  *sweep = (km_advantage_sweep){0};
}
