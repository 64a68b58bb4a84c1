/* Mechanical advantage over a sweep: its toggles are roots of the input's and the output's rate. */
#include "kmech/advantage_sweep.h"
#include "analysis/lever.h"
#include "analysis/scan.h"
#include "analysis/transmission.h"
#include "base/text.h"
#include "kmech/losses.h"

#include <string.h>

static const double rounding = 1e-12; /* of a rate: below this an end stands */
static const double together = 1e-8;  /* a zero of both rates: neither 0 nor infinite */

enum { INPUT_RATE, OUTPUT_RATE };

typedef struct watch {
  km_advantage_sweep *out;
  km_lever *lever;
  km_transmission_work *transmission; /* NULL: not asked for */
  km_losses_work *losses;             /* NULL: no joint has friction */
  bool followed;                      /* r->rates is the motion at the pose that is looked at */
  double *reference;                  /* [coordinate] the motion at the last sample: a basis has no sense of its own */
  km_scan rates, value;
  km_events toggles, extremes;
  km_advantage_state last_state; /* of the row before */
} watch;

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  const watch *w = self;
  km_text name = {0};
  const char *unit = km_advantage_unit(r->m->model, &w->out->input, &w->out->output);
  km_text_format(&name, "%s/%s", w->out->input.name, w->out->output.name);
  w->out->column = km_table_columns(table);
  bool added = !name.failed && km_sweeper_column(table, "ma.", name.data, "", unit[0] ? unit : NULL);
  if (w->losses)
    added = added && km_sweeper_column(table, "force_ratio.", name.data, "", unit[0] ? unit : NULL);
  km_text_free(&name);
  for (int i = 0; i < KM_METRIC_COLUMNS && w->transmission; ++i) {
    unit = km_transmission_unit(r->m->model, &w->out->output, i);
    added = added && km_sweeper_column(table, km_transmission_name(i), "", "", unit[0] ? unit : NULL);
  }
  return added;
}

/* At a branch point there are more freedoms for an instant: the motion that is followed counts, r->rates. */
static void look(const watch *w, const km_sweeper *r, km_advantage *out) {
  const km_substructure *sub = r->substructure >= 0 ? &r->m->substructures[r->substructure] : NULL;
  bool meeting = sub && r->out->freedom == 1 && km_partition_freedom(&r->s->partition[r->substructure]) > 1 &&
                 w->lever->moves[r->m->column_coordinate[sub->column_start]];
  if (meeting && w->followed)
    km_lever_along(r->m, r->s, w->lever, r->rates, out);
  else
    km_lever_update(r->m, r->s, w->lever, out);
}

static double *write_value(void *self, km_sweeper *r, double *cell) {
  watch *w = self;
  km_advantage a;
  w->followed = km_sweeper_motion(r);
  look(w, r, &a);
  if (km_table_rows(w->out->motion.table) == 1)
    w->out->method = a.method;
  *cell++ = a.value;
  if (w->losses) {
    km_losses losses;
    km_losses_update(r->m, r->s, w->losses, &losses);
    *cell++ = losses.ratio;
  }
  if (w->transmission) {
    km_transmission t;
    km_transmission_update(r->m, r->s, w->transmission, &t);
    km_transmission_values(&t, cell);
    cell += KM_METRIC_COLUMNS;
  }
  return cell;
}

/* The lever at the state's pose; -1 if its motion runs against that of the last sample. */
static double update(const watch *w, km_sweeper *r) {
  km_advantage a;
  double along = 0.0;
  look(w, r, &a);
  for (int c = 0; c < r->m->coordinate_count; ++c)
    along += w->lever->rates[c] * w->reference[c] / (r->m->unit[c] * r->m->unit[c]);
  return along < 0.0 ? -1.0 : 1.0;
}

