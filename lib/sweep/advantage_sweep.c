/* Mechanical advantage along a sweep (theory 8.1, 10.1): n = input's rate, d = output's rate, advantage = n/d.
 *
 *   zero of n: advantage 0;   zero of d: infinite;   both within 1e-8: undefined;   extrema of n/d between rows */
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "base/table.h"
#include "base/text.h"
#include "kmech/transfer.h"
#include "sweep/events/event_search.h"
#include "sweep/sweep_observer.h"
#include "sweep/transmission_columns.h"
#include "transfer/transfer.h"

#include <string.h>

typedef struct sweep_events {
  km_advantage_sweep *out;
  km_observer observer;
  km_transfer *transfer;
  bool has_transmission; /* its columns are requested: */
  km_transmission_columns transmission;
  km_losses_workspace *losses; /* NULL: no joint has friction */
  bool has_rates;              /* r->rates is the motion at the state's configuration */
  bool is_between_rows;        /* the configuration lies between rows */
  bool failed;                 /* no memory for the losses or hinges of the last row */
  /* [coordinate] motion at the last sample, to orient the next one: the sign of a basis vector is arbitrary */
  double *reference;
  /* orientation, ±1, of the transfer's motion relative to the sweep's at the last configuration */
  double orientation;
  km_advantage_state state; /* state at the last row */
  km_event_search search;
  km_events events;
  km_advantage_state last_state; /* state at the row before */
} sweep_events;

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  sweep_events *w = self;
  km_text name = {0};
  const char *unit = km_advantage_unit(r->m->model, &w->out->input, &w->out->output);
  km_text_format(&name, "%s/%s", w->out->input.name, w->out->output.name);
  w->out->column = km_table_columns(table);
  bool added = !name.failed && km_table_add_joined_column(table, "ma.", name.data, "", unit[0] ? unit : NULL);
  if (w->losses)
    added = added && km_table_add_joined_column(table, "force_ratio.", name.data, "", unit[0] ? unit : NULL);
  km_text_free(&name);
  return added && (!w->has_transmission || km_transmission_columns_add(&w->transmission, &w->out->output, table));
}

/* Computes the advantage. At a branch point, where the freedom exceeds that of the motion, it is that of the followed
 * motion r->rates. */
static void compute_advantage(const sweep_events *w, const km_sweeper *r, km_advantage *out) {
  if (r->is_batched) {
    km_transfer_along(r->m, r->s, w->transfer, km_sweeper_batched_rates(r), out);
    return;
  }
  bool at_branch_point = km_sweeper_has_more_freedoms(r) &&
                         w->transfer->moves[r->m->column_coordinate[r->m->substructures[r->substructure].column_start]];
  if (at_branch_point && w->has_rates)
    km_transfer_along(r->m, r->s, w->transfer, r->rates, out);
  else
    km_transfer_compute(r->m, r->s, w->transfer, out);
}

static double *write_value(void *self, km_sweeper *r, double *cell) {
  sweep_events *w = self;
  km_advantage a;
  w->has_rates = w->is_between_rows || r->is_batched || km_sweeper_update_rates(r);
  compute_advantage(w, r, &a);
  if (!w->is_between_rows)
    w->state = a.state;
  if (km_table_rows(w->out->motion.table) == 1)
    w->out->method = a.method;
  *cell++ = a.value;
  if (w->losses) {
    km_losses losses;
    w->failed = km_losses_compute(r->m, r->s, w->losses, &losses) == KM_MEMORY;
    *cell++ = losses.ratio;
  }
  if (w->has_transmission) {
    cell = km_transmission_columns_write(&w->transmission, r->s, w->transfer->rates, cell);
    if (!w->is_between_rows)
      w->out->last = w->transmission.last;
    w->failed = w->transmission.failed || w->failed;
  }
  return cell;
}

/* Returns -1 if the transfer's motion is opposite to that of the sweep or, with several freedoms, the last sample's. */
static double find_orientation(const sweep_events *w, const km_sweeper *r) {
  if (r->is_batched) /* oriented along the driver */
    return 1.0;
  double along = 0.0;
  const double *motion = w->has_rates && r->out->freedom == 1 ? r->rates : w->reference;
  for (int c = 0; c < r->m->coordinate_count; ++c)
    along += w->transfer->rates[c] * motion[c] / (r->m->unit[c] * r->m->unit[c]);
  return along < 0.0 ? -1.0 : 1.0;
}

