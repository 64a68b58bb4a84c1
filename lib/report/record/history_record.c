/* The record of a simulation, key by key. */
#include "kmech/report.h"

#include "report/record/record.h"
#include "topology/mechanism.h"

static void add_events(const km_model *model, const km_history_def *def, const km_history *h, km_value *record,
                       km_arena *arena) {
  km_value *events = km_value_add(arena, record, "events", KM_LIST);
  for (int i = 0; i < h->crossing_count && !arena->failed; ++i) {
    const km_crossing *crossing = &def->simulation.crossings[h->crossings[i].crossing];
    km_value *event = km_value_add(arena, events, NULL, KM_OBJECT);
    km_value_string(arena, event, "joint", km_model_coordinate_label(model, crossing->coordinate));
    km_value_number(arena, event, "value", crossing->value);
    km_value_number(arena, event, "t", h->crossings[i].time);
    km_value_string(arena, event, "sense", h->crossings[i].sense > 0 ? "up" : "down");
    km_value_boolean(arena, event, "stops", crossing->stops);
  }
}

/* The drives that went beyond their bounds. */
static void add_exceeded(const km_model *model, const km_history *h, km_value *record, km_arena *arena) {
  static const char *const keys[2] = {"beyond_max_rate", "beyond_max_force"};
  for (int force = 1; force >= 0; --force) {
    km_value *list = km_value_add(arena, record, keys[force], KM_LIST);
    for (int i = 0; i < h->exceeded_count && !arena->failed; ++i)
      if (h->exceeded[i].of_force == (force == 1))
        km_value_string(arena, list, NULL, km_model_coordinate_label(model, h->exceeded[i].coordinate));
  }
}

static void add_limits(const km_model *model, const km_history *h, km_value *record, km_arena *arena) {
  km_value *list = km_value_add(arena, record, "limits_passed", KM_LIST);
  for (int i = 0; i < h->limit_count && !arena->failed; ++i) {
    const km_passed_limit *limit = &h->limits[i];
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, item, "joint", km_model_coordinate_label(model, limit->coordinate));
    km_value_number(arena, item, "limit", limit->limit);
    km_value_number(arena, item, "t", limit->time);
    km_value_number(arena, item, "beyond", limit->beyond);
  }
}

static void add_changed_rates(const km_model *model, const km_history *h, km_value *record, km_arena *arena) {
  km_value *list = km_value_add(arena, record, "changed_initial_rates", KM_LIST);
  for (int i = 0; i < h->changed_rate_count && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, item, "joint", km_model_coordinate_label(model, h->changed_rates[i].coordinate));
    km_value_number(arena, item, "stated", h->changed_rates[i].stated);
    km_value_number(arena, item, "start", h->changed_rates[i].start);
  }
}

static void add_peaks(const km_model *model, const km_history *h, km_value *record, km_arena *arena) {
  km_value *list = km_value_add(arena, record, "largest_forces", KM_LIST);
  for (int i = 0; i < h->peak_count && !arena->failed; ++i) {
    const km_force_peak *peak = &h->peaks[i];
    km_value *item = km_value_add(arena, list, NULL, KM_OBJECT);
    km_value_string(arena, item, "of",
                    peak->coordinate < 0 ? "shaking" : km_model_coordinate_label(model, peak->coordinate));
    km_value_number(arena, item, "value", peak->value);
    km_value_number(arena, item, "t", peak->time);
    km_value_number(arena, item, "rms", peak->rms);
  }
}

static void add_note(const km_model *model, const km_table *table, km_value *record, km_arena *arena) {
  if (km_table_span(table, "r.").count > 0)
    km_reactions_note_record(model, record, arena);
}

const km_value *km_history_record(const km_mechanism *m, const km_history_def *def, const km_history *h,
                                  const char *stopped_by, const char *name, km_arena *arena) {
  if (!m || !def || !h || !stopped_by || !name || !arena)
    return NULL;
  km_value *record = km_record_head(m, "ksim run", name, arena);
  km_value_number(arena, record, "steps", (double)h->figures.steps);
  km_value_number(arena, record, "evaluations", (double)h->figures.evaluations);
  km_value_number(arena, record, "rejected_steps", (double)h->figures.rejected);
  km_value_number(arena, record, "repartitions", (double)h->figures.repartitions);
  km_value_boolean(arena, record, "stiff", h->figures.stiff);
  km_value_number(arena, record, "worst_loop_error", h->worst_loop);
  km_value_number(arena, record, "energy_error", h->energy_error);
  km_value_number(arena, record, "largest_kinetic_energy", h->energy_scale);
  km_value_number(arena, record, "initial_rate_change", h->rate_change);
  add_changed_rates(m->model, h, record, arena);
  add_events(m->model, def, h, record, arena);
  add_exceeded(m->model, h, record, arena);
  add_limits(m->model, h, record, arena);
  add_note(m->model, h->table, record, arena);
  km_table_record(h->table, record, arena);
  km_value_boolean(arena, record, "complete", stopped_by[0] == '\0');
  km_value_string(arena, record, "stopped_by", stopped_by);
  return arena->failed ? NULL : record;
}

const km_value *km_inverse_record(const km_mechanism *m, const km_history *h, const char *stopped_by, const char *name,
                                  km_arena *arena) {
  if (!m || !h || !stopped_by || !name || !arena)
    return NULL;
  km_value *record = km_record_head(m, "ksim inverse", name, arena);
  km_value_number(arena, record, "worst_loop_error", h->worst_loop);
  add_exceeded(m->model, h, record, arena);
  add_limits(m->model, h, record, arena);
  add_peaks(m->model, h, record, arena);
  add_note(m->model, h->table, record, arena);
  km_table_record(h->table, record, arena);
  km_value_boolean(arena, record, "complete", stopped_by[0] == '\0');
  km_value_string(arena, record, "stopped_by", stopped_by);
  return arena->failed ? NULL : record;
}
