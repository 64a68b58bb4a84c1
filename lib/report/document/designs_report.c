/* The report of a study of designs. */
#include "base/arguments.h"
#include "kmech/report.h"

#include "report/charts/designs_plot.h"
#include "report/document/sweep_report.h"
#include "report/record/designs_table.h"
#include "report/record/words/bound_text.h"

#include <math.h>
#include <string.h>

enum { MOST_FACTS = 40, MOST_FIGURES_SHOWN = 3 };

typedef struct facts {
  const char *cells[2 * MOST_FACTS];
  size_t rows;
} facts;

static void add(facts *f, const char *name, const char *what) {
  if (f->rows == MOST_FACTS || !what)
    return;
  f->cells[2 * f->rows] = name;
  f->cells[2 * f->rows++ + 1] = what;
}

/* The answer in one sentence. */
static const char *lead_of(km_document_maker *m, const km_design_study *s, const km_design_study_def *def,
                           const km_design_yield *y) {
  const km_design_optimise *o = def->optimise;
  int best = km_design_study_best(s);
  km_design_result r;
  if (o && o->goal_count == 2)
    return km_document_format(m, "%d of %d designs lie on the front of %s and %s.", km_design_study_front(s, NULL, 0),
                              y->count, o->goals[0].figure, o->goals[1].figure);
  if (o && best < 0)
    return "No design is good enough.";
  if (o) {
    int figure = 0;
    while (strcmp(km_design_study_figure(s, figure)->name, o->goals[0].figure) != 0)
      ++figure;
    km_design_study_result(s, best, &r, NULL);
    km_text bounds = {0};
    km_designs_bound_words(s, def, &bounds);
    const char *words = km_document_words(m, &bounds, "");
    return km_document_format(m, "The best of %d designs has %s %.6g %s%s%s.", y->count, o->goals[0].figure,
                              r.figures[figure], km_design_study_figure_unit(s, figure), words[0] ? "; " : "", words);
  }
  if (!km_designs_have_limits(s))
    return km_document_format(m, "%d of %d designs have a full answer.", y->outcomes[KM_DESIGN_DONE], y->count);
  if (!km_designs_are_drawn(def))
    return km_document_format(m, "%d of %d designs are good enough.", y->good, y->count);
  return km_document_format(m, "%d of %d designs are good enough, %.4g %% (95 %% confidence: %.4g to %.4g %%).",
                            y->good, y->count, 100.0 * y->share, 100.0 * y->share_low, 100.0 * y->share_high);
}

static void add_table(km_document_maker *m, const km_designs_table *t) {
  const char **cells = KM_ARENA_NEW(&m->arena, const char *, (size_t)(t->rows * t->columns) + 1);
  size_t count = 0;
  for (int r = 0; r < t->rows && cells; ++r)
    for (int c = 0; c < t->columns; ++c)
      cells[count++] = km_arena_string(&m->arena, t->cells[r][c]);
  if (count && !m->arena.failed)
    km_document_cells(m, KM_BLOCK_TABLE, cells, (size_t)t->rows, (size_t)t->columns);
}

static void add_outcomes(km_document_maker *m, const km_design_yield *y, facts *f) {
  for (int o = 0; o < KM_DESIGN_OUTCOMES; ++o)
    if (y->outcomes[o])
      add(f, km_design_outcome_name((km_design_outcome)o),
          km_document_format(m, "%d design%s", y->outcomes[o], y->outcomes[o] == 1 ? "" : "s"));
}

static const char *limits_of(km_document_maker *m, const km_design_figure *figure, const char *unit) {
  if (isinf(figure->low))
    return km_document_format(m, "at most %g %s", figure->high, unit);
  return isinf(figure->high) ? km_document_format(m, "at least %g %s", figure->low, unit)
                             : km_document_format(m, "%g to %g %s", figure->low, figure->high, unit);
}

static void add_limits(km_document_maker *m, const km_design_study *s, facts *f) {
  for (int i = 0; i < km_design_study_figures(s); ++i) {
    const km_design_figure *figure = km_design_study_figure(s, i);
    if (isfinite(figure->low) || isfinite(figure->high))
      add(f, km_document_format(m, "limits of %s", figure->name),
          limits_of(m, figure, km_design_study_figure_unit(s, i)));
  }
}

static void add_facts(km_document_maker *m, const km_design_study *s, const km_design_study_def *def,
                      const km_design_yield *y) {
  facts *f = KM_ARENA_NEW(&m->arena, facts, 1);
  if (!f)
    return;
  for (int p = 0; p < def->parameter_count; ++p)
    add(f, def->parameters[p].name, def->parameters[p].path);
  for (int q = 0; q < def->question_count; ++q)
    add(f, "question",
        km_document_format(m, "%s (%s)", def->questions[q].name,
                           def->questions[q].kind ? def->questions[q].kind : "function"));
  add_limits(m, s, f);
  add_outcomes(m, y, f);
  km_document_cells(m, KM_BLOCK_FACTS, f->cells, f->rows, 2);
}

