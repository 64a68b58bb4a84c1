/* What a study came to, in tables for people. */
#include "report/record/designs_text.h"

#include "report/record/sweep_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ROWS = 64, MOST_COLUMNS = 24, CELL = 64, MOST_LISTED = 5 };

/* Text in columns as wide as their widest cell; the first is to the left. */
typedef struct grid {
  char cells[MOST_ROWS + 3][MOST_COLUMNS][CELL];
  int rows, columns;
} grid;

static int width_of(const char *text) {
  int width = 0;
  for (const char *c = text; *c; ++c)
    width += ((unsigned char)*c & 0xC0) != 0x80;
  return width;
}

static void grid_print(const grid *g, km_text *out) {
  int widths[MOST_COLUMNS] = {0};
  for (int r = 0; r < g->rows; ++r)
    for (int c = 0; c < g->columns; ++c)
      widths[c] = width_of(g->cells[r][c]) > widths[c] ? width_of(g->cells[r][c]) : widths[c];
  for (int r = 0; r < g->rows; ++r) {
    km_text line = {0};
    for (int c = 0; c < g->columns; ++c) {
      const char *cell = g->cells[r][c];
      km_text_format(&line, "  %*s%s%*s", c ? widths[c] - width_of(cell) : 0, "", cell,
                     c ? 0 : widths[c] - width_of(cell), "");
    }
    while (line.size && line.data[line.size - 1] == ' ')
      line.data[--line.size] = '\0';
    km_text_format(out, "%s\n", line.failed || !line.data ? "" : line.data);
    km_text_free(&line);
  }
}

static void set_number(char cell[CELL], double x) {
  if (isnan(x))
    snprintf(cell, CELL, "-");
  else
    snprintf(cell, CELL, "%.6g", x);
}

/* Names above their units. */
static void set_head(grid *g, int column, const char *name, const char *unit) {
  snprintf(g->cells[0][column], CELL, "%.*s", CELL - 1, name);
  snprintf(g->cells[1][column], CELL, "%.*s", CELL - 1, unit);
}

/* Which design has the best value of a figure; -1: none is better than another. */
static int best_of(const km_design_study *s, int figure, int designs) {
  const km_design_figure *f = km_design_study_figure(s, figure);
  int best = -1;
  double value = nan("");
  km_design_result r;
  for (int i = 0; i < designs && f->better; ++i)
    if (!km_design_study_result(s, i, &r, NULL) && r.outcome == KM_DESIGN_DONE &&
        km_design_is_better(f, r.figures[figure], value)) {
      best = i;
      value = r.figures[figure];
    }
  return best;
}