/* Computes both rates, oriented along the sweep; rounding is 0 but at a probe, where a root would be a stretch. */
static void compute_values(void *self, km_sweeper *r, double *n, double *d) {
  sweep_events *w = self;
  km_advantage a;
  km_sweeper_update_motions(r);
  compute_advantage(w, r, &a);
  w->orientation = find_orientation(w, r);
  const km_transfer_end *is_last[2] = {&w->transfer->input, &w->transfer->output};
  double *const out[2] = {n, d};
  for (int i = 0; i < 2; ++i)
    *out[i] = w->search.is_probing || fabs(is_last[i]->rate) > km_solved_rounding * is_last[i]->size
                  ? w->orientation * is_last[i]->rate
                  : 0.0;
}

static void set_reference(void *self, km_sweeper *r) {
  const sweep_events *w = self;
  for (int c = 0; c < r->m->coordinate_count; ++c)
    w->reference[c] = w->orientation * w->transfer->rates[c];
}

/* Writes a row near a pole, for pictures. */
static bool write_between(void *self, km_sweeper *r, double s) {
  sweep_events *w = self;
  w->is_between_rows = true;
  bool written = km_sweeper_write_between(r, s);
  w->is_between_rows = false;
  return written;
}

static bool is_toggle(const km_event *e) {
  return e->kind == KM_EVENT_ZERO || e->kind == KM_EVENT_POLE || e->kind == KM_EVENT_UNDEFINED;
}

static km_status add_toggle(sweep_events *w, km_advantage_state state, double s, km_error *error) {
  km_event_kind kind = state == KM_ADVANTAGE_ZERO ? KM_EVENT_ZERO : KM_EVENT_POLE;
  return km_events_add(&w->events, (km_event){kind, 0, s, 0.0}, error);
}

/* Adds a toggle at a row on a dead point of the driver: the vanishing rate is limited by the driver's digits there,
 * so the search between rows does not find it. */
static km_status add_dead_point_at_row(sweep_events *w, double s, km_error *error) {
  bool toggle = w->state == KM_ADVANTAGE_ZERO || w->state == KM_ADVANTAGE_INFINITE, known = w->state == w->last_state;
  for (size_t i = 0; i < w->events.count; ++i)
    known = known || (is_toggle(&w->events.items[i]) && fabs(w->events.items[i].s - s) <= 1e-6 * (1.0 + fabs(s)));
  w->last_state = w->state;
  return toggle && !known ? add_toggle(w, w->state, s, error) : KM_OK;
}

/* Passes the rates and n, d at a row or probe to the zero and pole search. */
static km_status handle_sample(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  w->has_rates = r->is_batched || km_sweeper_update_rates(r);
  return km_event_search_sample(&w->search, r, s, error);
}

static km_status handle_row(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  km_status status = w->failed ? km_fail(error, KM_MEMORY, "out of memory for the losses and the hinges")
                               : handle_sample(self, r, s, error);
  return status || !w->search.events ? status : add_dead_point_at_row(w, s, error);
}

static void handle_branch_switch(void *self) {
  km_event_search_restart(&((sweep_events *)self)->search);
}

static km_status handle_end(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  return km_event_at_end(&w->search, r, s, error);
}

/* Collects zeros and poles as toggles; two at one position make the advantage undefined. */
static km_status collect_toggles(sweep_events *w, km_error *error) {
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
    if (!before || fabs(before->s - e->s) > km_same_position * (1.0 + fabs(e->s)))
      out->toggles[out->toggle_count++] = (km_advantage_toggle){state, e->s};
    else if (before->state != state)
      before->state = KM_ADVANTAGE_UNDEFINED;
  }
  return KM_OK;
}

static void update_extremes(km_advantage_sweep *out, double value, double s) {
  if (!isfinite(value))
    return;
  if (!(out->lowest.value <= value))
    out->lowest = (km_peak){value, s};
  if (!(out->highest.value >= value))
    out->highest = (km_peak){value, s};
  if (!(fabs(out->least.value) <= fabs(value)))
    out->least = (km_peak){value, s};
}

/* Opens the bounds beside a pole: the sign of the nearest row on each side determines which bound is infinite. */
static void open_bounds_at_pole(km_advantage_sweep *out, double s) {
  const km_table *const tables[2] = {out->motion.table, out->motion.between};
  for (int side = -1; side <= 1; side += 2) {
    const double *nearest = NULL;
    for (int i = 0; i < 2; ++i)
      for (size_t r = 0; r < km_table_rows(tables[i]); ++r) {
        const double *row = km_table_row(tables[i], r);
        bool is_usable = (row[1] - s) * side > 0.0 && isfinite(row[out->column]);
        if (is_usable && (!nearest || fabs(row[1] - s) < fabs(nearest[1] - s)))
          nearest = row;
      }
    if (nearest && nearest[out->column] > 0.0)
      out->highest = (km_peak){HUGE_VAL, s};
    if (nearest && nearest[out->column] < 0.0)
      out->lowest = (km_peak){-HUGE_VAL, s};
  }
}