static km_status draw_shown(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  km_designs_shown picture = *(const km_designs_shown *)context;
  picture.canvas = canvas;
  picture.width = width;
  picture.height = height;
  return km_designs_draw(&picture, NULL, error);
}

/* Left out where there is nothing to draw. */
static void show(km_document_maker *m, const km_designs_shown *what, const char *shows, double height) {
  km_designs_shown *kept = KM_ARENA_NEW(&m->arena, km_designs_shown, 1);
  if (!kept)
    return;
  *kept = *what;
  kept->only_try = true;
  km_status status = km_designs_draw(kept, NULL, NULL);
  kept->only_try = false;
  m->arena.failed = m->arena.failed || status == KM_MEMORY;
  if (!status)
    km_document_picture(m, shows, height, draw_shown, kept);
}

static void add_pictures(km_document_maker *m, km_design_study *s, const km_design_study_def *def, const char *name) {
  km_designs_shown what = {.study = s, .def = def, .name = name};
  const km_design_optimise *o = def->optimise;
  if (o) {
    what.plot = o->goal_count == 2 ? KM_DESIGNS_FRONT : KM_DESIGNS_PROGRESS;
    show(m, &what, o->goal_count == 2 ? "both goals of all designs, and the front" : "the way to the best design", 260);
  }
  for (int q = 0; q < def->question_count; ++q) {
    const char *question = def->questions[q].name;
    what.index = q;
    what.plot = KM_DESIGNS_ANSWERS;
    show(m, &what, km_document_format(m, "%s, of the designs over each other", question), 300);
    what.plot = KM_DESIGNS_PATHS;
    show(m, &what, km_document_format(m, "the paths of %s over each other", question), 300);
  }
  for (int f = 0; def->sample && f < km_design_study_figures(s) && f < MOST_FIGURES_SHOWN; ++f) {
    const char *figure = km_design_study_figure(s, f)->name;
    what.index = f;
    what.plot = KM_DESIGNS_HISTOGRAM;
    show(m, &what, km_document_format(m, "how often %s has which value", figure), 230);
    what.plot = KM_DESIGNS_SCATTER;
    show(m, &what, km_document_format(m, "%s over the parameters", figure), 300);
  }
  what.plot = KM_DESIGNS_BANDS;
  for (int q = 0; q < def->question_count; ++q)
    for (int b = 0; b < def->questions[q].band_count && b < MOST_FIGURES_SHOWN; ++b) {
      what.index = q;
      what.band = b;
      show(m, &what, km_document_format(m, "quantiles of %s along the motion", def->questions[q].bands[b]), 300);
    }
}

static km_status make(km_document_maker *m, km_design_study *s, const km_design_study_def *def, km_designs_table *table,
                      const char *name, km_error *error) {
  km_design_yield y;
  km_status status = km_design_study_yield(s, &y, error);
  if (!status)
    status = km_designs_table_make(s, def, table, error);
  if (status)
    return status;
  km_document_lead(m, lead_of(m, s, def, &y));
  km_document_heading(m, def->sample ? "Figures of merit" : "Designs");
  add_table(m, table);
  if (table->marked)
    km_document_text(m, "* the best of its column");
  km_document_heading(m, "Curves");
  add_pictures(m, s, def, name);
  if (m->count && m->blocks[m->count - 1].kind == KM_BLOCK_HEADING)
    --m->count; /* there is nothing to draw */
  km_document_heading(m, "What was asked");
  add_facts(m, s, def, &y);
  return m->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the report") : KM_OK;
}

km_status km_designs_report(km_design_study *s, const km_design_study_def *def, const char *name,
                            const km_report_header *header, bool html, km_text *out, km_error *error) {
  km_status given = km_check_given(s && def && name && out, "study, name or place for the result", error);
  if (given)
    return given;
  km_document_maker *m = KM_NEW(km_document_maker, 1);
  km_designs_table *table = KM_NEW(km_designs_table, 1);
  km_status status =
      m && table ? make(m, s, def, table, name, error) : km_fail(error, KM_MEMORY, "out of memory for the report");
  if (!status)
    status = km_report_finish(m, name, header, "kstudy", name, html, out, error);
  else if (m) {
    km_arena_free(&m->arena);
    km_free(m);
  }
  km_free(table);
  return status;
}