static void fill_row(grid *g, const km_design_study *s, const km_design_study_def *def, int design, int row,
                     const int *best) {
  double values[KM_MOST_DESIGN_PARAMETERS];
  km_design_result r = {.outcome = KM_DESIGN_MISSING};
  km_text name = {0};
  int column = 0;
  km_design_study_values(s, design, values, NULL);
  km_design_study_result(s, design, &r, NULL);
  km_design_label(s, def, design, &name);
  snprintf(g->cells[row][column++], CELL, "%.*s", CELL - 1, name.data ? name.data : "");
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

static void fill_heads(grid *g, const km_design_study *s, const km_design_study_def *def) {
  int column = 0;
  set_head(g, column++, "design", "");
  for (int p = 0; p < def->parameter_count && column < MOST_COLUMNS; ++p)
    set_head(g, column++, def->parameters[p].name, "");
  for (int f = 0; f < km_design_study_figures(s) && column < MOST_COLUMNS; ++f)
    set_head(g, column++, km_design_study_figure(s, f)->name, km_design_study_figure_unit(s, f));
  g->columns = column;
  g->rows = 2;
}

/* The table of some designs. */
static void print_table(const km_design_study *s, const km_design_study_def *def, const int *designs, int count,
                        bool mark, km_text *out) {
  grid *g = KM_NEW(grid, 1);
  int best[KM_MOST_DESIGN_FIGURES];
  if (!g) {
    out->failed = true;
    return;
  }
  for (int f = 0; f < km_design_study_figures(s); ++f)
    best[f] = mark ? best_of(s, f, km_design_study_designs(s)) : -1;
  fill_heads(g, s, def);
  for (int i = 0; i < count && g->rows < MOST_ROWS; ++i)
    fill_row(g, s, def, designs[i], g->rows++, best);
  grid_print(g, out);
  km_free(g);
}

static void print_outcomes(const km_design_study *s, const km_design_study_def *def, const km_design_yield *y,
                           km_text *out) {
  km_design_result r;
  for (int o = KM_DESIGN_SHORT; o < KM_DESIGN_OUTCOMES; ++o) {
    int listed = 0;
    if (!y->outcomes[o])
      continue;
    km_text_format(out, "  %s: %d\n", km_design_outcome_name((km_design_outcome)o), y->outcomes[o]);
    for (int i = 0; i < km_design_study_designs(s) && listed < MOST_LISTED && o != KM_DESIGN_MISSING; ++i) {
      if (km_design_study_result(s, i, &r, NULL) || (int)r.outcome != o)
        continue;
      km_text name = {0};
      km_design_label(s, def, i, &name);
      km_text_format(out, "    %s: %s\n", name.data ? name.data : "", r.reason);
      km_text_free(&name);
      ++listed;
    }
  }
}

static void print_variants(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  int designs[MOST_ROWS], count = km_design_study_designs(s), shown = count < MOST_ROWS - 2 ? count : MOST_ROWS - 2;
  bool marked = false;
  for (int i = 0; i < shown; ++i)
    designs[i] = i;
  print_table(s, def, designs, shown, true, out);
  for (int f = 0; f < km_design_study_figures(s); ++f)
    marked = marked || best_of(s, f, count) >= 0;
  if (marked)
    km_text_add(out, "  * the best\n");
  if (shown < count)
    km_text_format(out, "  and %d more (kstudy export)\n", count - shown);
}

static bool has_limits(const km_design_study *s) {
  for (int f = 0; f < km_design_study_figures(s); ++f)
    if (isfinite(km_design_study_figure(s, f)->low) || isfinite(km_design_study_figure(s, f)->high))
      return true;
  return false;
}

static km_status print_statistics(km_design_study *s, km_text *out, km_error *error) {
  static const char *const heads[] = {"figure", "unit", "mean", "±",    "deviation",
                                      "least",  "5 %",  "50 %", "95 %", "greatest"};
  grid *g = KM_NEW(grid, 1);
  km_status status = g ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a table");
  for (int c = 0; g && c < 10; ++c)
    snprintf(g->cells[0][c], CELL, "%s", heads[c]);
  if (g) {
    g->rows = 1;
    g->columns = 10;
  }
  for (int f = 0; f < km_design_study_figures(s) && !status && g->rows < MOST_ROWS; ++f) {
    km_design_statistics st;
    status = km_design_study_statistics(s, f, &st, error);
    if (status)
      break;
    char(*row)[CELL] = g->cells[g->rows++];
    snprintf(row[0], CELL, "%.*s", CELL - 1, km_design_study_figure(s, f)->name);
    snprintf(row[1], CELL, "%.*s", CELL - 1, km_design_study_figure_unit(s, f));
    const double numbers[] = {st.mean,         st.mean_half_width, st.deviation,    st.least,
                              st.quantiles[1], st.quantiles[3],    st.quantiles[5], st.greatest};
    for (int k = 0; k < 8; ++k)
      set_number(row[2 + k], numbers[k]);
  }
  if (!status)
    grid_print(g, out);
  km_free(g);
  return status;
}

static void print_yield(const km_design_yield *y, km_text *out) {
  km_text_format(out, "  good enough: %d of %d, %.4g %% (95 %% confidence: %.4g to %.4g %%)\n", y->good, y->count,
                 100.0 * y->share, 100.0 * y->share_low, 100.0 * y->share_high);
}

/* One row a parameter, one or two columns a figure. */
static km_status print_sensitivity(km_design_study *s, const km_design_study_def *def, km_text *out, km_error *error) {
  double first[KM_MOST_DESIGN_PARAMETERS], total[KM_MOST_DESIGN_PARAMETERS], widths[2][KM_MOST_DESIGN_PARAMETERS];
  double ranks[KM_MOST_DESIGN_PARAMETERS];
  const km_design_sample *sample = def->sample;
  for (int f = 0; f < km_design_study_figures(s); ++f) {
    km_status status = km_design_study_ranks(s, f, ranks, error);
    if (!status && sample->indices)
      status = km_design_study_indices(s, f, first, widths[0], total, widths[1], error);
    if (status)
      return status;
    km_text_format(out, "  %s depends on\n", km_design_study_figure(s, f)->name);
    for (int p = 0; p < def->parameter_count; ++p) {
      int spread = -1;
      for (int k = 0; k < sample->spread_count; ++k)
        spread = sample->spreads[k].parameter == p ? k : spread;
      if (spread < 0 && sample->method != KM_SAMPLING_LIST)
        continue;
      km_text_add(out, "    ");
      km_text_padded(def->parameters[p].name, 24, out);
      km_text_format(out, " rank correlation %6.3f", ranks[p]);
      if (sample->indices)
        km_text_format(out, "   first-order index %6.3f ± %.3f   total %6.3f ± %.3f", first[spread], widths[0][spread],
                       total[spread], widths[1][spread]);
      km_text_add(out, "\n");
    }
  }
  return KM_OK;
}

static void print_optimum(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  int best = km_design_study_best(s), designs[MOST_ROWS] = {0, best};
  if (km_design_study_designs(s) == 0)
    return;
  if (def->optimise->goal_count == 2) {
    int count = km_design_study_front(s, designs, MOST_ROWS - 2);
    km_text_format(out, "  the front: %d designs that no other betters in both goals\n", count);
    print_table(s, def, designs, count < MOST_ROWS - 2 ? count : MOST_ROWS - 2, false, out);
    return;
  }
  km_text_format(out, best < 0 ? "  no design is good enough; the start:\n" : "  the start, and the best design:\n");
  print_table(s, def, designs, best > 0 ? 2 : 1, false, out);
}

km_status km_designs_print(km_design_study *s, const km_design_study_def *def, const char *name, km_text *out,
                           km_error *error) {
  km_design_yield y;
  km_status status = km_design_study_yield(s, &y, error);
  if (status)
    return status;
  int designs = km_design_study_designs(s);
  km_text_format(out, "%s: %d design%s\n", name, designs, km_plural(designs));
  if (def->optimise)
    print_optimum(s, def, out);
  else if (def->sample)
    status = print_statistics(s, out, error);
  else
    print_variants(s, def, out);
  if (!status && def->sample)
    status = print_sensitivity(s, def, out, error);
  if (has_limits(s) && !def->optimise)
    print_yield(&y, out);
  print_outcomes(s, def, &y, out);
  return status || !out->failed ? status : km_fail(error, KM_MEMORY, "out of memory for a text");
}
