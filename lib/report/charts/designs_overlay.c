/* A question's answers for the designs of a study over each other. */
#include "question/question.h"
#include "report/charts/designs_plot.h"
#include "report/charts/question_plot.h"
#include "report/charts/table_plot.h"

#include <string.h>

/* The designs that are compared. */
typedef struct overlay {
  km_evaluated_design asked[KM_MAX_OVERLAID_DESIGNS];
  km_answered answers[KM_MAX_OVERLAID_DESIGNS];
  km_arena arena;
  int count;
} overlay;

static void overlay_free(overlay *v) {
  if (!v)
    return;
  for (int i = 0; i < v->count; ++i)
    km_evaluated_design_free(&v->asked[i]);
  km_arena_free(&v->arena);
  km_free(v);
}

/* Adds a design's answer, if it has one with curves. False when out of memory. */
static bool add(overlay *v, const km_designs_shown *p, int design, int question, const char *name) {
  km_evaluated_design *a = &v->asked[v->count];
  km_status status = km_design_study_evaluate(p->study, design, question, a, NULL);
  const char *kept = km_arena_string(&v->arena, name);
  if ((status != KM_OK && status != KM_PARTIAL) || km_table_rows(km_question_table(a->question)) == 0 ||
      a->question->kind->is_space) {
    km_evaluated_design_free(a);
    return status != KM_MEMORY;
  }
  v->answers[v->count++] = (km_answered){a->question, kept, NULL, 0, NULL};
  return kept != NULL;
}

static bool gather(overlay *v, const km_designs_shown *p, int question) {
  int designs = km_design_study_designs(p->study), best = km_design_study_best(p->study);
  if (p->def->optimise)
    return (designs < 1 || add(v, p, 0, question, "start")) &&
           (best < 1 || (p->only_try && v->count > 0) || add(v, p, best, question, "best"));
  bool good = true;
  int enough = p->only_try ? 1 : KM_MAX_OVERLAID_DESIGNS; /* one answer shows that there is something to draw */
  for (int i = 0; i < designs && i < KM_MAX_OVERLAID_DESIGNS && v->count < enough && good; ++i) {
    km_text name = {0};
    km_design_label(p->study, p->def, i, &name);
    good = !name.failed && add(v, p, i, question, name.data ? name.data : "");
    km_text_free(&name);
  }
  return good;
}

/* The columns that figures are taken from, each once; the distance from the limits where none has one. Returns how
 * many. */
static size_t columns_of(const km_design_question *q, const km_table *table, size_t *y) {
  size_t count = 0;
  for (int f = 0; f < q->figure_count; ++f) {
    int column = q->figures[f].column ? km_table_find(table, q->figures[f].column) : -1;
    bool known = column < 0;
    for (size_t k = 0; k < count && !known; ++k)
      known = y[k] == (size_t)column;
    if (!known)
      y[count++] = (size_t)column;
  }
  int margin = km_table_find(table, "limit_margin");
  if (count == 0 && margin >= 0)
    y[count++] = (size_t)margin;
  return count;
}

/* Builds the plot of gathered answers. KM_NO_RESULT, KM_MEMORY. */
typedef km_status (*maker)(const overlay *v, const km_designs_shown *p, int question, km_arena *arena, km_plot *out,
                           km_error *error);

static km_status made_or_no_memory(bool made, km_error *error) {
  return made ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a plot");
}

/* Columns from which figures are computed, along the path of a track or over time. */
static km_status make_columns(const overlay *v, const km_designs_shown *p, int question, km_arena *arena, km_plot *out,
                              km_error *error) {
  km_plotted_table *tables = KM_ARENA_NEW(arena, km_plotted_table, KM_MAX_OVERLAID_DESIGNS);
  size_t *columns = KM_ARENA_NEW(arena, size_t, KM_MAX_DESIGN_FIGURES);
  if (arena->failed)
    return made_or_no_memory(false, error);
  size_t count = columns_of(&p->def->questions[question], km_question_table(v->asked[0].question), columns);
  for (int i = 0; i < v->count; ++i) {
    const km_table *table = km_question_table(v->asked[i].question);
    tables[i] = (km_plotted_table){table, v->answers[i].name, (size_t)km_table_variable(table), columns};
  }
  return made_or_no_memory(km_table_plot_make(tables, (size_t)v->count, count, NULL, arena, out), error);
}

static km_status make_answers(const overlay *v, const km_designs_shown *p, int question, km_arena *arena, km_plot *out,
                              km_error *error) {
  if (!km_question_motion(v->asked[0].question))
    return make_columns(v, p, question, arena, out, error);
  km_comparison *comparison = KM_ARENA_NEW(arena, km_comparison, 1);
  if (!comparison)
    return made_or_no_memory(false, error);
  *comparison = (km_comparison){.answers = v->answers, .count = v->count, .ordered = p->def->axis_count > 0};
  return km_question_plot_make(comparison, arena, out, error);
}

static km_status make_paths(const overlay *v, const km_designs_shown *p, int question, km_arena *arena, km_plot *out,
                            km_error *error) {
  (void)p;
  (void)question;
  km_plotted_table *tables = KM_ARENA_NEW(arena, km_plotted_table, KM_MAX_OVERLAID_DESIGNS);
  size_t *y = KM_ARENA_NEW(arena, size_t, KM_MAX_OVERLAID_DESIGNS);
  for (int i = 0; i < v->count && !arena->failed; ++i) {
    const km_table *table = km_question_table(v->asked[i].question);
    km_span points = km_table_span(table, "point.");
    y[i] = points.first + 1;
    tables[i] = (km_plotted_table){table, v->answers[i].name, points.first, &y[i]};
  }
  return made_or_no_memory(!arena->failed && km_table_plot_make(tables, (size_t)v->count, 1, NULL, arena, out), error);
}

static km_status draw(const km_designs_shown *p, int question, maker make, km_text *out, km_error *error) {
  if (p->def->sample)
    return km_fail(error, KM_NO_RESULT, "the designs are a sample");
  overlay *v = KM_NEW(overlay, 1);
  km_arena arena = {0};
  km_plot plot;
  km_status status = made_or_no_memory(v && gather(v, p, question), error);
  if (!status && v->count == 0)
    status = km_fail(error, KM_NO_RESULT, "no design has an answer");
  if (!status)
    status = make(v, p, question, &arena, &plot, error);
  if (status)
    km_arena_free(&arena);
  else
    status = km_designs_finish(p, true, &plot, &arena, out, error);
  overlay_free(v);
  return status;
}

km_status km_designs_answers(const km_designs_shown *p, int question, km_text *out, km_error *error) {
  return draw(p, question, make_answers, out, error);
}

static bool traces_points(const km_design_question *q) {
  for (int i = 0; i < q->option_count; ++i)
    if (strcmp(q->options[i].name, "point") == 0)
      return true;
  return false;
}

km_status km_designs_paths(const km_designs_shown *p, int question, km_text *out, km_error *error) {
  if (!traces_points(&p->def->questions[question])) /* before any design is evaluated */
    return km_fail(error, KM_NO_RESULT, "the question traces no point");
  return draw(p, question, make_paths, out, error);
}
