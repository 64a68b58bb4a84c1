/* Finds the record, the summary and the workbook of each kind of question. */
#include "kmech/report.h"

#include "base/arguments.h"
#include "question/question.h"
#include "report/record/advantage_record.h"
#include "report/record/mobility_record.h"
#include "report/record/statics_record.h"
#include "report/record/sweep_text.h"

km_value *km_question_record(const km_question *q, const km_mechanism *m, const char *stopped_by, const char *name,
                             km_arena *arena) {
  if (!q || !m || q->m != m || !stopped_by || !name || !arena)
    return NULL;
  if (km_question_mobility(q))
    return km_mobility_sweep_record(m, km_question_mobility(q), km_question_redundancies(q), stopped_by, name, arena);
  if (km_question_advantage(q))
    return km_advantage_sweep_record(m, km_question_advantage(q), stopped_by, name, arena);
  if (km_question_statics(q))
    return km_statics_sweep_record(m, km_question_statics(q), stopped_by, name, arena);
  if (km_question_velocities(q))
    return km_motion_sweep_record(m, km_question_velocities(q), stopped_by, name, arena);
  if (km_question_allowance(q))
    return km_allowance_sweep_record(m, km_question_allowance(q), stopped_by, name, arena);
  if (km_question_clearances(q))
    return km_clearance_sweep_record(m, km_question_clearances(q), stopped_by, name, arena);
  if (km_question_run_def(q))
    return km_history_record(m, km_question_run_def(q), km_question_history(q), stopped_by, name, arena);
  if (km_question_history(q))
    return km_inverse_record(m, km_question_history(q), stopped_by, name, arena);
  return NULL;
}

void km_question_print(const km_question *q, const km_mechanism *m, const char *name, km_text *out) {
  if (!q || !m || q->m != m || !name || !out)
    return;
  if (km_question_history(q)) {
    km_history_print(m, km_question_run_def(q), km_question_history(q), name, out);
    return;
  }
  const km_sweep_plan *plan = km_question_plan(q);
  if (!plan || plan->steps == 0) /* an answer at one configuration has no driver */
    return;
  if (km_question_mobility(q))
    km_mobility_sweep_print(m, plan, km_question_mobility(q), km_question_redundancies(q), name, out);
  if (km_question_velocities(q))
    km_motion_sweep_print(m, plan, km_question_velocities(q), name, out);
  if (km_question_allowance(q))
    km_allowance_sweep_print(m, plan, km_question_allowance(q), name, out);
  if (km_question_clearances(q))
    km_clearance_sweep_print(m, plan, km_question_clearances(q), name, out);
  if (km_question_advantage(q))
    km_advantage_sweep_print(m, plan, km_question_advantage(q), name, out);
  if (km_question_statics(q))
    km_statics_sweep_print(m, plan, km_question_statics(q), name, out);
}

/* Beginning of the names of the columns that the workbook's chart shows. */
static const char *curves_of(const km_question *q) {
  if (km_question_mobility(q))
    return "m.";
  if (km_question_advantage(q))
    return "ma.";
  if (km_question_velocities(q))
    return "v.";
  if (km_question_allowance(q))
    return "play.";
  if (km_question_clearances(q))
    return "clearance.";
  const bool forces = km_table_span(km_question_table(q), "f.").count > 0 && !km_question_run_def(q);
  return forces ? "f." : "q.";
}

km_status km_question_xlsx(const km_question *q, const char *sheet, km_text *out, km_error *error) {
  const km_status status = km_check_given(q && sheet && out && km_question_table(q), "question with a table", error);
  return status ? status : km_xlsx_write(km_question_table(q), sheet, curves_of(q), out, error);
}
