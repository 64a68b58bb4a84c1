/* One thread of a study: puts a design's numbers into its model and asks the questions. */
#include "kmech/kinematics.h"
#include "model/numbers.h"
#include "study/study.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

struct km_design_worker {
  const km_design_study *study;
  km_model *model; /* that is patched; NULL: every design is read */
  km_model_numbers numbers;
  double *own; /* [numbers] of the file */
  km_mechanism *mechanism;
  km_state *state;
  km_question *questions[KM_MOST_DESIGN_QUESTIONS]; /* about the mechanism, as far as they were asked */
};

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a study");
}

void km_design_worker_free(km_design_worker *w) {
  if (!w)
    return;
  for (int q = 0; q < KM_MOST_DESIGN_QUESTIONS; ++q)
    km_question_free(w->questions[q]);
  km_state_free(w->state);
  km_mechanism_free(w->mechanism);
  km_model_numbers_free(&w->numbers);
  km_model_free(w->model);
  km_free(w->own);
  km_free(w);
}

static km_status open_model(km_design_worker *w, km_error *error) {
  const km_design_study *s = w->study;
  double values[KM_MOST_DESIGN_PARAMETERS];
  km_design_clear(s, values);
  km_read_def how = {.file = s->def->model};
  km_status status = km_model_read_as(s->bytes, s->size, &how, NULL, &w->model, error);
  if (status)
    return status;
  double unit = km_model_length_unit(w->model);
  km_model_share_length(w->model, s->length * unit / unit);
  km_model_numbers_list(w->model, &w->numbers);
  w->own = KM_NEW(double, w->numbers.count + 1);
  if (!w->own || w->numbers.failed)
    return no_memory(error);
  for (size_t i = 0; i < w->numbers.count; ++i)
    w->own[i] = *w->numbers.items[i].at;
  status = km_mechanism_compile(w->model, NULL, 0, &w->mechanism, error);
  return status ? status : km_state_create(w->mechanism, &w->state, error);
}

km_status km_design_worker_create(const km_design_study *study, km_design_worker **out, km_error *error) {
  km_design_worker *w = KM_NEW(km_design_worker, 1);
  *out = w;
  if (!w)
    return no_memory(error);
  w->study = study;
  return study->patch.works ? open_model(w, error) : KM_OK;
}

/* False: the reader would check more than a patch does. */
static bool may_patch(const km_design_worker *w, const double *values) {
  const km_design_study *s = w->study;
  for (int p = 0; p < s->def->parameter_count; ++p) {
    const km_patch_places *places = &s->patch.parameters[p];
    if (isnan(values[p]))
      continue;
    if (!(fabs(values[p]) <= 1e60))
      return false;
    for (int i = 0; i < places->count; ++i)
      if (w->numbers.items[places->places[i]].rule == KM_NUMBER_NOT_NEGATIVE && !(values[p] >= 0.0))
        return false;
  }
  return true;
}

/* Puts the values into the worker's model and mechanism. KM_PARTIAL: the design is to be read. */
static km_status patch(km_design_worker *w, const double *values) {
  const km_design_study *s = w->study;
  if (!w->model || km_design_is_reference(s, values) || !may_patch(w, values))
    return KM_PARTIAL;
  for (int p = 0; p < s->def->parameter_count; ++p) {
    const km_patch_places *places = &s->patch.parameters[p];
    for (int i = 0; i < places->count; ++i) {
      int at = places->places[i];
      *w->numbers.items[at].at = isnan(values[p]) ? w->own[at] : values[p];
    }
  }
  return km_mechanism_renumber(w->mechanism, NULL);
}

static void fail_answer(km_design_answer *a, const km_design_question *q, km_design_outcome outcome,
                        const char *reason) {
  a->outcome = outcome;
  snprintf(a->reason, sizeof a->reason, "%.*s", KM_DESIGN_REASON - 1, reason);
  for (int f = 0; f < q->figure_count; ++f)
    a->figures[f] = nan("");
}

/* Where and why an arm's track ended. */
static void tell_track(const km_track *track, km_design_answer *a) {
  static const char *const reasons[] = {
      [KM_TRACK_LIMIT] = "a joint is at its limit", [KM_TRACK_RATE] = "a joint would be too fast",
      [KM_TRACK_SINGULAR] = "the pose is singular", [KM_TRACK_HELD] = "with the held joints the arm can't go on",
      [KM_TRACK_EDGE] = "the workspace ends here",  [KM_TRACK_GAVE_OUT] = "dynamic programming gave out"};
  km_track_end end = km_track_ending(track);
  const char *reason = (size_t)end.stop < sizeof reasons / sizeof *reasons ? reasons[end.stop] : NULL;
  snprintf(a->reason, sizeof a->reason, "ends at s = %.9g%s%s", end.s, reason ? ": " : "", reason ? reason : "");
}

/* Where and why the motion ended. */
static void tell_end(const km_model *model, const km_question *q, km_design_answer *a) {
  if (km_question_track(q)) {
    tell_track(km_question_track(q), a);
    return;
  }
  const km_sweep *motion = km_question_motion(q);
  const km_sweep_plan *plan = km_question_plan(q);
  const km_statics_sweep *statics = km_question_statics(q);
  const km_reach *reach = motion->end.stop != KM_STOP_NONE ? &motion->end : &motion->start;
  const char *unit = plan->coordinate >= 0 ? km_model_coordinate_unit(model, plan->coordinate) : "";
  if (reach->stop == KM_STOP_LIMIT)
    snprintf(a->reason, sizeof a->reason, "ends at %.9g %s, the limit of %.80s", reach->position, unit,
             km_model_coordinate_label(model, reach->coordinate));
  else if (reach->stop != KM_STOP_NONE)
    snprintf(a->reason, sizeof a->reason, "ends at %.9g %s%s", reach->position, unit,
             reach->stop == KM_STOP_GAVE_OUT ? ": too many steps" : "");
  else if (statics && statics->unheld)
    snprintf(a->reason, sizeof a->reason, "the actuators can't hold %zu rows, first at %.9g %s", statics->unheld,
             statics->first_unheld, unit);
  else
    snprintf(a->reason, sizeof a->reason, "a part of the answer is missing");
}

