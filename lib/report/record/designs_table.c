/* Puts the main table of a study together. */
#include "report/record/designs_table.h"

#include "base/memory.h"
#include "kmech/report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ROWS = KM_DESIGNS_ROWS, MOST_COLUMNS = KM_DESIGNS_COLUMNS, CELL = KM_DESIGNS_CELL };

/* Cuts a text to a width without splitting a character; control characters become blanks. */
static void set_text(char cell[CELL], const char *text) {
  size_t size = strlen(text);
  if (size > CELL - 1)
    for (size = CELL - 1; size > 0 && ((unsigned char)text[size] & 0xC0) == 0x80;)
      --size;
  for (size_t i = 0; i < size; ++i)
    cell[i] = (unsigned char)text[i] < 0x20 ? ' ' : text[i];
  cell[size] = '\0';
}

static void set_number(char cell[CELL], double x) {
  if (isnan(x))
    snprintf(cell, CELL, "-");
  else
    snprintf(cell, CELL, "%.6g", x);
}

/* Names above their units. */
static void set_head(km_designs_table *g, int column, const char *name, const char *unit) {
  set_text(g->cells[0][column], name);
  set_text(g->cells[1][column], unit);
}

/* Design with the best value of a figure; −1 if all are equal. */
static int best_of(km_designs_table *g, const km_design_study *s, int figure, int designs) {
  const km_design_figure *f = km_design_study_figure(s, figure);
  int best = -1;
  double value = nan("");
  km_design_result r;
  for (int i = 0; i < designs && f->better; ++i) {
    km_status status = km_design_study_result(s, i, &r, NULL);
    g->failed = g->failed || status == KM_MEMORY;
    if (!status && r.outcome == KM_DESIGN_DONE && km_design_is_better(f, r.figures[figure], value)) {
      best = i;
      value = r.figures[figure];
    }
  }
  return best;
}

static void fill_row(km_designs_table *g, const km_design_study *s, const km_design_study_def *def, int design, int row,
                     const int *best) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_design_result r = {.outcome = KM_DESIGN_MISSING};
  km_text name = {0};
  int column = 0;
  if (km_design_study_values(s, design, values, NULL) || km_design_study_result(s, design, &r, NULL)) {
    g->failed = true;
    return;
  }
  km_design_label(s, def, design, &name);
  set_text(g->cells[row][column++], name.data ? name.data : "");
  g->failed = g->failed || name.failed;
  km_text_free(&name);
  for (int p = 0; p < def->parameter_count && column < MOST_COLUMNS; ++p)
    set_number(g->cells[row][column++], isnan(values[p]) ? km_design_study_base(s, p) : values[p]);
  for (int f = 0; f < km_design_study_figures(s) && column < MOST_COLUMNS; ++f, ++column) {
    char number[CELL - 2];
    set_number(g->cells[row][column], r.figures[f]);
    snprintf(number, sizeof number, "%.40s", g->cells[row][column]);
    if (best && best[f] == design)
      snprintf(g->cells[row][column], CELL, "*%s", number);
  }
}

static void fill_heads(km_designs_table *g, const km_design_study *s, const km_design_study_def *def) {
  int column = 0;
  set_head(g, column++, "design", "");
  for (int p = 0; p < def->parameter_count && column < MOST_COLUMNS; ++p)
    set_head(g, column++, def->parameters[p].name, "");
  for (int f = 0; f < km_design_study_figures(s) && column < MOST_COLUMNS; ++f)
    set_head(g, column++, km_design_study_figure(s, f)->name, km_design_study_figure_unit(s, f));
  g->columns = column;
  g->rows = 2;
}

/* Some designs, one a row. */
static void fill_designs(km_designs_table *g, const km_design_study *s, const km_design_study_def *def,
                         const int *designs, int count, bool mark) {
  int best[KM_MAX_DESIGN_FIGURES];
  for (int f = 0; f < km_design_study_figures(s); ++f) {
    best[f] = mark ? best_of(g, s, f, km_design_study_designs(s)) : -1;
    g->marked = g->marked || best[f] >= 0;
  }
  fill_heads(g, s, def);
  for (int i = 0; i < count && g->rows < MOST_ROWS; ++i)
    fill_row(g, s, def, designs[i], g->rows++, best);
}