static void rates(void *self, km_sweeper *r, double *f) {
  const watch *w = self;
  double sense = update(w, r);
  const km_lever_end *ends[2] = {&w->lever->input, &w->lever->output};
  for (int i = 0; i < 2; ++i) {
    double size, rate = km_lever_rate(r->m, ends[i], w->lever->rates, &size);
    f[i] = fabs(rate) > rounding * size ? sense * rate : 0.0;
  }
}

static void value(void *self, km_sweeper *r, double *f) {
  const watch *w = self;
  km_advantage a;
  look(w, r, &a);
  f[0] = a.state == KM_ADVANTAGE_FINITE ? a.value : nan("");
}

static km_status add_toggle(watch *w, int function, double s, km_error *error) {
  void *items = w->toggles.items;
  if (!km_reserve(&items, &w->toggles.capacity, w->toggles.count + 1, sizeof *w->toggles.items))
    return km_fail(error, KM_MEMORY, "out of memory for the toggles");
  w->toggles.items = items;
  w->toggles.items[w->toggles.count++] = (km_event){KM_EVENT_ZERO, function, s, 0.0};
  return KM_OK;
}

/* A row at the dead centre of its own driver: the rate that vanishes there comes no nearer to 0 than the driver's
 * digits allow, and the search between rows has nothing to find. */
static km_status note_dead_centre(watch *w, const km_sweeper *r, double s, km_error *error) {
  km_advantage a;
  look(w, r, &a);
  bool toggle = a.state == KM_ADVANTAGE_ZERO || a.state == KM_ADVANTAGE_INFINITE, known = a.state == w->last_state;
  for (size_t i = 0; i < w->toggles.count; ++i)
    known = known || fabs(w->toggles.items[i].s - s) <= 1e-6 * (1.0 + fabs(s));
  w->last_state = a.state;
  return toggle && !known ? add_toggle(w, a.state == KM_ADVANTAGE_ZERO ? INPUT_RATE : OUTPUT_RATE, s, error) : KM_OK;
}

static km_status see(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  w->followed = km_sweeper_motion(r);
  km_status status = km_scan_sample(&w->rates, r, s, error);
  w->followed = km_sweeper_motion(r); /* what probes have left there isn't the row's */
  if (!status)
    status = km_scan_sample(&w->value, r, s, error);
  w->followed = km_sweeper_motion(r);
  double sense = update(w, r);
  for (int c = 0; c < r->m->coordinate_count; ++c)
    w->reference[c] = sense * w->lever->rates[c];
  return status ? status : note_dead_centre(w, r, s, error);
}

static void forget(void *self) {
  watch *w = self;
  w->rates.have = w->value.have = 0;
}

/* A driver that gives out stands while the rest moves. */
static km_status end_at(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  bool input = w->out->input.coordinate == r->plan->coordinate,
       output = w->out->output.coordinate == r->plan->coordinate;
  return input || output ? add_toggle(w, input ? INPUT_RATE : OUTPUT_RATE, s, error) : KM_OK;
}

static int along_sweep(const km_event *a, const km_event *b, bool backwards) {
  double difference = backwards ? b->s - a->s : a->s - b->s;
  return difference > 0.0;
}

static void sort(km_events *events, bool backwards) {
  for (size_t i = 1; i < events->count; ++i)
    for (size_t k = i; k > 0 && along_sweep(&events->items[k - 1], &events->items[k], backwards); --k) {
      km_event swap = events->items[k];
      events->items[k] = events->items[k - 1];
      events->items[k - 1] = swap;
    }
}

