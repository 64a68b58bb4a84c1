/* Worker of a study (one thread): patches designs into models and computes their requests in batches. */
#include "kmech/mechanism.h"
#include "kmech/rounding.h"
#include "model/model_numbers.h"
#include "question/question.h"
#include "study/design_study.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Request of one design, with its own mechanism if joints are held or the model was read. */
typedef struct design_request {
  km_mechanism *mechanism; /* NULL: that of the slot */
  km_state *state;
  km_question *question;
} design_request;

/* Slot for one design of a batch: a model whose numbers are patched, with its mechanism, state and requests. */
typedef struct model_slot {
  km_model *model; /* NULL: not open */
  km_model_numbers numbers;
  double *own; /* [numbers] values of the file */
  km_mechanism *mechanism;
  km_state *state;
  design_request requests[KM_MAX_DESIGN_QUESTIONS]; /* [request] */
} model_slot;

struct km_design_worker {
  const km_design_study *study;
  model_slot slots[KM_BATCH_LANES]; /* opened as batches need them */
};

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a study");
}

static void close_request(design_request *v) {
  km_question_free(v->question);
  km_state_free(v->state);
  km_mechanism_free(v->mechanism);
  *v = (design_request){0};
}

static void close_slot(model_slot *at) {
  for (int q = 0; q < KM_MAX_DESIGN_QUESTIONS; ++q)
    close_request(&at->requests[q]);
  km_state_free(at->state);
  km_mechanism_free(at->mechanism);
  km_model_numbers_free(&at->numbers);
  km_model_free(at->model);
  km_free(at->own);
}

void km_design_worker_free(km_design_worker *w) {
  if (!w)
    return;
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    close_slot(&w->slots[i]);
  km_free(w);
}

/* Reads the model with the file's values and compiles its mechanism. */
static km_status open_slot(const km_design_study *s, model_slot *at, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_design_clear(s, values);
  km_read_def definition = {.file = s->def->model};
  km_status status = km_model_read_as(s->bytes, s->size, &definition, NULL, &at->model, error);
  if (!status)
    status = km_model_idealise(at->model, false, NULL, NULL, error);
  if (status)
    return status;
  double unit = km_model_length_unit(at->model);
  km_model_share_length(at->model, s->length * unit / unit);
  km_model_numbers_list(at->model, &at->numbers);
  at->own = KM_NEW(double, at->numbers.count + 1);
  if (!at->own || at->numbers.failed)
    return no_memory(error);
  for (size_t i = 0; i < at->numbers.count; ++i)
    at->own[i] = *at->numbers.items[i].at;
  status = km_mechanism_compile(at->model, NULL, 0, &at->mechanism, error);
  return status ? status : km_state_create(at->mechanism, &at->state, error);
}

km_status km_design_worker_create(const km_design_study *study, km_design_worker **out, km_error *error) {
  km_design_worker *w = KM_NEW(km_design_worker, 1);
  *out = w;
  if (!w)
    return no_memory(error);
  w->study = study;
  return study->patch.is_valid ? open_slot(study, &w->slots[0], error) : KM_OK;
}

/* False: the reader would check conditions that a patch doesn't. */
static bool can_patch(const km_design_study *s, const model_slot *at, const double *values) {
  for (int p = 0; p < s->def->parameter_count; ++p) {
    const km_patch_places *places = &s->patch.parameters[p];
    if (isnan(values[p]))
      continue;
    if (!(fabs(values[p]) <= 1e60))
      return false;
    for (int i = 0; i < places->count; ++i)
      if (at->numbers.items[places->places[i]].rule == KM_NUMBER_NOT_NEGATIVE && !(values[p] >= 0.0))
        return false;
  }
  return true;
}

