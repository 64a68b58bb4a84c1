/* Record and summary of a simulation and of inverse dynamics. */
#include "kmech/report.h"

#include "report/record/record.h"
#include "report/record/sweep_text.h"
#include "report/record/words/forces_text.h"
#include "report/record/words/speed_text.h"
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

km_value *km_history_record(const km_mechanism *m, const km_history_def *def, const km_history *h,
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

km_value *km_inverse_record(const km_mechanism *m, const km_history *h, const char *stopped_by, const char *name,
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

/* Prints the forces that act, and those that reactions leave out. */
static void print_acting(const km_model *model, const km_table *table, km_text *out) {
  km_text meshing = {0};
  km_text_add(out, "  ");
  km_acting_words(model, NULL, false, out);
  km_text_add(out, "\n");
  if (km_table_span(table, "r.").count > 0)
    km_meshing_words(model, &meshing);
  if (meshing.size)
    km_text_format(out, "  %s\n", meshing.data);
  out->failed = out->failed || meshing.failed;
  km_text_free(&meshing);
}

static void print_run(const km_model *model, const km_history_def *def, const km_history *h, km_text *out) {
  const char *unit = model->units.time->suffix;
  km_text_format(out, "  loops closed to %.1e of their size; ", h->worst_loop);
  if (h->energy_scale > h->figures.rest_energy)
    km_text_format(out, "energy kept to %.1e of the largest kinetic energy\n", h->energy_error / h->energy_scale);
  else
    km_text_add(out, "nothing moves by more than the tolerances\n");
  for (int i = 0; i < h->crossing_count; ++i) {
    const km_crossing *crossing = &def->simulation.crossings[h->crossings[i].crossing];
    km_text_format(out, "  %s passes %.6g %s %s at %.9g %s\n", km_model_coordinate_label(model, crossing->coordinate),
                   crossing->value, km_model_coordinate_unit(model, crossing->coordinate),
                   h->crossings[i].sense > 0 ? "upwards" : "downwards", h->crossings[i].time, unit);
  }
}

static void print_speed(const km_mechanism *m, const km_table *table, km_text *out) {
  km_text words = {0};
  km_speed_words(m, table, &words);
  if (words.size)
    km_text_format(out, "  %s\n", words.data);
  out->failed = out->failed || words.failed;
  km_text_free(&words);
}

static void print_peak(const km_mechanism *m, const km_table *table, const km_force_peak *peak, km_text *out) {
  const km_model *model = m->model;
  const char *force = km_table_unit(table, peak->column), *time = model->units.time->suffix;
  if (peak->coordinate < 0)
    km_text_format(out, "  shaking force at most %.6g %s", peak->value, force);
  else
    km_text_format(out, "  %s is driven by at most %.6g %s", km_model_coordinate_label(model, peak->coordinate),
                   fabs(peak->value), force);
  if (peak->coordinate >= 0 && peak->value < 0.0)
    km_text_format(out, " in size, %.6g", peak->value);
  km_text_format(out, " at %.6g %s", peak->time, time);
  km_place_words(m, table, peak->coordinate, peak->time, out);
  km_text_format(out, ", %.6g rms\n", peak->rms);
}

double km_largest_norm(const km_table *t, size_t first, double *where) {
  double most = -1.0;
  for (size_t r = 0; r < km_table_rows(t); ++r) {
    const double *row = km_table_row(t, r);
    double norm = hypot(hypot(row[first], row[first + 1]), row[first + 2]);
    if (norm > most) {
      most = norm;
      *where = row[0];
    }
  }
  return most;
}

/* "  bearings: C 23478 N at 0.0016 s, A …": the largest reactions, if they are in the table. */
static void print_bearings(const km_mechanism *m, const km_table *table, km_text *out) {
  const km_model *model = m->model;
  enum { MOST_SHOWN = 4 };
  const km_span span = km_table_span(table, "r.");
  double last = HUGE_VAL;
  size_t last_joint = 0;
  for (int shown = 0; shown < MOST_SHOWN; ++shown) {
    double most = 0.0, when = 0.0;
    size_t joint = 0;
    for (size_t j = 0; j < span.count / 6; ++j) {
      double at = 0.0, size = km_largest_norm(table, span.first + 6 * j, &at);
      bool is_after = size < last || (size == last && j > last_joint);
      if (is_after && size > most) {
        most = size;
        when = at;
        joint = j;
      }
    }
    if (most == 0.0)
      break;
    km_text_format(out, "%s %s %.6g %s at %.6g %s", shown ? "," : "  bearings:", model->joints[joint].label, most,
                   km_table_unit(table, span.first + 6 * joint), when, model->units.time->suffix);
    km_place_words(m, table, -1, when, out);
    last = most;
    last_joint = joint;
  }
  km_text_add(out, last < HUGE_VAL ? "\n" : "");
}

void km_history_print(const km_mechanism *m, const km_history_def *def, const km_history *h, const char *name,
                      km_text *out) {
  if (!m || !h || !h->table || km_table_rows(h->table) == 0 || !name || !out)
    return;
  const km_model *model = m->model;
  size_t rows = km_table_rows(h->table);
  km_text_format(out, "%s: %.6g %s, %zu rows", name, km_table_row(h->table, rows - 1)[0], model->units.time->suffix,
                 rows);
  if (def)
    km_text_format(out, "; %ld steps, %ld evaluations, %d new partition%s", h->figures.steps, h->figures.evaluations,
                   h->figures.repartitions, h->figures.repartitions == 1 ? "" : "s");
  km_text_add(out, "\n");
  print_acting(model, h->table, out);
  print_speed(m, h->table, out);
  if (def)
    print_run(model, def, h, out);
  for (int i = 0; i < h->peak_count; ++i)
    print_peak(m, h->table, &h->peaks[i], out);
  print_bearings(m, h->table, out);
}