static void collect_extremes(sweep_events *w) {
  const km_table *table = w->out->motion.table;
  for (size_t r = 0; r < km_table_rows(table); ++r)
    update_extremes(w->out, km_table_row(table, r)[w->out->column], km_table_row(table, r)[1]);
  for (size_t i = 0; i < w->events.count; ++i)
    if (!is_toggle(&w->events.items[i]))
      update_extremes(w->out, w->events.items[i].value, w->events.items[i].s);
  for (size_t i = 0; i < w->out->toggle_count; ++i)
    if (w->out->toggles[i].state == KM_ADVANTAGE_INFINITE)
      open_bounds_at_pole(w->out, w->out->toggles[i].s);
    else if (w->out->toggles[i].state == KM_ADVANTAGE_ZERO)
      update_extremes(w->out, 0.0, w->out->toggles[i].s);
}

static km_status check_job(const km_sweep_job *job, const km_port *input, const km_port *output) {
  km_status status = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (!status)
    status = km_check_ports(job->m, input, output, job->error);
  if (!status)
    status = km_check_given(input->name && output->name, "name of input or output", job->error);
  return status;
}

/* True if the transfer lies completely in the driven substructure: the direction of motion then suffices. */
static bool is_in_driven_substructure(const km_mechanism *m, const km_sweep_plan *plan, const km_transfer *transfer) {
  if (!km_plan_is_driven(plan))
    return false;
  int moving = m->substructure_of[plan->coordinate];
  for (int c = 0; c < m->coordinate_count && moving >= 0; ++c)
    if (transfer->moves[c] && m->substructure_of[c] != moving)
      return false;
  return moving >= 0;
}

static km_status create_evaluators(sweep_events *w, const km_sweep_job *job, bool transmission) {
  const km_mechanism *m = job->m;
  const km_port *input = &w->out->input, *output = &w->out->output;
  km_status status = km_transfer_create(m, input, output, &w->transfer, job->error);
  w->has_transmission = transmission;
  if (!status && transmission)
    status = km_transmission_columns_create(m, input, output, &w->transmission, job->error);
  w->out->friction = km_model_has_friction(m->model);
  if (!status && w->out->friction)
    status = km_losses_create(m, input, output, &w->losses, job->error);
  return status;
}

static km_status finish(void *self, const km_sweep_job *job) {
  sweep_events *w = self;
  if (w->has_transmission)
    km_transmission_columns_finish(&w->transmission, &w->out->motion);
  if (job->table_only)
    return job->status;
  km_events_sort(&w->events, job->plan);
  km_status taken = collect_toggles(w, job->error);
  collect_extremes(w);
  return taken ? taken : job->status;
}

static void close_observer(void *self) {
  sweep_events *w = self;
  km_losses_free(w->losses);
  km_transmission_columns_free(&w->transmission);
  km_transfer_free(w->transfer);
  km_event_search_free(&w->search);
  km_free(w->reference);
  km_free(w->events.items);
  km_free(w);
}

static km_observer observer_of(sweep_events *w) {
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_value,
                       .row_written = handle_row,
                       .sampled_between = handle_sample,
                       .corner = handle_branch_switch,
                       .end_reached = handle_end,
                       .finish = finish,
                       .close = close_observer,
                       .reads_basis = true,
                       .uses_direction = true};
}

static km_status open_observer(km_sweep_job *job, bool transmission, km_advantage_sweep *out) {
  sweep_events *w = KM_NEW(sweep_events, 1);
  if (!w)
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  w->out = out;
  w->observer = observer_of(w);
  w->search = km_event_search_of_ratios(w, compute_values, job->table_only ? NULL : &w->events);
  w->search.sampled = set_reference;
  w->search.between = write_between;
  job->observer = &w->observer;
  km_status status = create_evaluators(w, job, transmission);
  if (status)
    return status;
  w->observer.reads_jacobian =
      w->has_transmission || w->losses || !is_in_driven_substructure(job->m, job->plan, w->transfer);
  w->reference = KM_NEW(double, (size_t)job->m->coordinate_count);
  if (!w->reference || !km_event_search_reserve(&w->search, 1, job->plan))
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
  job->status = open_observer(job, transmission, out);
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