/* Patches the values into the slot's model and mechanism. KM_PARTIAL: the design must be read. */
static km_status patch_slot(const km_design_study *s, model_slot *at, const double *values) {
  if (!s->patch.is_valid || km_design_is_reference(s, values))
    return KM_PARTIAL;
  if (!at->mechanism) {
    close_slot(at);
    *at = (model_slot){0};
    km_status opened = open_slot(s, at, NULL);
    if (opened)
      return opened == KM_MEMORY ? KM_MEMORY : KM_PARTIAL;
  }
  if (!can_patch(s, at, values))
    return KM_PARTIAL;
  for (int p = 0; p < s->def->parameter_count; ++p) {
    const km_patch_places *places = &s->patch.parameters[p];
    for (int i = 0; i < places->count; ++i) {
      int place = places->places[i];
      *at->numbers.items[place].at = isnan(values[p]) ? at->own[place] : values[p];
    }
  }
  return km_mechanism_renumber(at->mechanism, NULL);
}

static void fail_answer(km_design_answer *a, const km_design_question *q, km_design_outcome outcome,
                        const char *reason) {
  a->outcome = outcome;
  snprintf(a->reason, sizeof a->reason, "%.*s", KM_DESIGN_REASON - 1, reason);
  for (int f = 0; f < q->figure_count; ++f)
    a->figures[f] = nan("");
}

/* Reason and place of the end of an answer without a sweep. */
static void write_kind_reason(const km_question *q, km_design_answer *a) {
  km_text text = {0};
  q->kind->end_reason(q, &text);
  snprintf(a->reason, sizeof a->reason, "%.*s", KM_DESIGN_REASON - 1, text.data ? text.data : "");
  km_text_free(&text);
}

/* Reason and place of the end of a motion. */
static void write_end_reason(const km_model *model, const km_question *q, km_design_answer *a) {
  const km_sweep *motion = km_question_motion(q);
  if (!motion) {
    write_kind_reason(q, a);
    return;
  }
  const km_sweep_plan *plan = km_question_plan(q);
  const km_statics_sweep *statics = km_question_statics(q);
  const km_motion_end *reach = motion->end.stop != KM_STOP_NONE ? &motion->end : &motion->start;
  const char *unit = plan->coordinate >= 0 ? km_model_coordinate_unit(model, plan->coordinate) : "";
  if (reach->stop == KM_STOP_LIMIT)
    snprintf(a->reason, sizeof a->reason, "ends at %.9g %s, the limit of %.80s", reach->position, unit,
             km_model_coordinate_label(model, reach->coordinate));
  else if (reach->stop == KM_STOP_UNBOUNDED)
    snprintf(a->reason, sizeof a->reason, "ends at %.9g %s: %.80s slides away without bound", reach->position, unit,
             km_model_coordinate_label(model, reach->coordinate));
  else if (reach->stop != KM_STOP_NONE)
    snprintf(a->reason, sizeof a->reason, "ends at %.9g %s%s", reach->position, unit,
             reach->stop == KM_STOP_MAX_STEPS ? ": too many steps" : "");
  else if (statics && statics->unheld)
    snprintf(a->reason, sizeof a->reason, "the actuators can't hold %zu rows, first at %.9g %s", statics->unheld,
             statics->first_unheld, unit);
  else
    snprintf(a->reason, sizeof a->reason, "a part of the answer is missing");
}

static bool reads_reactions(const km_design_question *q) {
  bool reads = false;
  for (int f = 0; f < q->figure_count; ++f)
    reads = reads || (q->figures[f].column && strncmp(q->figures[f].column, "r.", 2) == 0);
  for (int b = 0; b < q->band_count; ++b)
    reads = reads || strncmp(q->bands[b], "r.", 2) == 0;
  return reads;
}

static bool reads_events(const km_design_question *q) {
  bool reads = false;
  for (int f = 0; f < q->figure_count; ++f)
    reads = reads || q->figures[f].kind == KM_DESIGN_TOGGLES;
  return reads;
}

/* Columns that the figures and bands read; NULL: out of memory. */
static const char **columns_read(const km_design_question *q, km_arena *arena) {
  const char **reads = KM_ARENA_NEW(arena, const char *, (size_t)(q->figure_count + q->band_count) + 1);
  int count = 0;
  for (int f = 0; f < q->figure_count && reads; ++f)
    if (q->figures[f].column && q->figures[f].kind != KM_DESIGN_FORMULA)
      reads[count++] = q->figures[f].column;
  for (int b = 0; b < q->band_count && reads; ++b)
    reads[count++] = q->bands[b];
  return reads;
}

