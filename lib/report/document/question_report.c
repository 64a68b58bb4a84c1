/* Finds the report of each kind of question, and says in words what acts. */
#include "report/document/question_report.h"
#include "base/arguments.h"
#include "forces/forces.h"
#include "kmech/report.h"
#include "question/question.h"
#include "report/document/advantage_report.h"
#include "report/document/motion_report.h"
#include "report/document/statics_report.h"
#include "report/document/sweep_report.h"
#include "report/record/sweep_text.h"

static void load_words(const km_model *model, const km_forces *forces, int index, km_text *out) {
  const km_load *load = &forces->loads[index];
  const km_model_frame *frame = &model->frames[load->frame];
  if (index < km_model_load_count(model))
    km_text_format(out, "; %s", km_model_load_name(model, index));
  else
    km_text_format(out, "; at %s", frame->name);
  km_text_format(out, ": force (%g, %g, %g) %s on %s%s", load->force[0], load->force[1], load->force[2],
                 model->units.force->suffix, model->bodies[frame->body].name, load->turning ? ", turning with it" : "");
}

/* Forces that act on the model. */
static void acting_words(const km_model *model, const km_forces *forces, km_text *out) {
  const double g[3] = {forces->stated_gravity.x, forces->stated_gravity.y, forces->stated_gravity.z};
  km_gravity_words(model, g, out);
  for (int i = 0; i < forces->load_count; ++i)
    load_words(model, forces, i, out);
  if (forces->spring_count)
    km_text_format(out, "; %d spring%s", forces->spring_count, km_plural(forces->spring_count));
  if (forces->contact_count)
    km_text_format(out, "; %d contact%s without friction", forces->contact_count, km_plural(forces->contact_count));
}

static void add_statics(km_document_maker *k, const km_answered *a, const km_swept *swept, const char *stopped_by,
                        bool brief) {
  const km_plotted_statics plotted = {*swept, km_question_statics(a->question), NULL, 0};
  km_text acting = {0};
  acting_words(a->question->m->model, km_question_forces(a->question), &acting);
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
  km_question_report_make(k, a, stopped_by, false);
  return km_report_finish(k, km_report_subject(k, a->name, a->question->m->model), a->header,
                          km_question_report_tool(a->question), title_of(k, a), html, out, error);
}
