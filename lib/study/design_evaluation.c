/* Batches of designs: what the store has is taken from there, the rest is asked by workers on several threads and put
 * into the store by the caller's thread alone. */
#include "study/design_evaluation.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static km_store_shape shape_of(const km_design_study *s, int q) {
  const km_design_question *def = &s->def->questions[q];
  return (km_store_shape){s->question_ids[q], s->def->parameter_count, def->figure_count,
                          def->band_count * s->band_rows[q]};
}

km_design_answer *km_design_answers(const km_design_study *s, km_arena *arena) {
  km_design_answer *answers = KM_ARENA_NEW(arena, km_design_answer, (size_t)s->def->question_count);
  for (int q = 0; q < s->def->question_count && answers; ++q) {
    km_store_shape shape = shape_of(s, q);
    answers[q].outcome = KM_DESIGN_MISSING;
    answers[q].figures = KM_ARENA_NEW(arena, double, (size_t)shape.figures + 1);
    answers[q].bands = shape.band_numbers ? KM_ARENA_NEW(arena, double, (size_t)shape.band_numbers) : NULL;
  }
  return arena->failed ? NULL : answers;
}

km_status km_design_look_up(const km_design_study *s, int question, const double *values, km_design_answer *out,
                            bool *found, km_error *error) {
  km_store_shape shape = shape_of(s, question);
  return km_store_get(s->store, &shape, values, out, found, error);
}

km_status km_design_put(const km_design_study *s, int question, const double *values, const km_design_answer *answer,
                        km_error *error) {
  km_store_shape shape = shape_of(s, question);
  return km_store_put(s->store, &shape, values, answer, error);
}

int km_design_band_numbers(const km_design_study *s, int question) {
  return shape_of(s, question).band_numbers;
}

void km_design_gather(const km_design_study *s, const km_design_answer *answers, km_design_result *out) {
  *out = (km_design_result){.outcome = KM_DESIGN_DONE};
  for (int f = 0; f < KM_MAX_DESIGN_FIGURES; ++f)
    out->figures[f] = nan("");
  for (int q = 0; q < s->def->question_count; ++q) {
    const km_design_answer *a = &answers[q];
    if (a->outcome > out->outcome || (a->outcome == out->outcome && !out->reason[0])) {
      out->outcome = a->outcome;
      memcpy(out->reason, a->reason, sizeof out->reason);
    }
    for (int f = 0; a->outcome != KM_DESIGN_MISSING && f < s->def->questions[q].figure_count; ++f)
      out->figures[s->first_figure[q] + f] = a->figures[f];
  }
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a study");
}

static km_status make_room(km_evaluation *b, km_error *error) {
  const km_design_study_def *def = b->study->def;
  size_t room = (size_t)b->room, jobs = (size_t)b->jobs;
  b->values = KM_ARENA_NEW(&b->arena, double, room *(size_t)(def->parameter_count + 1));
  b->wanted = KM_ARENA_NEW(&b->arena, bool, room *(size_t)def->question_count);
  b->answers = KM_ARENA_NEW(&b->arena, km_design_answer *, room);
  b->statuses = KM_ARENA_NEW(&b->arena, km_status, room);
  b->workers = KM_ARENA_NEW(&b->arena, km_design_worker *, jobs);
  b->errors = KM_ARENA_NEW(&b->arena, km_error, room);
  b->answered = KM_ARENA_NEW(&b->arena, atomic_bool, room);
  for (int i = 0; i < b->room && !b->arena.failed; ++i)
    b->answers[i] = km_design_answers(b->study, &b->arena);
  return b->arena.failed ? no_memory(error) : KM_OK;
}

km_status km_evaluation_open(km_evaluation *b, km_design_study *study, int jobs, int room, km_error *error) {
  *b = (km_evaluation){.study = study, .jobs = jobs, .room = room};
  km_status status = make_room(b, error);
  for (int i = 0; i < jobs && !status; ++i)
    status = km_design_worker_create(study, &b->workers[i], error);
  if (!status && jobs > 1)
    b->team = km_team_create(jobs);
  return status;
}

void km_evaluation_close(km_evaluation *b) {
  km_team_free(b->team);
  for (int i = 0; b->workers && i < b->jobs; ++i)
    km_design_worker_free(b->workers[i]);
  km_arena_free(&b->arena);
}

void km_evaluation_clear(km_evaluation *b) {
  b->count = 0;
}

km_status km_evaluation_add(km_evaluation *b, const double *values, km_error *error) {
  const km_design_study_def *def = b->study->def;
  int i = b->count++;
  bool *wanted = b->wanted + i * def->question_count;
  km_status status = KM_OK;
  memcpy(b->values + i * def->parameter_count, values, (size_t)def->parameter_count * sizeof *values);
  for (int q = 0; q < def->question_count && !status; ++q) {
    bool found = false;
    b->answers[i][q].outcome = KM_DESIGN_MISSING;
    if (!b->is_new)
      status = km_design_look_up(b->study, q, values, &b->answers[i][q], &found, error);
    wanted[q] = !found;
  }
  return status;
}