/* Creates a request with its options and the columns that it must compute. */
static km_status create_question(const km_design_worker *w, int index, const km_mechanism *m, const km_model *model,
                                 km_question **out, km_error *error) {
  const km_design_question *def = &w->study->def->questions[index];
  km_status status = km_question_create(m, def->kind, out, error);
  if (!status)
    status = km_design_set_options(w->study->def, def, model, *out, error);
  if (!status) {
    (*out)->no_reactions = !reads_reactions(def);
    (*out)->table_only = !reads_events(def);
    (*out)->read_columns = columns_read(def, &(*out)->arena);
    status = (*out)->read_columns ? KM_OK : no_memory(error);
  }
  if (status) {
    km_question_free(*out);
    *out = NULL;
  }
  return status;
}

/* Copies figures and bands of a computed request, with the reason of an early end. */
static void copy_answer(const km_design_worker *w, int index, const km_model *model, const km_question *q,
                        km_status status, km_design_answer *a) {
  const km_design_question *def = &w->study->def->questions[index];
  a->outcome = status == KM_OK ? KM_DESIGN_DONE : KM_DESIGN_SHORT;
  a->reason[0] = '\0';
  km_design_copy_figures(def, q, a->figures);
  if (a->bands)
    km_design_copy_bands(def, q, w->study->band_rows[index], a->bands);
  if (status == KM_PARTIAL)
    write_end_reason(model, q, a);
  else
    km_design_missing_reason(def, q, a->figures, a->reason);
}

/* Request of one assembled design. */
typedef struct prepared_request {
  const km_model *model;
  const km_mechanism *mechanism;
  km_state *state;
  km_question **question; /* request of the mechanism; created if NULL, and cached */
  km_design_task *task;
} prepared_request;

/* Converts the status of a request to the outcome of its answer. */
static void store_outcome(const km_design_worker *w, int index, const prepared_request *a, km_status status,
                          const km_error *found) {
  km_design_answer *answer = &a->task->answers[index];
  if (status == KM_MEMORY)
    a->task->status = no_memory(a->task->error);
  else if (status == KM_OK || status == KM_PARTIAL)
    copy_answer(w, index, a->model, *a->question, status, answer);
  else
    fail_answer(answer, &w->study->def->questions[index],
                status == KM_NO_RESULT  ? KM_DESIGN_EMPTY
                : status == KM_DIVERGED ? KM_DESIGN_MAX_STEPS
                                        : KM_DESIGN_UNASSEMBLED,
                found->text);
}

/* Computes request `index` of several designs, as a batch if its kind allows. */
static void compute_request(const km_design_worker *w, int index, const prepared_request *designs, int count) {
  km_question *questions[KM_BATCH_LANES];
  km_state *states[KM_BATCH_LANES];
  km_status statuses[KM_BATCH_LANES];
  km_error found[KM_BATCH_LANES];
  int of[KM_BATCH_LANES], ready = 0;
  for (int i = 0; i < count; ++i) {
    const prepared_request *a = &designs[i];
    km_question_refresh(*a->question);
    km_status made =
        *a->question ? KM_OK : create_question(w, index, a->mechanism, a->model, a->question, &found[ready]);
    if (made) {
      store_outcome(w, index, a, made, &found[ready]);
      continue;
    }
    questions[ready] = *a->question;
    states[ready] = a->state;
    of[ready++] = i;
  }
  if (ready > 0)
    km_questions_compute(questions, states, ready, statuses, found);
  for (int k = 0; k < ready; ++k)
    store_outcome(w, index, &designs[of[k]], statuses[k], &found[k]);
}

/* Design under evaluation. */
typedef struct design {
  km_design_task *task;
  model_slot *at;  /* slot with its numbers; NULL: it was read */
  km_model *model; /* model that was read; NULL: invalid, see `found` */
  km_error found;
} design;

