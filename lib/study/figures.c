/* Figures of merit of a computed request, and the rows of its bands. */
#include "base/similar_names.h"
#include "exchange/json/formula.h"
#include "question/question.h"
#include "spatial/vec3.h"
#include "study/design_study.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

km_design_figure km_design_figure_default(void) {
  return (km_design_figure){.low = -HUGE_VAL, .high = HUGE_VAL};
}

bool km_design_is_better(const km_design_figure *figure, double a, double b) {
  if (!figure || isnan(a))
    return false;
  return isnan(b) || (figure->better > 0 && a > b) || (figure->better < 0 && a < b);
}

static double reached_range(const km_table *t) {
  size_t rows = km_table_rows(t);
  int s = km_table_variable(t);
  if (rows == 0 || s < 0)
    return 0.0;
  return fabs(km_table_row(t, rows - 1)[s] - km_table_row(t, 0)[s]);
}

/* Number of dead points: of a joint, of the input or output of a mechanical advantage, or of actuators whose forces
 * grow without bound. */
static double dead_point_count(const km_question *q) {
  static const char *const names[] = {"toggle", "pole", "undefined"};
  const bool zeros_count = km_question_advantage(q) != NULL; /* a zero force is no dead point */
  int count = 0;
  for (int i = 0; i < km_question_event_count(q); ++i) {
    const char *name = km_question_event_at(q, i).name;
    bool counts = zeros_count && strcmp(name, "zero") == 0;
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
      counts = counts || strcmp(name, names[k]) == 0;
    count += counts;
  }
  return count;
}

/* First of the three columns of a traced point; −1: not traced. */
static int point_column(const km_table *t, const char *name) {
  char text[512];
  snprintf(text, sizeof text, "point.%.480s.x", name);
  return km_table_find(t, text);
}

static km_vec3 point_of(const km_table *t, int column, size_t row) {
  return km_vec3_from_array(km_table_row(t, row) + column);
}

static double distance_to_piece(km_vec3 p, km_vec3 a, km_vec3 b) {
  km_vec3 along = km_vec3_sub(b, a), to = km_vec3_sub(p, a);
  double square = km_vec3_dot(along, along);
  double t = square > 0.0 ? fmin(1.0, fmax(0.0, km_vec3_dot(to, along) / square)) : 0.0;
  return km_vec3_norm(km_vec3_sub(to, km_vec3_scale(t, along)));
}

/* Root mean square √(Σ d²/n) of the distances d of the given points from the traced path. */
static double path_distance(const km_design_figure *f, const km_table *t) {
  int column = point_column(t, f->column);
  size_t rows = km_table_rows(t);
  double sum = 0.0;
  if (column < 0 || rows == 0)
    return nan("");
  for (int i = 0; i < f->point_count; ++i) {
    km_vec3 p = km_vec3_from_array(f->points + 3 * i);
    double least = km_vec3_norm(km_vec3_sub(p, point_of(t, column, 0)));
    for (size_t r = 1; r < rows; ++r)
      least = fmin(least, distance_to_piece(p, point_of(t, column, r - 1), point_of(t, column, r)));
    sum += least * least;
  }
  return sqrt(sum / f->point_count);
}

static bool is_place(const km_design_figure *f) {
  return f->kind == KM_DESIGN_WHERE_MIN || f->kind == KM_DESIGN_WHERE_MAX || f->kind == KM_DESIGN_WHERE_PEAK;
}

/* True if the figure has the unit of the table's variable. */
static bool is_of_variable(const km_design_figure *f) {
  return is_place(f) || f->kind == KM_DESIGN_REACHED || f->kind == KM_DESIGN_SETTLING;
}

