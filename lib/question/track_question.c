/* Request of kind "track": an arm follows the path of a path study by one method. */
#include "base/file.h"
#include "question/question.h"

#include <math.h>
#include <string.h>

enum { STUDY, METHOD, OPTIONS };

static const km_option options[OPTIONS] = {
    {"study", KM_OPTION_FILE, "FILE", "", NULL, "The path study; its model doesn't count", 0, 0, NULL, false},
    {"method", KM_OPTION_WORD, "METHOD", "", "the study's first one", "How the arm uses its spare freedom", 0,
     KM_METHODS - 1, "greedy or lookahead or fixed or dls or gradient or dp or global", false},
};

typedef struct kind_data {
  km_study_def def;
  km_study *study; /* study of the last result */
  km_track *track;
} kind_data;

/* Reports the first error of a study's text with its position. */
static km_status first_error(km_status status, const km_messages *messages, const char *file, km_error *error) {
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, status, "%s: %s", file, km_messages_text(messages, i));
  return status;
}

/* Reads a study; CSV files are relative to the study's folder. */
static km_status read_study(const char *file, kind_data *o, km_error *error) {
  km_text text = {0}, folder = {0};
  km_messages *messages = km_messages_create();
  const char *slash = strrchr(file, '/');
  km_status status = messages ? km_file_read(file, &text, error) : KM_MEMORY;
  if (slash)
    km_text_format(&folder, "%.*s", (int)(slash - file) + 1, file);
  if (!status && folder.failed)
    status = KM_MEMORY;
  if (!status)
    status = first_error(km_study_read(text.data, text.size, folder.data ? folder.data : "", messages, &o->def, error),
                         messages, file, error);
  km_messages_free(messages);
  km_text_free(&text);
  km_text_free(&folder);
  return status == KM_MEMORY ? km_fail(error, KM_MEMORY, "out of memory for a path study") : status;
}

static km_status prepare(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *study = km_question_own_value(q, STUDY);
  o->def = km_study_def_default();
  if (!study)
    return km_fail(error, KM_USAGE, "`study` is missing; expected the file of a path study");
  return read_study(study->text, o, error);
}

static void clear_result(km_question *q) {
  kind_data *o = q->kind_data;
  km_track_free(o->track);
  km_study_free(o->study);
  o->track = NULL;
  o->study = NULL;
}

static void clear_preparation(km_question *q) {
  kind_data *o = q->kind_data;
  clear_result(q);
  km_study_def_free(&o->def);
  o->def = (km_study_def){0};
}

/* Returns the study's plan with the requested method, with the study's settings if it has them. */
static km_track_plan plan_of(const km_question *q, const kind_data *o) {
  const km_option_value *method = km_question_own_value(q, METHOD);
  km_track_plan plan = km_study_plan(o->study, 0);
  if (method) {
    plan.method = km_method_default((km_method_kind)method->whole);
    for (int i = km_study_methods(o->study) - 1; i >= 0; --i)
      if (km_study_plan(o->study, i).method.kind == (km_method_kind)method->whole)
        plan.method = km_study_plan(o->study, i).method;
  }
  plan.progress = q->progress;
  plan.context = q->context;
  return plan;
}

static km_status answer(km_question *q, km_state *s, km_error *error) {
  kind_data *o = q->kind_data;
  km_status status = km_study_bind(q->m, s, &o->def, 1, NULL, &o->study, error);
  if (status)
    return status;
  km_track_plan plan = plan_of(q, o);
  status = km_track_run(km_study_arm(o->study), &plan, &o->track, error);
  return status == KM_PARTIAL && km_track_ending(o->track).sample < 0
             ? km_fail(error, KM_NO_RESULT, "no pose of the arm within its limits reaches the path's first pose")
             : status;
}

static const km_table *table(const km_question *q) {
  return km_track_rows(((const kind_data *)q->kind_data)->track);
}

static int planned_rows(const km_question *q) {
  return km_track_samples(((const kind_data *)q->kind_data)->track);
}

/* Arc length of a sample, as far as the track goes. */
static double planned_place(const km_question *q, int row) {
  const km_table *rows = km_track_rows(((const kind_data *)q->kind_data)->track);
  return row >= 0 && (size_t)row < km_table_rows(rows) ? km_table_row(rows, (size_t)row)[km_table_find(rows, "s")]
                                                       : nan("");
}

static void end_reason(const km_question *q, km_text *out) {
  static const char *const reasons[] = {[KM_TRACK_LIMIT] = "a joint is at its limit",
                                        [KM_TRACK_RATE] = "a joint would be too fast",
                                        [KM_TRACK_SINGULAR] = "the pose is singular",
                                        [KM_TRACK_FIXED_JOINTS] = "the arm can't continue with the fixed joints",
                                        [KM_TRACK_WORKSPACE_BOUNDARY] = "the workspace ends here",
                                        [KM_TRACK_NOT_CONVERGED] = "dynamic programming needs too much work"};
  km_track_end end = km_track_ending(((const kind_data *)q->kind_data)->track);
  const char *reason = (size_t)end.stop < sizeof reasons / sizeof *reasons ? reasons[end.stop] : NULL;
  km_text_format(out, "ends at s = %.9g%s%s", end.s, reason ? ": " : "", reason ? reason : "");
}

/* A track has no events. */
static int event_count(const km_question *q) {
  (void)q;
  return 0;
}

static km_question_event event(const km_question *q, int index) {
  (void)q;
  (void)index;
  return (km_question_event){"", "", nan(""), nan("")};
}

const km_question_class km_track_question = {.name = "track",
                                             .options = options,
                                             .option_count = OPTIONS,
                                             .size = sizeof(kind_data),
                                             .prepare = prepare,
                                             .answer = answer,
                                             .table = table,
                                             .planned_rows = planned_rows,
                                             .planned_place = planned_place,
                                             .end_reason = end_reason,
                                             .event_count = event_count,
                                             .event = event,
                                             .clear_result = clear_result,
                                             .clear_preparation = clear_preparation};

const km_track *km_question_track(const km_question *q) {
  return km_question_has(q, &km_track_question) ? ((const kind_data *)q->kind_data)->track : NULL;
}