static void fail_assembly(const km_design_worker *w, int question, const design *d, km_status status,
                          const char *reason) {
  if (status == KM_MEMORY)
    d->task->status = no_memory(d->task->error);
  else
    fail_answer(&d->task->answers[question], &w->study->def->questions[question],
                status == KM_DIVERGED ? KM_DESIGN_MAX_STEPS : KM_DESIGN_UNASSEMBLED, reason);
}

/* Moves a patched design to the held and set coordinates of a request. */
static km_status move_to_start(const km_design_question *q, model_slot *at, design_request *v, km_error *error) {
  km_status status = km_design_recompile_at(at->mechanism, at->state, q, &v->mechanism, &v->state, error);
  if (status != KM_PARTIAL)
    return status;
  close_request(v);
  return km_design_recompile_at(at->mechanism, at->state, q, &v->mechanism, &v->state, error);
}

/* Prepares a request of a design. `own`: request of a design that was read. */
static km_status prepare_request(const km_design_worker *w, int question, const design *d, design_request *own,
                                 prepared_request *out, km_error *error) {
  const km_design_question *q = &w->study->def->questions[question];
  model_slot *at = d->at;
  if (!at) {
    km_status status = km_design_compile_at(d->model, q, &own->mechanism, &own->state, error);
    *out = (prepared_request){d->model, own->mechanism, own->state, &own->question, d->task};
    return status;
  }
  design_request *v = &at->requests[question];
  km_status status = move_to_start(q, at, v, error);
  *out = (prepared_request){at->model, v->mechanism ? v->mechanism : at->mechanism, v->mechanism ? v->state : at->state,
                            &v->question, d->task};
  return status;
}

/* Computes a request of all designs that need it. */
static void answer_question(const km_design_worker *w, int question, const design *designs, int count) {
  prepared_request together[KM_BATCH_LANES];
  design_request own[KM_BATCH_LANES] = {{0}};
  int ready = 0;
  for (int i = 0; i < count; ++i) {
    const design *d = &designs[i];
    km_error found;
    if (d->task->status || (d->task->wanted && !d->task->wanted[question]))
      continue;
    if (!d->at && !d->model) {
      fail_answer(&d->task->answers[question], &w->study->def->questions[question], KM_DESIGN_FAULTY, d->found.text);
      continue;
    }
    km_status status = prepare_request(w, question, d, &own[i], &together[ready], &found);
    if (status)
      fail_assembly(w, question, d, status, found.text);
    else
      ++ready;
  }
  compute_request(w, question, together, ready);
  for (int i = 0; i < count; ++i)
    close_request(&own[i]);
}

/* Evaluates the study's function. */
static km_status answer_function(const km_design_worker *w, const km_design_task *task) {
  const km_design_study_def *def = w->study->def;
  km_design_answer *a = &task->answers[0];
  km_error found = {.text = ""};
  a->outcome = KM_DESIGN_DONE;
  a->reason[0] = '\0';
  if (def->function(def->context, task->values, a->figures, &found))
    fail_answer(a, &def->questions[0], KM_DESIGN_FAULTY, found.text);
  return KM_OK;
}

/* Patches the design into a slot, or reads it. */
static void open_design(km_design_worker *w, model_slot *at, km_design_task *task, design *out) {
  *out = (design){.task = task};
  km_status status = patch_slot(w->study, at, task->values);
  if (status == KM_OK)
    out->at = at;
  else if (status != KM_MEMORY)
    status = km_design_read_model(w->study, task->values, &out->model, &out->found);
  task->status = status == KM_MEMORY ? no_memory(task->error) : KM_OK;
}

void km_design_worker_answer(km_design_worker *w, km_design_task *tasks, int count) {
  const km_design_study_def *def = w->study->def;
  design designs[KM_BATCH_LANES];
  if (def->function) {
    for (int i = 0; i < count; ++i)
      tasks[i].status = answer_function(w, &tasks[i]);
    return;
  }
  for (int i = 0; i < count; ++i)
    open_design(w, &w->slots[i], &tasks[i], &designs[i]);
  for (int q = 0; q < def->question_count; ++q)
    answer_question(w, q, designs, count);
  for (int i = 0; i < count; ++i)
    km_model_free(designs[i].model);
}
