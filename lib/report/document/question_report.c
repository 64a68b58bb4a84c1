/* Finds the report of each kind of question. */
#include "report/document/question_report.h"
#include "base/arguments.h"
#include "forces/forces.h"
#include "kmech/report.h"
#include "question/question.h"
#include "report/document/advantage_report.h"
#include "report/document/motion_report.h"
#include "report/document/statics_report.h"
#include "report/document/sweep_report.h"
#include "report/record/words/forces_text.h"

static void add_statics(km_document_maker *k, const km_answered *a, const km_swept *swept, const char *stopped_by,
                        bool brief) {
  const km_plotted_statics plotted = {*swept, km_question_statics(a->question), NULL, 0};
  km_text acting = {0};
  km_acting_words(a->question->m->model, km_question_forces(a->question), true, &acting);
  km_statics_report_make(k, &plotted, km_question_balance(a->question), km_document_words(k, &acting, ""), stopped_by,
                         brief);
}

static void add_advantage(km_document_maker *k, const km_answered *a, const km_swept *swept, const char *stopped_by,
                          bool brief) {
  const km_plotted_advantage plotted = {*swept, km_question_advantage(a->question)};
  km_advantage_report_make(k, &plotted, &plotted.sweep->last, stopped_by, brief);
}

void km_question_report_make(km_document_maker *k, const km_answered *a, const char *stopped_by, bool brief) {
  const km_question *q = a->question;
  const km_swept swept = {q->m, km_question_plan(q), km_question_motion(q), a->name};
  if (km_question_velocities(q))
    km_motion_report_make(k, a, stopped_by, brief);
  else if (km_question_history(q))
    km_history_report_make(k, a, stopped_by, brief);
  else if (km_question_statics(q))
    add_statics(k, a, &swept, stopped_by, brief);
  else
    add_advantage(k, a, &swept, stopped_by, brief);
}

/* Title of the report about one answer. */
static const char *title_of(km_document_maker *k, const km_answered *a) {
  const km_advantage_sweep *advantage = km_question_advantage(a->question);
  if (advantage)
    return km_document_format(k, "%s: leverage of %s over %s", a->name, advantage->input.name, advantage->output.name);
  return km_document_format(k,
                            km_question_velocities(a->question) ? "%s: how it moves"
                            : km_question_statics(a->question)  ? "%s: what its actuators hold"
                            : km_question_run_def(a->question)  ? "%s: its motion over time"
                                                                : "%s: what its motion takes",
                            a->name);
}

const char *km_question_report_tool(const km_question *q) {
  return km_question_velocities(q) ? "kmob"
         : km_question_history(q)  ? "ksim"
         : km_question_statics(q)  ? "kstatic"
                                   : "kma";
}

km_status km_question_report_check(const km_answered *a, km_error *error) {
  km_status status = km_check_given(a && a->question && a->name, "answer", error);
  if (status)
    return status;
  const km_table *table = km_question_table(a->question);
  if (!table || km_table_rows(table) == 0)
    return km_fail(error, KM_USAGE, "there is no answer to report");
  if (!km_question_velocities(a->question) && !km_question_history(a->question) && !km_question_statics(a->question) &&
      !km_question_advantage(a->question))
    return km_fail(error, KM_USAGE, "there is no report about this question");
  return KM_OK;
}

km_status km_question_report(const km_answered *a, const char *stopped_by, bool html, km_text *out, km_error *error) {
  km_status status = km_check_given(stopped_by && out, "place for the result", error);
  if (!status)
    status = km_question_report_check(a, error);
  if (status)
    return status;
  km_document_maker *k = KM_NEW(km_document_maker, 1);
  if (!k)
    return km_fail(error, KM_MEMORY, "out of memory for a report");
  status = km_report_set_over(k, km_question_table(a->question), a->header ? a->header->over : NULL, error);
  if (status) {
    km_arena_free(&k->arena);
    km_free(k);
    return status;
  }
  km_question_report_make(k, a, stopped_by, false);
  return km_report_finish(k, km_report_subject(k, a->name, a->question->m->model), a->header,
                          km_question_report_tool(a->question), title_of(k, a), html, out, error);
}
