/* ksim run --animate: the motion as a page that plays it beside its curves. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/version.h"

enum { MOST_FRAMES = 600 };

typedef struct animation {
  const kt_sweep_job *job;
  km_table *table; /* the rows that are shown */
  km_drawing *drawing;
  double *times;
} animation;

static km_table *thinned(const km_table *from, size_t stride) {
  km_table *out = km_table_create();
  bool good = out != NULL;
  for (size_t c = 0; good && c < km_table_columns(from); ++c)
    good = km_table_add_column(out, km_table_name(from, c), km_table_unit(from, c)) >= 0;
  for (size_t r = 0; good && r < km_table_rows(from); r += stride) {
    double *row = km_table_add_row(out);
    good = row != NULL;
    for (size_t c = 0; good && c < km_table_columns(from); ++c)
      row[c] = km_table_row(from, r)[c];
  }
  if (good)
    return out;
  km_table_free(out);
  return NULL;
}

static km_status copy_rows(animation *a, km_error *error) {
  const km_table *all = km_question_table(a->job->question);
  a->table = thinned(all, (km_table_rows(all) - 1) / MOST_FRAMES + 1);
  a->times = a->table ? KM_NEW(double, km_table_rows(a->table)) : NULL;
  if (!a->times)
    return km_fail(error, KM_MEMORY, "out of memory for a motion");
  km_status status = km_table_column(a->table, 0, a->times, error);
  if (!status)
    status = km_drawing_create(a->job->pose.mechanism, &a->drawing, error);
  return status ? status : km_drawing_add_rows(a->drawing, a->table, error);
}

static km_status write_page(const animation *a, km_text *out, km_error *error) {
  const kt_sweep_job *j = a->job;
  const km_unit *time = km_model_units(j->pose.model).time;
  const km_answered answer = {j->question, j->label, j->shown, j->shown_count, NULL};
  km_plotted_history shown = km_question_plotted_history(&answer);
  shown.table = a->table;
  km_chart *chart = NULL;
  km_status status = km_history_chart(&shown, &chart, error);
  const km_motion_page page = {.title = j->label,
                               .subtitle = "motion over time",
                               .footer = "kmech " KM_VERSION " · ksim run --animate",
                               .quantity = "time",
                               .unit = time->suffix,
                               .values = a->times,
                               .closed = true, /* it doesn't run backwards */
                               .seconds = (a->times[km_table_rows(a->table) - 1] - a->times[0]) * time->si,
                               .chart = chart,
                               .chart_alt = "its coordinates, rates and energies over time"};
  if (!status)
    status = km_drawing_page(a->drawing, &(const km_drawing_look){0}, &page, out, error);
  km_chart_free(chart);
  return status;
}

kt_exit ksim_animate(const kt_sweep_job *j, const char *base) {
  animation a = {.job = j};
  km_text out = {0};
  km_error error;
  km_status status = copy_rows(&a, &error);
  if (!status)
    status = write_page(&a, &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&j->options->common, KM_ERROR, "%s: %s", j->name, error.text);
  else
    result = kt_write(&j->options->common, base, "motion", "html", &out);
  km_text_free(&out);
  km_drawing_free(a.drawing);
  km_table_free(a.table);
  km_free(a.times);
  return result;
}
