/* Results of a study as text tables. */
#include "base/arguments.h"
#include "kmech/report.h"

#include "report/record/designs_table.h"
#include "report/record/sweep_text.h"
#include "report/record/words/bound_text.h"

#include <math.h>

enum { MOST_LISTED = 5 };

static int width_of(const char *text) {
  int width = 0;
  for (const char *c = text; *c; ++c)
    width += ((unsigned char)*c & 0xC0) != 0x80;
  return width;
}

/* In columns as wide as their widest cell; the first is to the left. */
static void print_cells(const km_designs_table *g, km_text *out) {
  int widths[KM_DESIGNS_COLUMNS] = {0};
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
    out->failed = out->failed || line.failed;
    km_text_free(&line);
  }
}

static void print_reason(const km_design_study *s, const km_design_study_def *def, int design,
                         const km_design_result *r, km_text *out) {
  km_text name = {0};
  km_design_label(s, def, design, &name);
  km_text_format(out, "    %s: %s\n", name.data ? name.data : "", r->reason);
  out->failed = out->failed || name.failed;
  km_text_free(&name);
}

/* The first designs of an outcome; of those that are done, with a reason. */
static void print_reasons(const km_design_study *s, const km_design_study_def *def, km_design_outcome outcome,
                          km_text *out) {
  km_design_result r;
  for (int i = 0, listed = 0; i < km_design_study_designs(s) && listed < MOST_LISTED; ++i) {
    if (km_design_study_result(s, i, &r, NULL) || r.outcome != outcome || (outcome == KM_DESIGN_DONE && !r.reason[0]))
      continue;
    print_reason(s, def, i, &r, out);
    ++listed;
  }
}

/* Designs that are done, and have no value of a figure. */
static void print_valueless(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  km_design_result r;
  int count = 0;
  for (int i = 0; i < km_design_study_designs(s); ++i)
    count += !km_design_study_result(s, i, &r, NULL) && r.outcome == KM_DESIGN_DONE && r.reason[0];
  if (count == 0)
    return;
  km_text_format(out, "  done, but without a value: %d\n", count);
  print_reasons(s, def, KM_DESIGN_DONE, out);
}

/* True if every evaluated design has a value of every figure. */
static bool all_valued(km_design_study *s, const km_design_yield *y) {
  km_design_statistics st;
  for (int f = 0; f < km_design_study_figures(s); ++f)
    if (!km_design_study_statistics(s, f, &st, NULL) && st.count < y->outcomes[KM_DESIGN_DONE])
      return false;
  return true;
}

static void print_outcomes(const km_design_study *s, const km_design_study_def *def, const km_design_yield *y,
                           km_text *out) {
  for (int o = KM_DESIGN_SHORT; o < KM_DESIGN_OUTCOMES; ++o) {
    if (!y->outcomes[o])
      continue;
    km_text_format(out, "  %s: %d\n", km_design_outcome_name((km_design_outcome)o), y->outcomes[o]);
    if (o != KM_DESIGN_MISSING)
      print_reasons(s, def, (km_design_outcome)o, out);
  }
}

/* Confidence intervals need a random sample. */
static void print_yield(const km_design_yield *y, bool drawn, km_text *out) {
  km_text_format(out, "  good enough: %d of %d, %.4g %%", y->good, y->count, 100.0 * y->share);
  if (drawn)
    km_text_format(out, " (95 %% confidence: %.4g to %.4g %%)", 100.0 * y->share_low, 100.0 * y->share_high);
  km_text_add(out, "\n");
}

/* Reason why a figure has no sensitivity; NULL if it has one. */
static const char *why_none(const km_design_statistics *st) {
  return st->count == 0              ? "no design has a value of it"
         : st->count == 1            ? "only one design has a value of it"
         : st->least == st->greatest ? "all designs have the same value of it"
                                     : NULL;
}