static km_status make_question(const km_design_worker *w, int index, const km_mechanism *m, const km_model *model,
                               km_question **out, km_error *error) {
  const km_design_question *def = &w->study->def->questions[index];
  km_status status = km_question_create(m, def->kind, out, error);
  if (!status)
    status = km_design_set_options(w->study->def, def, model, *out, error);
  if (status) {
    km_question_free(*out);
    *out = NULL;
  }
  return status;
}

static void take_answer(const km_design_worker *w, int index, const km_model *model, const km_question *q,
                        km_status status, km_design_answer *a) {
  const km_design_question *def = &w->study->def->questions[index];
  a->outcome = status == KM_OK ? KM_DESIGN_DONE : KM_DESIGN_SHORT;
  a->reason[0] = '\0';
  km_design_take_figures(def, q, a->figures);
  if (a->bands)
    km_design_take_bands(def, q, w->study->band_rows[index], a->bands);
  if (status == KM_PARTIAL)
    tell_end(model, q, a);
}

/* `*q`: the question about the mechanism; made where it is NULL, and kept. */
static km_status ask(const km_design_worker *w, int index, const km_mechanism *m, const km_model *model,
                     km_state *state, km_question **q, km_design_answer *a, km_error *error) {
  const km_design_question *def = &w->study->def->questions[index];
  km_error found = {.text = ""};
  km_question_refresh(*q);
  km_status status = *q ? KM_OK : make_question(w, index, m, model, q, &found);
  if (!status)
    status = km_question_ask(*q, state, &found);
  if (status == KM_MEMORY)
    return no_memory(error);
  if (status == KM_OK || status == KM_PARTIAL)
    take_answer(w, index, model, *q, status, a);
  else
    fail_answer(a, def,
                status == KM_NO_RESULT  ? KM_DESIGN_EMPTY
                : status == KM_DIVERGED ? KM_DESIGN_GAVE_OUT
                                        : KM_DESIGN_UNASSEMBLED,
                found.text);
  return KM_OK;
}

static bool goes_on_the_spot(const km_design_worker *w, int question) {
  const km_design_question *q = &w->study->def->questions[question];
  return w->model->hold_count == 0 && q->hold_count == 0 && q->set_count == 0;
}

/* At the worker's own mechanism, where the numbers are already. */
static km_status answer_patched(km_design_worker *w, int question, km_design_answer *a, km_error *error) {
  km_error found;
  km_state_restart(w->state);
  km_status status = km_assemble(w->mechanism, w->state, NULL, &found);
  if (status == KM_MEMORY)
    return no_memory(error);
  if (status) {
    fail_answer(a, &w->study->def->questions[question], KM_DESIGN_UNASSEMBLED, found.text);
    return KM_OK;
  }
  return ask(w, question, w->mechanism, w->model, w->state, &w->questions[question], a, error);
}

/* A mechanism of its own, at the pose that holds and sets ask for. */
static km_status answer_brought(const km_design_worker *w, const km_model *model, int question, km_design_answer *a,
                                km_error *error) {
  km_mechanism *m = NULL;
  km_state *state = NULL;
  km_question *asked = NULL;
  km_error found;
  const km_design_question *q = &w->study->def->questions[question];
  km_status status = km_design_bring(model, q, &m, &state, &found);
  if (status == KM_MEMORY)
    no_memory(error);
  else if (status)
    fail_answer(a, q, status == KM_DIVERGED ? KM_DESIGN_GAVE_OUT : KM_DESIGN_UNASSEMBLED, found.text);
  if (!status)
    status = ask(w, question, m, model, state, &asked, a, error);
  else if (status != KM_MEMORY)
    status = KM_OK;
  km_question_free(asked);
  km_state_free(state);
  km_mechanism_free(m);
  return status;
}

static km_status answer_function(const km_design_worker *w, const double *values, km_design_answer *a) {
  const km_design_study_def *def = w->study->def;
  km_error found = {.text = ""};
  a->outcome = KM_DESIGN_DONE;
  a->reason[0] = '\0';
  if (def->function(def->context, values, a->figures, &found))
    fail_answer(a, &def->questions[0], KM_DESIGN_FAULTY, found.text);
  return KM_OK;
}

km_status km_design_worker_answer(km_design_worker *w, const double *values, const bool *wanted,
                                  km_design_answer *answers, km_error *error) {
  const km_design_study_def *def = w->study->def;
  if (def->function)
    return answer_function(w, values, &answers[0]);
  km_status status = patch(w, values);
  bool patched = status == KM_OK;
  km_model *model = NULL;
  km_error found;
  if (!patched && status != KM_MEMORY)
    status = km_design_read_model(w->study, values, &model, &found);
  if (status == KM_MEMORY)
    return no_memory(error);
  bool faulty = status != KM_OK;
  status = KM_OK;
  for (int q = 0; q < def->question_count && !status; ++q) {
    if (wanted && !wanted[q])
      continue;
    if (faulty)
      fail_answer(&answers[q], &def->questions[q], KM_DESIGN_FAULTY, found.text);
    else if (patched && goes_on_the_spot(w, q))
      status = answer_patched(w, q, &answers[q], error);
    else
      status = answer_brought(w, patched ? w->model : model, q, &answers[q], error);
  }
  km_model_free(model);
  return status;
}
