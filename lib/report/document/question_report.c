/* Finds the report of each kind of question, and says in words what acts. */
#include "base/arguments.h"
#include "forces/forces.h"
#include "kmech/report.h"
#include "question/question.h"
#include "report/document/advantage_report.h"
#include "report/document/motion_report.h"
#include "report/document/statics_report.h"

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
    km_text_format(out, "; %d spring%s", forces->spring_count, forces->spring_count == 1 ? "" : "s");
}

static km_status statics_report(const km_answered *a, const km_swept *swept, const char *stopped_by, bool html,
                                km_text *out, km_error *error) {
  km_plotted_statics plotted = {*swept, km_question_statics(a->question), NULL, 0};
  km_text acting = {0};
  acting_words(a->question->m->model, km_question_forces(a->question), &acting);
  km_status status = acting.failed ? km_fail(error, KM_MEMORY, "out of memory for the report")
                                   : km_statics_report(&plotted, km_question_balance(a->question), acting.data,
                                                       stopped_by, a->header, html, out, error);
  km_text_free(&acting);
  return status;
}

km_status km_question_report(const km_answered *a, const char *stopped_by, bool html, km_text *out, km_error *error) {
  km_status status =
      km_check_given(a && a->question && a->name && stopped_by && out, "answer or place for the result", error);
  if (status)
    return status;
  km_swept swept = {a->question->m, km_question_plan(a->question), km_question_motion(a->question), a->name};
  const km_advantage_sweep *advantage = km_question_advantage(a->question);
  const km_table *table = km_question_table(a->question);
  if (!table || km_table_rows(table) == 0)
    return km_fail(error, KM_USAGE, "there is no answer to report");
  if (km_question_velocities(a->question))
    return km_motion_report(a, stopped_by, html, out, error);
  if (km_question_history(a->question))
    return km_history_report(a, stopped_by, html, out, error);
  if (km_question_statics(a->question))
    return statics_report(a, &swept, stopped_by, html, out, error);
  if (!advantage)
    return km_fail(error, KM_USAGE, "there is no report about this question");
  km_plotted_advantage plotted = {swept, advantage};
  return km_advantage_report(&plotted, &advantage->last, stopped_by, a->header, html, out, error);
}
