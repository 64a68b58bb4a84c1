/* Report about the answers of several models or variants to one question: which figures differ and by how much, the
 * curves that differ most over each other, then each answer briefly. */
#include "base/arguments.h"
#include "kmech/report.h"
#include "question/question.h"
#include "report/charts/sweep_strip.h"
#include "report/document/comparison/comparison_page.h"
#include "report/document/question_report.h"
#include "report/document/sweep_report.h"
#include "topology/mechanism.h"

#include <string.h>

typedef struct comparison {
  const km_answered **items; /* [count] answers with rows */
  const char **names, **stopped_by;
  int count;
  bool ordered;
  const char *over; /* quantity across the curves; NULL: the driver or the time */
} comparison;

static const char *kind_of(const comparison *c) {
  return c->ordered ? "variants" : "models";
}

static const char *x_label(km_document_maker *k, const km_answered *a) {
  const km_table *t = km_question_table(a->question);
  const km_sweep_plan *plan = km_question_plan(a->question);
  const int x = km_table_variable(t);
  if (km_question_motion(a->question) && plan->arclength <= 0.0)
    return km_document_format(k, "%s (%s)", km_model_coordinate_label(a->question->m->model, plan->coordinate),
                              km_model_coordinate_unit(a->question->m->model, plan->coordinate));
  const char *unit = x >= 0 ? km_table_unit(t, (size_t)x) : "";
  return km_question_motion(a->question) ? "arc length" : km_document_format(k, "time (%s)", unit);
}

static void add_curves(km_document_maker *k, const comparison *c, const km_compared_rows *rows) {
  km_compared_table *tables = KM_ARENA_NEW(&k->arena, km_compared_table, (size_t)c->count);
  const char *label = x_label(k, c->items[0]);
  for (int i = 0; i < c->count && tables; ++i) {
    const km_table *t = km_question_table(c->items[i]->question);
    size_t column;
    tables[i] = (km_compared_table){c->names[i], t, km_table_variable(t)};
    if (c->over && !km_report_find_over(t, c->over, &column, NULL)) {
      tables[i].x = (int)column;
      label = km_report_over_label(k, t, column);
    }
  }
  if (tables)
    km_comparison_curves_add(k, tables, c->count, c->ordered, rows, label);
}

static km_status draw_strip(void *context, km_canvas *canvas, double width, double height, km_error *error) {
  const km_plot_strip *strip = context;
  (void)height;
  (void)error;
  strip->draw(strip->context, canvas, 0, width);
  return KM_OK;
}

/* The mechanisms over each other in three configurations. */
static void add_poses(km_document_maker *k, const comparison *c) {
  km_swept *sweeps = KM_ARENA_NEW(&k->arena, km_swept, (size_t)c->count);
  km_sweep_strip *context = KM_ARENA_NEW(&k->arena, km_sweep_strip, 1);
  km_plot_strip *strip = KM_ARENA_NEW(&k->arena, km_plot_strip, 1);
  for (int i = 0; i < c->count && sweeps; ++i) {
    const km_question *q = c->items[i]->question;
    sweeps[i] = (km_swept){q->m, km_question_plan(q), km_question_motion(q), c->names[i]};
    if (!sweeps[i].motion)
      return;
  }
  if (!sweeps || !context || !strip)
    return;
  *strip = km_comparison_strip_make(sweeps, c->count, c->ordered, &k->arena, context);
  if (strip->height <= 0.0)
    return;
  km_document_heading(k, "Three configurations");
  km_document_picture(k, km_document_format(k, "the %s over each other", kind_of(c)), strip->height, draw_strip, strip);
}

/* Reasons of ranges that were cut short, and answers without rows. */
static void add_shortened(km_document_maker *k, const comparison *c, const km_comparison *all) {
  km_report_facts facts = {.rows = 0};
  km_text missing = {0};
  for (int i = 0; i < c->count; ++i)
    if (c->stopped_by[i][0])
      km_report_fact(&facts, c->names[i], c->stopped_by[i]);
  for (int i = 0; i < all->count; ++i)
    if (!all->answers[i].question || !km_question_table(all->answers[i].question) ||
        km_table_rows(km_question_table(all->answers[i].question)) == 0)
      km_text_format(&missing, "%s%s", missing.size ? ", " : "", all->answers[i].name);
  if (facts.rows) {
    km_document_heading(k, "Ended early");
    km_report_close_facts(k, &facts);
  }
  const char *names = km_document_words(k, &missing, NULL);
  if (names)
    km_document_text(k, km_document_format(k, "Without a result, and left out: %s.", names));
}

