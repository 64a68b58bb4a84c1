/* ksim run --from: going on where the table of an earlier run ends. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static kt_exit read_table(const ksim_options *o, km_table **out) {
  km_text text = {0};
  km_error error;
  km_status status = km_file_read(o->from, &text, &error);
  if (!status)
    status = km_csv_read(&text, o->from, out, &error);
  km_text_free(&text);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "--from: %s", error.text);
  return kt_exit_of(status);
}

/* The column is in the model's unit, or in none. */
static bool has_unit(const ksim_work *w, const km_table *table, int column, const char *unit) {
  const char *own = km_table_unit(table, (size_t)column);
  if (!*own || strcmp(own, unit) == 0)
    return true;
  kt_print_message(&w->options->common, KM_ERROR, "--from %s: column %s is in %s; expected %s, the model's unit",
                   w->options->from, km_table_name(table, (size_t)column), own, unit);
  return false;
}

/* Value of the column PREFIX + label in the last row; `per`: suffix of the coordinate's unit. */
static kt_exit read_value(const ksim_work *w, const km_table *table, const char *prefix, const char *per,
                          int coordinate, double *out) {
  const ksim_options *o = w->options;
  km_text name = {0}, unit = {0};
  km_text_format(&name, "%s%s", prefix, km_model_coordinate_label(w->pose.model, coordinate));
  km_text_format(&unit, "%s%s", km_model_coordinate_unit(w->pose.model, coordinate), per);
  bool failed = name.failed || unit.failed;
  int column = failed ? -1 : km_csv_find(table, name.data);
  if (column >= 0)
    *out = km_table_row(table, km_table_rows(table) - 1)[column];
  kt_exit result = failed ? KT_INTERNAL : KT_DONE;
  if (!failed && (column < 0 || !isfinite(*out))) {
    kt_print_message(&o->common, KM_ERROR,
                     "--from %s: its last row has no %s; expected the table of a run of this model", o->from,
                     name.data);
    result = KT_USAGE;
  } else if (!failed && !has_unit(w, table, column, unit.data)) {
    result = KT_USAGE;
  }
  km_text_free(&name);
  km_text_free(&unit);
  return result;
}

static kt_exit copy_row(ksim_work *w, const km_table *table) {
  const km_mechanism *m = w->pose.mechanism;
  int count = km_model_coordinate_count(w->pose.model);
  int time = km_csv_find(table, "t");
  kt_exit result = KT_DONE;
  km_error error;
  if (km_table_rows(table) == 0 || time < 0) {
    kt_print_message(&w->options->common, KM_ERROR, "--from %s: it has no row with a time; expected the table of a run",
                     w->options->from);
    return KT_USAGE;
  }
  const char *second = km_model_units(w->pose.model).time->suffix;
  char per[16];
  snprintf(per, sizeof per, "/%s", second);
  if (!has_unit(w, table, time, second))
    return KT_USAGE;
  w->def.start = km_table_row(table, km_table_rows(table) - 1)[time];
  double *q = KM_NEW(double, (size_t)count + 1);
  for (int c = 0; c < count && q && result == KT_DONE; ++c) {
    double rate = 0.0;
    result = read_value(w, table, "q.", "", c, &q[c]);
    if (result == KT_DONE)
      result = read_value(w, table, "v.", per, c, &rate);
    if (result == KT_DONE && !km_coordinate_is_held(m, c))
      result = kt_exit_of(km_state_set_rate(m, w->pose.state, c, rate, NULL));
  }
  if (q && result == KT_DONE)
    result = kt_exit_of(km_state_set_coordinates(m, w->pose.state, q, &error));
  km_free(q);
  return q ? result : KT_INTERNAL;
}

/* Integrals of controllers and slips of tyres aren't in tables. */
static void report_memories(const ksim_work *w) {
  if (km_model_remembers(w->pose.model))
    kt_print_message(&w->options->common, KM_NOTE,
                     "%s: integrals of controllers and slips of tyres aren't in tables; with --from they start from 0",
                     w->options->model);
}

kt_exit ksim_continue(ksim_work *w) {
  km_table *table = NULL;
  if (!w->options->from)
    return KT_DONE;
  if (w->options->sets.count > 0)
    return kt_usage(&w->options->common, "--from", "a table beside --set", "one of them: both give the pose");
  kt_exit result = read_table(w->options, &table);
  if (result == KT_DONE)
    result = copy_row(w, table);
  if (result == KT_DONE)
    report_memories(w);
  km_table_free(table);
  return result;
}