static void print_correlation(double correlation, km_text *out) {
  if (isnan(correlation))
    km_text_add(out, " no rank correlation: its value doesn't change");
  else
    km_text_format(out, " rank correlation %6.3f", correlation);
}

static void print_indices(double first, double first_width, double total, double total_width, km_text *out) {
  if (isnan(first))
    km_text_add(out, "   no index: fewer than two rows of the sample have values");
  else
    km_text_format(out, "   first-order index %6.3f ± %.3f   total %6.3f ± %.3f", first, first_width, total,
                   total_width);
}

/* One row a parameter, one or two columns a figure. */
static km_status print_sensitivity(km_design_study *s, const km_design_study_def *def, km_text *out, km_error *error) {
  double first[KM_MAX_DESIGN_PARAMETERS], total[KM_MAX_DESIGN_PARAMETERS], widths[2][KM_MAX_DESIGN_PARAMETERS];
  double ranks[KM_MAX_DESIGN_PARAMETERS];
  const km_design_sample *sample = def->sample;
  for (int f = 0; f < km_design_study_figures(s); ++f) {
    km_design_statistics st;
    km_status status = km_design_study_statistics(s, f, &st, error);
    if (!status && why_none(&st)) {
      km_text_format(out, "  what %s depends on isn't told: %s\n", km_design_study_figure(s, f)->name, why_none(&st));
      continue;
    }
    if (!status)
      status = km_design_study_ranks(s, f, ranks, error);
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
      print_correlation(ranks[p], out);
      if (sample->indices)
        print_indices(first[spread], widths[0][spread], total[spread], widths[1][spread], out);
      km_text_add(out, "\n");
    }
  }
  return KM_OK;
}

/* Title of the table. */
static void print_heading(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  if (!def->optimise || km_design_study_designs(s) == 0)
    return;
  if (def->optimise->goal_count == 2)
    km_text_format(out, "  the front: %d designs that no other betters in both goals\n",
                   km_design_study_front(s, NULL, 0));
  else
    km_text_add(out, km_design_study_best(s) < 0 ? "  no design is good enough; the start:\n"
                                                 : "  the start, and the best design:\n");
}

static void print_bounds(const km_design_study *s, const km_design_study_def *def, km_text *out) {
  km_text words = {0};
  km_designs_bound_words(s, def, &words);
  if (words.size)
    km_text_format(out, "  %s\n", words.data);
  out->failed = out->failed || words.failed;
  km_text_free(&words);
}

static km_status print_main(km_design_study *s, const km_design_study_def *def, km_text *out, km_error *error) {
  km_designs_table *g = KM_NEW(km_designs_table, 1);
  km_status status =
      g ? km_designs_table_make(s, def, g, error) : km_fail(error, KM_MEMORY, "out of memory for a table");
  if (!status) {
    print_heading(s, def, out);
    print_cells(g, out);
    km_text_add(out, g->marked ? "  * the best\n" : "");
    print_bounds(s, def, out);
    if (g->left_out > 0)
      km_text_format(out, "  and %d more (kstudy export)\n", g->left_out);
  }
  km_free(g);
  return status;
}

km_status km_designs_print(km_design_study *s, const km_design_study_def *def, const char *name, km_text *out,
                           km_error *error) {
  km_design_yield y;
  km_status status = km_check_given(s && def && name && out, "study, name or place for the result", error);
  if (!status)
    status = km_design_study_yield(s, &y, error);
  if (status)
    return status;
  int designs = km_design_study_designs(s);
  km_text_format(out, "%s: %d design%s\n", name, designs, km_plural(designs));
  status = print_main(s, def, out, error);
  if (!status && def->sample)
    status = print_sensitivity(s, def, out, error);
  if (km_designs_have_limits(s) && !def->optimise)
    print_yield(&y, km_designs_are_drawn(def), out);
  print_outcomes(s, def, &y, out);
  if (!all_valued(s, &y))
    print_valueless(s, def, out);
  return status || !out->failed ? status : km_fail(error, KM_MEMORY, "out of memory for a text");
}
