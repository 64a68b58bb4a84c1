/* Plots for programs: made of answers and tables, drawn as pictures. */
#include "report/charts/chart.h"

#include "base/arguments.h"
#include "question/question.h"
#include "report/charts/history_plot.h"
#include "report/charts/question_plot.h"
#include "report/charts/table_plot.h"

#include <string.h>

void km_chart_free(km_chart *chart) {
  if (chart)
    km_arena_free(&chart->arena);
  km_free(chart);
}

static km_status begin(km_chart **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = KM_NEW(km_chart, 1);
  return *out ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a plot");
}

/* Keeps a plot that was made, or frees what there is of it. */
static km_status end(km_status status, km_chart **out) {
  if (!status)
    return KM_OK;
  km_chart_free(*out);
  *out = NULL;
  return status;
}

static km_status check_shown(const km_mechanism *m, const int *shown, int count, km_error *error) {
  km_status status = shown ? km_check_list(shown, count, "coordinates", error) : KM_OK;
  for (int i = 0; i < count && shown && !status; ++i)
    status = km_check_index(shown[i], m->coordinate_count, "coordinate", error);
  return status;
}

/* True if the answers have the kind of the first one. */
static km_status check_answer(const km_answered *a, const km_answered *first, km_error *error) {
  km_status status = km_check_given(a->question && a->name, "question or name", error);
  if (status)
    return status;
  if (!km_question_table(a->question) || km_table_rows(km_question_table(a->question)) == 0)
    return km_fail(error, KM_USAGE, "there is no answer to plot");
  if (a->question->kind != first->question->kind)
    return km_fail(error, KM_USAGE, "answers to \"%s\" and \"%s\"; expected one kind in a plot",
                   first->question->kind->name, a->question->kind->name);
  return check_shown(a->question->m, a->shown, a->shown_count, error);
}

km_status km_question_chart(const km_comparison *c, km_chart **out, km_error *error) {
  km_status status = begin(out, error);
  if (status)
    return status;
  status = km_check_given(c && c->answers && c->count > 0, "answer", error);
  for (int i = 0; !status && i < c->count; ++i)
    status = check_answer(&c->answers[i], &c->answers[0], error);
  if (!status)
    status = km_question_plot_make(c, &(*out)->arena, &(*out)->plot, error);
  return end(status, out);
}

static km_status check_table(const km_plotted_table *t, int columns, km_error *error) {
  km_status status = km_check_given(t->table && t->name && t->y, "table, name or columns", error);
  int count = (int)km_table_columns(t->table);
  if (!status)
    status = km_check_index((int)t->x, count, "column", error);
  for (int k = 0; k < columns && !status; ++k)
    status = km_check_index((int)t->y[k], count, "column", error);
  return status;
}

/* A label of the y axis is for one axis. */
static km_status check_units(const km_plotted_table *t, int columns, const km_chart_words *words, km_error *error) {
  for (int k = 1; k < columns && words->y_label; ++k)
    if (strcmp(km_table_unit(t->table, t->y[k]), km_table_unit(t->table, t->y[0])) != 0)
      return km_fail(error, KM_USAGE,
                     "a label for one y axis, but columns in \"%s\" and \"%s\" have one each; expected "
                     "columns of one unit",
                     km_table_unit(t->table, t->y[0]), km_table_unit(t->table, t->y[k]));
  return KM_OK;
}

km_status km_table_chart_worded(const km_plotted_table *tables, int count, int columns, const km_chart_words *words,
                                km_chart **out, km_error *error) {
  km_status status = begin(out, error);
  if (status)
    return status;
  status = km_check_given(tables && words && count > 0 && columns > 0, "table, words or column", error);
  for (int i = 0; !status && i < count; ++i)
    status = check_table(&tables[i], columns, error);
  if (!status)
    status = check_units(tables, columns, words, error);
  if (!status && !km_table_plot_make(tables, (size_t)count, (size_t)columns, words, &(*out)->arena, &(*out)->plot))
    status = km_fail(error, KM_MEMORY, "out of memory for a plot");
  return end(status, out);
}

km_status km_table_chart(const km_plotted_table *tables, int count, int columns, km_chart **out, km_error *error) {
  const km_chart_words none = {0};
  return km_table_chart_worded(tables, count, columns, &none, out, error);
}

static km_status check_history(const km_plotted_history *h, km_error *error) {
  km_status status = km_check_given(h && h->mechanism && h->table && h->name, "mechanism, table or name", error);
  if (status)
    return status;
  km_span q = km_table_span(h->table, "q.");
  if (km_table_rows(h->table) == 0 || (int)q.count != h->mechanism->coordinate_count)
    return km_fail(error, KM_USAGE, "a table of %zu rows and %zu coordinates; expected a motion's, of %d coordinates",
                   km_table_rows(h->table), q.count, h->mechanism->coordinate_count);
  if (h->met_count)
    status = km_check_given(h->met && h->crossings && h->met_count > 0, "crossings", error);
  return status ? status : check_shown(h->mechanism, h->joints, h->joint_count, error);
}

static km_status make_history(const km_plotted_history *h,
                              bool (*make)(const km_plotted_history *, km_arena *, km_plot *), km_chart **out,
                              km_error *error) {
  km_status status = begin(out, error);
  if (status)
    return status;
  status = check_history(h, error);
  if (!status && !make(h, &(*out)->arena, &(*out)->plot))
    status = km_fail(error, KM_MEMORY, "out of memory for a plot");
  return end(status, out);
}

km_status km_history_chart(const km_plotted_history *history, km_chart **out, km_error *error) {
  return make_history(history, km_history_plot_make, out, error);
}

km_status km_inverse_chart(const km_plotted_history *history, km_chart **out, km_error *error) {
  return make_history(history, km_inverse_plot_make, out, error);
}

km_status km_chart_picture(const km_chart *chart, km_picture_format format, km_text *out, km_error *error) {
  km_status status = km_check_picture(out, format, error);
  if (!status)
    status = km_check_given(chart != NULL, "plot", error);
  return status ? status : km_plot_render(&chart->plot, format, out, error);
}