static void fill_variants(km_designs_table *g, const km_design_study *s, const km_design_study_def *def) {
  int designs[MOST_ROWS], count = km_design_study_designs(s), shown = count < MOST_ROWS - 2 ? count : MOST_ROWS - 2;
  for (int i = 0; i < shown; ++i)
    designs[i] = i;
  fill_designs(g, s, def, designs, shown, true);
  g->left_out = count - shown;
}

/* A dozen designs of the front, both ends among them. */
static km_status fill_front(km_designs_table *g, const km_design_study *s, const km_design_study_def *def,
                            km_error *error) {
  enum { SHOWN = 12 };
  int shown[SHOWN], count = km_design_study_front(s, NULL, 0), used = 0;
  int *front = KM_NEW(int, (size_t)count + 1);
  if (!front)
    return km_fail(error, KM_MEMORY, "out of memory for a table");
  count = km_design_study_front(s, front, count);
  for (int k = 0; k < SHOWN && count > 0; ++k) {
    int design = front[k * (count - 1) / (SHOWN - 1)];
    if (!used || shown[used - 1] != design)
      shown[used++] = design;
  }
  fill_designs(g, s, def, shown, used, false);
  g->left_out = count - used;
  km_free(front);
  return KM_OK;
}

static km_status fill_optimum(km_designs_table *g, const km_design_study *s, const km_design_study_def *def,
                              km_error *error) {
  int best = km_design_study_best(s), designs[2] = {0, best};
  if (def->optimise->goal_count == 2)
    return fill_front(g, s, def, error);
  fill_designs(g, s, def, designs, km_design_study_designs(s) == 0 ? 0 : best > 0 ? 2 : 1, false);
  return g->failed ? km_fail(error, KM_MEMORY, "out of memory for a table") : KM_OK;
}

static km_status fill_statistics(km_designs_table *g, km_design_study *s, km_error *error) {
  static const char *const heads[] = {"figure", "unit", "mean", "±",    "deviation",
                                      "least",  "5 %",  "50 %", "95 %", "greatest"};
  km_status status = KM_OK;
  for (int c = 0; c < 10; ++c)
    snprintf(g->cells[0][c], CELL, "%s", heads[c]);
  g->rows = 1;
  g->columns = 10;
  for (int f = 0; f < km_design_study_figures(s) && !status && g->rows < MOST_ROWS; ++f) {
    km_design_statistics st;
    status = km_design_study_statistics(s, f, &st, error);
    if (status)
      break;
    char(*row)[CELL] = g->cells[g->rows++];
    set_text(row[0], km_design_study_figure(s, f)->name);
    set_text(row[1], km_design_study_figure_unit(s, f));
    const double numbers[] = {st.mean,         st.mean_half_width, st.deviation,    st.least,
                              st.quantiles[1], st.quantiles[3],    st.quantiles[5], st.greatest};
    for (int k = 0; k < 8; ++k)
      set_number(row[2 + k], numbers[k]);
  }
  return status;
}

km_status km_designs_table_make(km_design_study *s, const km_design_study_def *def, km_designs_table *out,
                                km_error *error) {
  *out = (km_designs_table){.rows = 0};
  if (def->optimise)
    return fill_optimum(out, s, def, error);
  if (def->sample)
    return fill_statistics(out, s, error);
  fill_variants(out, s, def);
  return out->failed ? km_fail(error, KM_MEMORY, "out of memory for a table") : KM_OK;
}

bool km_designs_are_drawn(const km_design_study_def *def) {
  return def->sample && def->sample->method != KM_SAMPLING_LIST;
}

bool km_designs_have_limits(const km_design_study *s) {
  for (int f = 0; f < km_design_study_figures(s); ++f)
    if (isfinite(km_design_study_figure(s, f)->low) || isfinite(km_design_study_figure(s, f)->high))
      return true;
  return false;
}
