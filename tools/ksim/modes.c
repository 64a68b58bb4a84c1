/* ksim linearise --animate: every mode as a page that plays it. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "kmech/version.h"

#include <math.h>
#include <stdio.h>

enum { ROWS = 121 };
static const double seconds = 2; /* that a swing is played in, whatever its frequency */

static void describe(const ksim_modes *m, int k, km_text *out) {
  double second = km_model_units(m->pose->model).time->si;
  double re = m->linear->real[k] / second, im = m->linear->imaginary[k] / second;
  switch (km_linear_kind_of(m->linear, k)) {
  case KM_LINEAR_ZERO:
    km_text_add(out, "a motion that nothing drives back");
    break;
  case KM_LINEAR_OSCILLATES:
    km_text_format(out, "swings at %.5g Hz, damping %.4g", im / (2.0 * M_PI),
                   fabs(re) > 1e-9 * im ? -re / hypot(re, im) : 0.0);
    break;
  case KM_LINEAR_DECAYS:
    km_text_format(out, "dies away in %.4g s", -1.0 / re);
    break;
  case KM_LINEAR_GROWS:
    km_text_format(out, "grows in %.4g s", 1.0 / re);
    break;
  }
  km_text_add(out, " · amplitude chosen to be seen");
}

static km_status write_page(const ksim_modes *m, const km_table *table, const char *title, const char *about,
                            km_text *out, km_error *error) {
  km_drawing *drawing = NULL;
  double *values = KM_NEW(double, km_table_rows(table));
  km_status status =
      values ? km_table_column(table, 0, values, error) : km_fail(error, KM_MEMORY, "out of memory for a motion");
  const km_motion_page page = {.title = title,
                               .subtitle = about,
                               .footer = "kmech " KM_VERSION " · ksim linearise --animate",
                               .quantity = km_table_name(table, 0),
                               .unit = km_table_unit(table, 0),
                               .values = values,
                               .closed = true, /* a swing comes round, and the rest doesn't run backwards */
                               .seconds = seconds};
  if (!status)
    status = km_drawing_create(m->pose->mechanism, &drawing, error);
  if (!status)
    status = km_drawing_add_rows(drawing, table, error);
  if (!status)
    status = km_drawing_page(drawing, &(const km_drawing_look){0}, &page, out, error);
  km_drawing_free(drawing);
  km_free(values);
  return status;
}

static kt_exit animate(const ksim_modes *m, int k, int line) {
  char name[256], word[32];
  km_text title = {0}, about = {0}, out = {0};
  km_table *table = NULL;
  km_error error;
  kt_base_name(m->model, name, sizeof name);
  snprintf(word, sizeof word, "mode%d", line);
  km_text_format(&title, "%s, mode %d", name, line);
  describe(m, k, &about);
  km_status status = title.failed || about.failed
                         ? km_fail(&error, KM_MEMORY, "out of memory for a page")
                         : km_linear_motion(m->dynamics, m->pose->state, m->linear, k, ROWS, &table, &error);
  if (!status)
    status = write_page(m, table, title.data, about.data, &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(m->common, KM_ERROR, "%s: mode %d: %s", m->model, line, error.text);
  else
    result = kt_write(m->common, m->base, word, "html", &out);
  km_table_free(table);
  km_text_free(&title);
  km_text_free(&about);
  km_text_free(&out);
  return result;
}

kt_exit ksim_animate_modes(const ksim_modes *m) {
  kt_exit result = KT_DONE;
  int line = 0;
  for (int k = 0; k < 2 * m->linear->freedom; ++k) {
    if (m->linear->imaginary[k] < 0.0)
      continue; /* the table has one line for a pair */
    ++line;
    if (!m->only || m->only == line)
      result = kt_worse(result, animate(m, k, line));
  }
  if (m->only <= line)
    return result;
  kt_print_message(m->common, KM_ERROR, "--only %d: %s has %d modes", m->only, m->model, line);
  return KT_USAGE;
}
