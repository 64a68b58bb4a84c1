/* Finds the plot of each kind of question. */
#include "report/plot/question_plot.h"

#include "base/memory.h"
#include "report/plot/advantage_plot.h"
#include "report/plot/mobility_plot.h"
#include "report/plot/statics_plot.h"
#include "report/plot/table_plot.h"

static km_swept swept(const km_answered *a) {
  return (km_swept){a->mechanism, km_question_plan(a->question), km_question_motion(a->question), a->name};
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a plot");
}

static km_status plot_mobility(const km_comparison *c, km_canvas_format format, km_text *out, km_error *error) {
  km_plotted_sweep *sweeps = KM_NEW(km_plotted_sweep, (size_t)c->count);
  if (!sweeps)
    return no_memory(error);
  for (int i = 0; i < c->count; ++i)
    sweeps[i] = (km_plotted_sweep){c->answers[i].mechanism,
                                   km_question_plan(c->answers[i].question),
                                   km_question_mobility(c->answers[i].question),
                                   c->answers[i].name,
                                   c->answers[i].shown,
                                   c->answers[i].shown_count};
  km_status status = km_mobility_plot(sweeps, c->count, c->ordered, format, out, error);
  km_free(sweeps);
  return status;
}

static km_status plot_advantage(const km_comparison *c, km_canvas_format format, km_text *out, km_error *error) {
  km_plotted_advantage *sweeps = KM_NEW(km_plotted_advantage, (size_t)c->count);
  if (!sweeps)
    return no_memory(error);
  for (int i = 0; i < c->count; ++i)
    sweeps[i] = (km_plotted_advantage){swept(&c->answers[i]), km_question_advantage(c->answers[i].question)};
  km_status status = km_advantage_plot(sweeps, c->count, c->ordered, format, out, error);
  km_free(sweeps);
  return status;
}

static km_status plot_statics(const km_comparison *c, km_canvas_format format, km_text *out, km_error *error) {
  km_plotted_statics *sweeps = KM_NEW(km_plotted_statics, (size_t)c->count);
  if (!sweeps)
    return no_memory(error);
  for (int i = 0; i < c->count; ++i)
    sweeps[i] = (km_plotted_statics){swept(&c->answers[i]), km_question_statics(c->answers[i].question),
                                     c->answers[i].shown, c->answers[i].shown_count};
  km_status status = km_statics_plot(sweeps, c->count, c->ordered, format, out, error);
  km_free(sweeps);
  return status;
}

km_status km_question_plot_columns(const km_comparison *c, const size_t *columns, size_t count, km_canvas_format format,
                                   km_text *out, km_error *error) {
  km_plotted_table *tables = KM_NEW(km_plotted_table, (size_t)c->count);
  if (!tables)
    return no_memory(error);
  for (int i = 0; i < c->count; ++i) {
    const km_table *table = km_question_table(c->answers[i].question);
    tables[i] = (km_plotted_table){table, c->answers[i].name, (size_t)km_table_find(table, "s"), columns};
  }
  km_status status = km_table_plot(tables, (size_t)c->count, count, format, out, error);
  km_free(tables);
  return status;
}

/* What an arm has to spare along its path. */
static km_status plot_tracks(const km_comparison *c, km_canvas_format format, km_text *out, km_error *error) {
  static const char *const names[] = {"limit_margin", "objective.path-control", "objective.singular-value"};
  enum { COLUMNS = sizeof names / sizeof *names };
  size_t columns[COLUMNS];
  for (size_t k = 0; k < COLUMNS; ++k)
    columns[k] = (size_t)km_table_find(km_question_table(c->answers[0].question), names[k]);
  return km_question_plot_columns(c, columns, COLUMNS, format, out, error);
}

km_status km_question_plot(const km_comparison *c, km_canvas_format format, km_text *out, km_error *error) {
  if (c->count > 0 && km_question_mobility(c->answers[0].question))
    return plot_mobility(c, format, out, error);
  if (c->count > 0 && km_question_advantage(c->answers[0].question))
    return plot_advantage(c, format, out, error);
  if (c->count > 0 && km_question_statics(c->answers[0].question))
    return plot_statics(c, format, out, error);
  if (c->count > 0 && km_question_track(c->answers[0].question))
    return plot_tracks(c, format, out, error);
  return km_fail(error, KM_USAGE, "there is no answer to plot");
}