static void add_figures(km_document_maker *k, const comparison *c, const km_comparison *all) {
  km_compared_figures *figures = KM_ARENA_NEW(&k->arena, km_compared_figures, (size_t)c->count);
  for (int i = 0; i < c->count && figures; ++i)
    km_compared_list(k, c->items[i], &figures[i]);
  if (!figures)
    return;
  const km_compared_rows rows = km_compared_merge(k, figures, c->count);
  if (!rows.items)
    return;
  km_comparison_page_add(k, c->names, c->count, c->ordered ? "variant" : "model", kind_of(c), &rows);
  add_shortened(k, c, all);
  add_curves(k, c, &rows);
  add_poses(k, c);
}

/* "fourbar · SHA-256 …" where all models are from one file, else their names. */
static const char *subject_of(km_document_maker *k, const comparison *c, const char *name) {
  const km_model *first = c->items[0]->question->m->model;
  for (int i = 1; i < c->count; ++i)
    if (strcmp(c->items[i]->question->m->model->sha256, first->sha256) != 0)
      return name;
  return km_report_subject(k, name, first);
}

/* Keeps the answers that have rows. KM_USAGE: none has, kinds differ, or there is no report about them. */
static km_status choose(km_document_maker *k, const km_comparison *all, const char *const *stopped_by, const char *over,
                        comparison *out, km_error *error) {
  *out = (comparison){.items = KM_ARENA_NEW(&k->arena, const km_answered *, (size_t)all->count),
                      .names = KM_ARENA_NEW(&k->arena, const char *, (size_t)all->count),
                      .stopped_by = KM_ARENA_NEW(&k->arena, const char *, (size_t)all->count),
                      .ordered = all->ordered,
                      .over = over};
  size_t column;
  if (k->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  for (int i = 0; i < all->count; ++i) {
    const km_answered *a = &all->answers[i];
    km_status status = km_check_given(a->name != NULL, "name", error);
    if (status)
      return status;
    if (!a->question || !km_question_table(a->question) || km_table_rows(km_question_table(a->question)) == 0)
      continue;
    status = km_question_report_check(a, error);
    if (!status && out->count && a->question->kind != out->items[0]->question->kind)
      status = km_fail(error, KM_USAGE, "answers to \"%s\" and \"%s\"; expected one kind in a report",
                       out->items[0]->question->kind->name, a->question->kind->name);
    if (!status && out->over)
      status = km_report_find_over(km_question_table(a->question), out->over, &column, error);
    if (status)
      return status;
    out->items[out->count] = a;
    out->names[out->count] = a->name;
    out->stopped_by[out->count++] = stopped_by && stopped_by[i] ? stopped_by[i] : "";
  }
  return out->count ? KM_OK : km_fail(error, KM_USAGE, "there is no answer to report");
}

/* Adds all blocks. */
static km_status make(km_document_maker *k, const km_comparison *all, const char *const *stopped_by, const char *over,
                      comparison *c, km_error *error) {
  const km_status status = choose(k, all, stopped_by, over, c, error);
  if (status)
    return status;
  add_figures(k, c, all);
  for (int i = 0; i < c->count; ++i) {
    km_document_part(k, c->names[i]);
    km_question_report_make(k, c->items[i], c->stopped_by[i], true);
  }
  return KM_OK;
}

km_status km_comparison_report(const km_comparison *all, const char *name, const char *const *stopped_by,
                               const km_report_header *header, bool html, km_text *out, km_error *error) {
  km_status status = km_check_given(all && all->answers && all->count > 0 && name && out,
                                    "answer, name or place for the result", error);
  km_document_maker *k = status ? NULL : KM_NEW(km_document_maker, 1);
  comparison c;
  if (!status && !k)
    status = km_fail(error, KM_MEMORY, "out of memory for a report");
  if (!status)
    status = make(k, all, stopped_by, header ? header->over : NULL, &c, error);
  if (status) {
    if (k)
      km_arena_free(&k->arena);
    km_free(k);
    return status;
  }
  return km_report_finish(k, subject_of(k, &c, name), header, km_question_report_tool(c.items[0]->question),
                          km_document_format(k, "%s: %d %s compared", name, c.count, kind_of(&c)), html, out, error);
}
