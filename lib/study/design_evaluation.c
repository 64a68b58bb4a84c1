/* Evaluation of batches of designs: answers in the store are reused, the others are computed by workers on several
 * threads. Only the caller's thread writes to the store, in the order of the designs. */
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

km_status km_design_put(const km_design_study *s, int question, const double *values,
                        const km_design_answer *compute_piece, km_error *error) {
  km_store_shape shape = shape_of(s, question);
  return km_store_put(s->store, &shape, values, compute_piece, error);
}

int km_design_band_numbers(const km_design_study *s, int question) {
  return shape_of(s, question).band_numbers;
}

void km_design_collect(const km_design_study *s, const km_design_answer *answers, km_design_result *out) {
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

/* Allocates the arrays of a batch. */
static km_status allocate(km_evaluation *b, km_error *error) {
  const km_design_study_def *def = b->study->def;
  size_t capacity = (size_t)b->capacity, jobs = (size_t)b->jobs;
  b->values = KM_ARENA_NEW(&b->arena, double, capacity *(size_t)(def->parameter_count + 1));
  b->wanted = KM_ARENA_NEW(&b->arena, bool, capacity *(size_t)def->question_count);
  b->answers = KM_ARENA_NEW(&b->arena, km_design_answer *, capacity);
  b->statuses = KM_ARENA_NEW(&b->arena, km_status, capacity);
  b->workers = KM_ARENA_NEW(&b->arena, km_design_worker *, jobs);
  b->errors = KM_ARENA_NEW(&b->arena, km_error, capacity);
  b->answered = KM_ARENA_NEW(&b->arena, atomic_bool, capacity);
  for (int i = 0; i < b->capacity && !b->arena.failed; ++i)
    b->answers[i] = km_design_answers(b->study, &b->arena);
  return b->arena.failed ? no_memory(error) : KM_OK;
}

km_status km_evaluation_open(km_evaluation *b, km_design_study *study, int jobs, int capacity, km_error *error) {
  *b = (km_evaluation){.study = study, .jobs = jobs, .capacity = capacity};
  km_status status = allocate(b, error);
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

static bool is_wanted(const km_evaluation *b, int i) {
  for (int q = 0; q < b->study->def->question_count; ++q)
    if (b->wanted[i * b->study->def->question_count + q])
      return true;
  return false;
}

/* Least number of pieces per thread in a batch, so that no thread waits long for the others at its end. */
static int pieces_per_thread(int jobs) {
  return jobs > 1 ? 2 : 1;
}

/* Designs of a piece: enough for the lanes, but not so many that other threads have none. */
static int piece_size(const km_evaluation *b) {
  int share = b->count / (pieces_per_thread(b->jobs) * b->jobs);
  return share < 1 ? 1 : share > KM_BATCH_LANES ? KM_BATCH_LANES : share;
}

int km_batch_next_size(int size, double seconds, double target, int jobs, int most) {
  const double longest = 2.0;
  double each = fmax(seconds, 1e-6) / size, full = (double)KM_BATCH_LANES * pieces_per_thread(jobs) * jobs;
  double wanted = fmax(target / each, fmin(full, longest / each));
  return (int)fmax(fmax(1.0, jobs), fmin(most, fmin(4.0 * size, wanted)));
}

/* Computation of a batch; each free worker takes the next piece. */
typedef struct computation {
  km_evaluation *batch;
  int piece; /* designs per piece */
  atomic_int next;
  const void *caller; /* mark of the thread that stores the answers, in the order of the designs; NULL: no storing */
  int stored;
  km_status status;
  km_error *error;
} computation;

static computation begin_computation(km_evaluation *b, km_error *error) {
  computation r = {.batch = b, .piece = piece_size(b), .error = error};
  atomic_init(&r.next, 0);
  for (int i = 0; i < b->count; ++i)
    atomic_init(&b->answered[i], false);
  return r;
}

/* Computes the missing answers of one piece by a worker. */
static void compute_piece(const computation *r, int worker, int first) {
  km_evaluation *b = r->batch;
  const km_design_study_def *def = b->study->def;
  int end = first + r->piece < b->count ? first + r->piece : b->count;
  km_design_task tasks[KM_BATCH_LANES];
  int of[KM_BATCH_LANES], count = 0;
  for (int i = first; i < end; ++i) {
    b->statuses[i] = KM_OK;
    if (!is_wanted(b, i))
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

/* Stores the new answers of one design. */
static km_status store_one(km_evaluation *b, int i, km_error *error) {
  const km_design_study_def *def = b->study->def;
  if (b->statuses[i])
    return km_fail(error, b->statuses[i], "%s", b->errors[i].text);
  if (!is_wanted(b, i)) {
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

/* Stores the answers that are complete, in order. */
static void store_answered(computation *r) {
  const km_evaluation *b = r->batch;
  while (!r->status && r->stored < b->count && atomic_load(&b->answered[r->stored]))
    r->status = store_one(r->batch, r->stored++, r->error);
}

/* Loop of a worker over the pieces; the caller's thread also stores complete answers. */
static void run_worker(void *context, int worker) {
  computation *r = context;
  bool stores = r->caller == km_thread_mark();
  for (int first = atomic_fetch_add(&r->next, r->piece); first < r->batch->count;
       first = atomic_fetch_add(&r->next, r->piece)) {
    compute_piece(r, worker, first);
    if (stores)
      store_answered(r);
  }
}

void km_evaluation_compute(km_evaluation *b) {
  computation r = begin_computation(b, NULL);
  km_team_run(b->team, b->jobs, run_worker, &r);
}

km_status km_evaluation_store(km_evaluation *b, km_error *error) {
  computation r = {.batch = b, .error = error};
  store_answered(&r);
  return r.status;
}

km_status km_batch_run(km_evaluation *b, km_error *error) {
  computation r = begin_computation(b, error);
  r.caller = km_thread_mark();
  km_team_run(b->team, b->jobs, run_worker, &r);
  store_answered(&r);
  return r.status;
}

void km_evaluation_result(const km_evaluation *b, int i, km_design_result *out) {
  km_design_collect(b->study, b->answers[i], out);
}