static double column_figure(const km_design_figure *f, const km_table *t) {
  static const km_figure figures[] = {[KM_DESIGN_MIN] = KM_FIGURE_MIN,       [KM_DESIGN_MAX] = KM_FIGURE_MAX,
                                      [KM_DESIGN_SPAN] = KM_FIGURE_SPAN,     [KM_DESIGN_MEAN] = KM_FIGURE_MEAN,
                                      [KM_DESIGN_AT] = KM_FIGURE_AT,         [KM_DESIGN_WHERE_MIN] = KM_FIGURE_MIN,
                                      [KM_DESIGN_WHERE_MAX] = KM_FIGURE_MAX, [KM_DESIGN_RMS] = KM_FIGURE_RMS,
                                      [KM_DESIGN_PEAK] = KM_FIGURE_PEAK,     [KM_DESIGN_WHERE_PEAK] = KM_FIGURE_PEAK,
                                      [KM_DESIGN_LAST] = KM_FIGURE_LAST,     [KM_DESIGN_SETTLING] = KM_FIGURE_SETTLING};
  double value = nan(""), where = nan("");
  km_table_figure(t, f->column, figures[f->kind], f->at, &value, &where, NULL);
  return is_place(f) ? where : value;
}

/* Value of a formula of the figures before it. KM_USAGE: it can't be evaluated. */
static km_status formula_value(const km_design_question *def, int figure, const double *figures, double *value,
                               km_error *error) {
  km_formulas *formulas = km_formulas_create(NULL);
  km_error found, ignored;
  bool defined = formulas != NULL;
  for (int f = 0; f < figure && defined; ++f)
    if (!km_formulas_check_name(def->figures[f].name, &ignored))
      defined = km_formulas_define(formulas, def->figures[f].name, figures[f]);
  km_status status = defined ? km_formulas_result(formulas, def->figures[figure].column, value, &found)
                             : km_fail(&found, KM_MEMORY, "out of memory for a formula");
  km_formulas_free(formulas);
  return status ? km_fail(error, status == KM_MODEL ? KM_USAGE : status, "\"%.80s\": %s", def->figures[figure].name,
                          found.text)
                : KM_OK;
}

static double formula_figure(const km_design_question *def, int figure, const double *figures) {
  double value = nan("");
  km_error ignored;
  return formula_value(def, figure, figures, &value, &ignored) ? nan("") : value;
}

void km_design_copy_figures(const km_design_question *def, const km_question *q, double *figures) {
  const km_table *t = km_question_table(q);
  for (int f = 0; f < def->figure_count; ++f) {
    const km_design_figure *figure = &def->figures[f];
    figures[f] = figure->kind == KM_DESIGN_REACHED    ? reached_range(t)
                 : figure->kind == KM_DESIGN_TOGGLES  ? dead_point_count(q)
                 : figure->kind == KM_DESIGN_DISTANCE ? path_distance(figure, t)
                 : figure->kind == KM_DESIGN_FORMULA  ? formula_figure(def, f, figures)
                                                      : column_figure(figure, t);
  }
}

/* Reason of a missing figure in a complete answer. */
void km_design_missing_reason(const km_design_question *def, const km_question *q, const double *figures,
                              char reason[KM_DESIGN_REASON]) {
  const km_table *t = km_question_table(q);
  size_t rows = km_table_rows(t);
  int s = km_table_variable(t);
  for (int f = 0; f < def->figure_count && !reason[0]; ++f) {
    const km_design_figure *figure = &def->figures[f];
    if (!isnan(figures[f]))
      continue;
    double first = rows && s >= 0 ? km_table_row(t, 0)[s] : nan(""),
           last = rows && s >= 0 ? km_table_row(t, rows - 1)[s] : nan("");
    const char *unit = s >= 0 ? km_table_unit(t, (size_t)s) : "";
    if (figure->kind == KM_DESIGN_AT && (figure->at < fmin(first, last) || figure->at > fmax(first, last)))
      snprintf(reason, KM_DESIGN_REASON, "%.60s: %.9g %s lies beyond the range from %.9g to %.9g %s", figure->name,
               figure->at, unit, first, last, unit);
    else
      snprintf(reason, KM_DESIGN_REASON, "%.60s: %.80s has no value there", figure->name,
               figure->column ? figure->column : "the path");
  }
}