static bool wants(const km_evaluation *b, int i) {
  for (int q = 0; q < b->study->def->question_count; ++q)
    if (b->wanted[i * b->study->def->question_count + q])
      return true;
  return false;
}

/* Pieces that a batch has for each thread at least: of several threads none is to wait long for the others at its end. */
static int pieces_each(int jobs) {
  return jobs > 1 ? 2 : 1;
}

/* How many designs a thread takes at once: enough for the lanes, and not so many that others have nothing to do. */
static int piece_of(const km_evaluation *b) {
  int share = b->count / (pieces_each(b->jobs) * b->jobs);
  return share < 1 ? 1 : share > KM_BATCH_LANES ? KM_BATCH_LANES : share;
}

int km_batch_next_size(int size, double seconds, double target, int jobs, int most) {
  const double longest = 2.0;
  double each = fmax(seconds, 1e-6) / size, full = (double)KM_BATCH_LANES * pieces_each(jobs) * jobs;
  double wanted = fmax(target / each, fmin(full, longest / each));
  return (int)fmax(fmax(1.0, jobs), fmin(most, fmin(4.0 * size, wanted)));
}

/* A turn: pieces take the next worker that is free, one a thread. */
typedef struct turn {
  km_evaluation *batch;
  int piece; /* designs of each */
  atomic_int next;
  const void *caller; /* its thread stores what is answered, in the order of the designs; NULL: nothing is stored now */
  int stored;
  km_status status;
  km_error *error;
} turn;

static turn begin_turn(km_evaluation *b, km_error *error) {
  turn r = {.batch = b, .piece = piece_of(b), .error = error};
  atomic_init(&r.next, 0);
  for (int i = 0; i < b->count; ++i)
    atomic_init(&b->answered[i], false);
  return r;
}

static void answer(const turn *r, int worker, int first) {
  km_evaluation *b = r->batch;
  const km_design_study_def *def = b->study->def;
  int end = first + r->piece < b->count ? first + r->piece : b->count;
  km_design_task tasks[KM_BATCH_LANES];
  int of[KM_BATCH_LANES], count = 0;
  for (int i = first; i < end; ++i) {
    b->statuses[i] = KM_OK;
    if (!wants(b, i))
      continue;
    of[count] = i;
    tasks[count++] = (km_design_task){.values = b->values + i * def->parameter_count,
                                      .wanted = b->wanted + i * def->question_count,
                                      .answers = b->answers[i],
                                      .error = &b->errors[i]};
  }
  km_design_worker_answer(b->workers[worker], tasks, count);
  for (int k = 0; k < count; ++k)
    b->statuses[of[k]] = tasks[k].status;
  for (int i = first; i < end; ++i)
    atomic_store(&b->answered[i], true);
}

static km_status store_one(km_evaluation *b, int i, km_error *error) {
  const km_design_study_def *def = b->study->def;
  if (b->statuses[i])
    return km_fail(error, b->statuses[i], "%s", b->errors[i].text);
  if (!wants(b, i)) {
    b->study->found++;
    return KM_OK;
  }
  km_status status = KM_OK;
  for (int q = 0; q < def->question_count && !status; ++q)
    if (b->wanted[i * def->question_count + q])
      status = km_design_put(b->study, q, b->values + i * def->parameter_count, &b->answers[i][q], error);
  b->study->computed++;
  return status;
}

/* As far as the answers are there. */
static void store_answered(turn *r) {
  const km_evaluation *b = r->batch;
  while (!r->status && r->stored < b->count && atomic_load(&b->answered[r->stored]))
    r->status = store_one(r->batch, r->stored++, r->error);
}

static void work(void *context, int worker) {
  turn *r = context;
  bool stores = r->caller == km_thread_mark();
  for (int first = atomic_fetch_add(&r->next, r->piece); first < r->batch->count;
       first = atomic_fetch_add(&r->next, r->piece)) {
    answer(r, worker, first);
    if (stores)
      store_answered(r);
  }
}

void km_evaluation_compute(km_evaluation *b) {
  turn r = begin_turn(b, NULL);
  km_team_run(b->team, b->jobs, work, &r);
}

km_status km_evaluation_store(km_evaluation *b, km_error *error) {
  turn r = {.batch = b, .error = error};
  store_answered(&r);
  return r.status;
}

km_status km_batch_run(km_evaluation *b, km_error *error) {
  turn r = begin_turn(b, error);
  r.caller = km_thread_mark();
  km_team_run(b->team, b->jobs, work, &r);
  store_answered(&r);
  return r.status;
}

void km_evaluation_result(const km_evaluation *b, int i, km_design_result *out) {
  km_design_gather(b->study, b->answers[i], out);
}