/* Roots of the two rates as toggles: two in one place leave the advantage undefined there. */
static km_status take_toggles(watch *w, const km_sweep_plan *plan, km_error *error) {
  km_advantage_sweep *out = w->out;
  sort(&w->toggles, plan->arclength <= 0.0 && plan->to < plan->from);
  out->toggles = KM_NEW(km_advantage_toggle, w->toggles.count);
  if (!out->toggles)
    return km_fail(error, KM_MEMORY, "out of memory for the toggles");
  int last = -1;
  for (size_t i = 0; i < w->toggles.count; ++i) {
    const km_event *e = &w->toggles.items[i];
    km_advantage_toggle *before = out->toggle_count ? &out->toggles[out->toggle_count - 1] : NULL;
    if (before && fabs(before->s - e->s) <= together * (1.0 + fabs(e->s))) {
      if (e->function != last)
        before->state = KM_ADVANTAGE_UNDEFINED;
    } else {
      out->toggles[out->toggle_count++] =
          (km_advantage_toggle){e->function == INPUT_RATE ? KM_ADVANTAGE_ZERO : KM_ADVANTAGE_INFINITE, e->s};
    }
    last = e->function;
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
}

/* Beside a pose of infinite advantage it has no bound: which way, the nearest rows tell. */
static void open_bounds(km_advantage_sweep *out, const km_table *table, double s) {
  for (int side = -1; side <= 1; side += 2) {
    const double *nearest = NULL;
    for (size_t r = 0; r < km_table_rows(table); ++r) {
      const double *row = km_table_row(table, r);
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

static void take_extremes(watch *w, const km_table *table, size_t column) {
  for (size_t r = 0; r < km_table_rows(table); ++r)
    widen(w->out, km_table_row(table, r)[column], km_table_row(table, r)[1]);
  for (size_t i = 0; i < w->extremes.count; ++i)
    if (w->extremes.items[i].kind != KM_EVENT_POLE)
      widen(w->out, w->extremes.items[i].value, w->extremes.items[i].s);
  for (size_t i = 0; i < w->out->toggle_count; ++i)
    if (w->out->toggles[i].state == KM_ADVANTAGE_INFINITE)
      open_bounds(w->out, table, w->out->toggles[i].s);
}

static km_status run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, watch *w, km_error *error) {
  km_observer observer = {w, add_columns, write_value, see, see, forget, end_at};
  w->rates = (km_scan){.self = w, .values = rates, .zeros = true, .events = &w->toggles};
  w->value = (km_scan){.self = w, .values = value, .extremes = true, .events = &w->extremes};
  w->reference = KM_NEW(double, (size_t)m->coordinate_count);
  if (!w->reference || !km_scan_reserve(&w->rates, 2) || !km_scan_reserve(&w->value, 1))
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  km_status status = km_sweep_run(m, s, plan, &observer, &w->out->motion, error);
  if (status && status != KM_PARTIAL)
    return status;
  km_status taken = take_toggles(w, plan, error);
  take_extremes(w, w->out->motion.table, w->out->column);
  return taken ? taken : status;
}

km_status km_advantage_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, const km_handle *input,
                                 const km_handle *output, bool transmission, km_advantage_sweep *out, km_error *error) {
  km_peak none = {nan(""), nan("")};
  *out = (km_advantage_sweep){
      .motion = {.substructure = -1}, .input = *input, .output = *output, .lowest = none, .highest = none};
  watch w = {.out = out};
  km_status status = km_lever_create(m, input, output, &w.lever, error);
  if (!status && transmission)
    status = km_transmission_create(m, input, output, &w.transmission, error);
  out->friction = km_model_has_friction(m->model);
  if (!status && out->friction)
    status = km_losses_create(m, input, output, &w.losses, error);
  if (!status)
    status = run(m, s, plan, &w, error);
  km_losses_free(w.losses);
  km_transmission_free(w.transmission);
  km_lever_free(w.lever);
  km_scan_free(&w.rates);
  km_scan_free(&w.value);
  km_free(w.reference);
  km_free(w.toggles.items);
  km_free(w.extremes.items);
  return status;
}

void km_advantage_sweep_free(km_advantage_sweep *sweep) {
  km_sweep_free(&sweep->motion);
  km_free(sweep->toggles);
  *sweep = (km_advantage_sweep){0};
}