/* Step of a row: column `step` of sweeps and tracks, whose extra row at a located end has none; else the row's place at
 * the planned times, −1 for a last row between two of them, where a run stopped. */
static double step_of(const km_question *q, const km_table *t, int step, size_t row) {
  if (step >= 0)
    return km_table_row(t, row)[step];
  const int r = (int)row;
  const double time = km_table_row(t, row)[km_table_variable(t)], planned = q->kind->planned_place(q, r);
  const double interval = fabs(q->kind->planned_place(q, r ? r : 1) - q->kind->planned_place(q, r ? r - 1 : 0));
  return fabs(time - planned) <= 1e-6 * interval ? (double)r : -1.0;
}

/* Copies the bands: row r is that of step r; the extra row at a located end is skipped. */
void km_design_copy_bands(const km_design_question *def, const km_question *q, int rows, double *bands) {
  const km_table *t = km_question_table(q);
  int step = km_table_find(t, "step");
  for (int i = 0; i < def->band_count * rows; ++i)
    bands[i] = nan("");
  for (int b = 0; b < def->band_count; ++b) {
    int column = km_table_find(t, def->bands[b]);
    for (size_t r = 0; r < km_table_rows(t) && column >= 0; ++r) {
      double at = step_of(q, t, step, r);
      if (at >= 0.0 && at < rows && at == floor(at))
        bands[b * rows + (int)at] = km_table_row(t, r)[column];
    }
  }
}

static km_status no_column(const km_table *t, const char *where, const char *name, km_error *error) {
  char names[KM_NEAREST_TEXT];
  km_nearest nearest = {.wanted = name};
  for (size_t c = 0; c < km_table_columns(t); ++c)
    km_nearest_add(&nearest, km_table_name(t, c));
  return km_fail(error, KM_USAGE, "\"%.80s\": there is no column \"%.80s\"; the nearest ones are %s", where, name,
                 km_nearest_text(&nearest, names));
}

static bool needs_column(const km_design_figure *f) {
  return f->kind != KM_DESIGN_REACHED && f->kind != KM_DESIGN_TOGGLES && f->kind != KM_DESIGN_DISTANCE &&
         f->kind != KM_DESIGN_FORMULA;
}

/* Checks the formulas with figures of 1: unknown names, wrong syntax. */
static km_status check_formulas(const km_design_question *def, km_error *error) {
  double ones[KM_MAX_DESIGN_FIGURES], value;
  km_status status = KM_OK;
  for (int f = 0; f < def->figure_count && !status; ++f) {
    ones[f] = 1.0;
    if (def->figures[f].kind == KM_DESIGN_FORMULA)
      status = formula_value(def, f, ones, &value, error);
  }
  return status;
}

km_status km_design_check_figures(const km_design_question *def, const km_question *q, const char **units,
                                  km_arena *arena, km_error *error) {
  const km_table *t = km_question_table(q);
  for (int f = 0; f < def->figure_count; ++f) {
    const km_design_figure *figure = &def->figures[f];
    int column = needs_column(figure) ? km_table_find(t, figure->column) : -1;
    if (needs_column(figure) && column < 0)
      return no_column(t, figure->name, figure->column, error);
    if (figure->kind == KM_DESIGN_DISTANCE)
      column = point_column(t, figure->column);
    if (is_of_variable(figure))
      column = km_table_variable(t);
    units[f] = km_arena_string(arena, column >= 0 ? km_table_unit(t, (size_t)column) : "");
  }
  for (int b = 0; b < def->band_count; ++b)
    if (km_table_find(t, def->bands[b]) < 0)
      return no_column(t, "bands", def->bands[b], error);
  return check_formulas(def, error);
}
