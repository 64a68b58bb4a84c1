/* Processes that answer a study's designs together. A piece is some designs by number with the questions that are wanted;
 * the answers come back as bytes, and the leader alone writes the store. So nothing depends on who answered what. */
#include "study/worker_processes.h"

#include "base/arguments.h"
#include "base/clock.h"
#include "study/design_evaluation.h"

#include <string.h>

enum { MAX_PIECE = 4096 };
static const double piece_seconds = 0.5;

/* The first number of a message. */
typedef enum word { WORD_PIECE, WORD_END, WORD_ANSWERS, WORD_FAILED } word;

typedef struct member {
  int size;        /* designs of the next piece */
  int outstanding; /* designs that it answers now; 0: it has nothing to do */
} member;

struct km_worker_processes {
  km_design_study *study;
  const km_design_workers *members;
  member *state; /* [1 + size] */
  km_arena arena;
  km_design_answer *answers; /* of one design, while it is read or looked up */
};

km_status km_worker_processes_check(const km_design_workers *c, km_error *error) {
  km_status status = km_check_given(c && c->send && c->receive, "crew with its ways of sending and receiving", error);
  return status || c->size >= 0 ? status : km_fail(error, KM_USAGE, "found a crew of %d members", c->size);
}

km_status km_worker_processes_open(km_design_study *study, const km_design_workers *members, km_worker_processes **out,
                                   km_error *error) {
  km_worker_processes *c = *out = KM_NEW(km_worker_processes, 1);
  if (!c)
    return km_fail(error, KM_MEMORY, "out of memory for a crew");
  *c = (km_worker_processes){.study = study, .members = members};
  c->state = KM_ARENA_NEW(&c->arena, member, (size_t)members->size + 1);
  c->answers = km_design_answers(study, &c->arena);
  for (int m = 1; m <= members->size && c->state; ++m)
    c->state[m].size = 1;
  return c->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a crew") : KM_OK;
}

void km_worker_processes_close(km_worker_processes *c) {
  if (!c)
    return;
  km_arena_free(&c->arena);
  km_free(c);
}

static void add_whole(km_text *message, int number) {
  km_text_bytes(message, &number, sizeof number);
}

static km_status send(const km_design_workers *c, int to, km_text *message, km_error *error) {
  km_status status = KM_OK;
  if (message->failed)
    status = km_fail(error, KM_MEMORY, "out of memory for a message");
  else if (!c->send(c->context, to, message->data, message->size))
    status = km_fail(error, KM_IO, "rank %d can't be reached", to);
  km_text_free(message);
  return status;
}

/* Which questions of a design the store hasn't got, as bits; 0: it has all. */
static km_status find_missing(const km_worker_processes *c, int design, int *wanted, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  km_status status = KM_OK;
  *wanted = 0;
  km_design_values(c->study, design, values);
  for (int q = 0; q < c->study->def->question_count && !status; ++q) {
    bool found;
    status = km_design_look_up(c->study, q, values, &c->answers[q], &found, error);
    *wanted |= found ? 0 : 1 << q;
  }
  return status;
}

static km_status give_one(km_worker_processes *c, int m, int *next, int end, km_error *error) {
  km_text message = {0};
  km_status status = KM_OK;
  add_whole(&message, WORD_PIECE);
  while (!status && *next < end && c->state[m].outstanding < c->state[m].size) {
    int wanted;
    status = find_missing(c, *next, &wanted, error);
    if (!wanted)
      c->study->found++;
    else {
      add_whole(&message, *next);
      add_whole(&message, wanted);
      c->state[m].outstanding++;
    }
    ++*next;
  }
  if (!status && c->state[m].outstanding)
    return send(c->members, m, &message, error);
  km_text_free(&message);
  return status;
}

km_status km_worker_processes_give(km_worker_processes *c, int *next, int end, km_error *error) {
  km_status status = KM_OK;
  for (int m = 1; m <= c->members->size && !status && *next < end; ++m)
    if (!c->state[m].outstanding)
      status = give_one(c, m, next, end, error);
  return status;
}

/* A message that is read from its front. */
typedef struct reading {
  const char *at;
  size_t left;
  bool good;
} reading;

static void take(reading *r, void *out, size_t size) {
  r->good = r->good && size <= r->left;
  if (!r->good)
    return;
  memcpy(out, r->at, size);
  r->at += size;
  r->left -= size;
}

static int take_whole(reading *r) {
  int number = 0;
  take(r, &number, sizeof number);
  return number;
}

static void take_answer(const km_design_study *s, int question, reading *r, km_design_answer *out) {
  out->outcome = (km_design_outcome)take_whole(r);
  take(r, out->reason, sizeof out->reason);
  take(r, out->figures, (size_t)s->def->questions[question].figure_count * sizeof(double));
  take(r, out->bands, (size_t)km_design_band_numbers(s, question) * sizeof(double));
  out->reason[sizeof out->reason - 1] = '\0';
  r->good = r->good && (unsigned)out->outcome < KM_DESIGN_MISSING;
}

static void add_answer(const km_design_study *s, int question, const km_design_answer *a, km_text *message) {
  add_whole(message, (int)a->outcome);
  km_text_bytes(message, a->reason, sizeof a->reason);
  km_text_bytes(message, a->figures, (size_t)s->def->questions[question].figure_count * sizeof(double));
  if (a->bands)
    km_text_bytes(message, a->bands, (size_t)km_design_band_numbers(s, question) * sizeof(double));
}

/* The answers of one piece: design, questions, then each answer. */
static km_status store_answers(km_worker_processes *c, int from, reading *r, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS], seconds = 0.0;
  km_status status = KM_OK;
  member *m = &c->state[from];
  take(r, &seconds, sizeof seconds);
  while (!status && r->good && r->left) {
    int design = take_whole(r), wanted = take_whole(r);
    r->good = r->good && design >= 0 && design < km_designs_planned(c->study);
    if (r->good)
      km_design_values(c->study, design, values);
    for (int q = 0; q < c->study->def->question_count && !status && r->good; ++q) {
      if (!(wanted & 1 << q))
        continue;
      take_answer(c->study, q, r, &c->answers[q]);
      if (r->good)
        status = km_design_put(c->study, q, values, &c->answers[q], error);
    }
    c->study->computed++;
  }
  m->size = km_batch_next_size(m->size, seconds, piece_seconds, 1, MAX_PIECE);
  m->outstanding = 0;
  return status || r->good ? status : km_fail(error, KM_IO, "rank %d sent an answer that can't be read", from);
}

static bool is_waiting(const km_worker_processes *c) {
  for (int m = 1; m <= c->members->size; ++m)
    if (c->state[m].outstanding)
      return true;
  return false;
}

km_status km_worker_processes_take(km_worker_processes *c, bool all, km_error *error) {
  km_status status = KM_OK;
  while (!status && is_waiting(c)) {
    const void *bytes = NULL;
    size_t size = 0;
    int from = c->members->receive(c->members->context, all, &bytes, &size);
    if (from < 0)
      return all ? km_fail(error, KM_IO, "the other ranks can't be reached") : KM_OK;
    reading r = {bytes, size, from > 0 && from <= c->members->size};
    int what = take_whole(&r);
    if (r.good && what == WORD_ANSWERS)
      status = store_answers(c, from, &r, error);
    else
      status = km_fail(error, KM_IO, "rank %d: %.*s", from, (int)(what == WORD_FAILED ? r.left : 0), r.at);
  }
  return status;
}

void km_design_workers_stop(const km_design_workers *c) {
  if (!c || !c->send)
    return;
  int end = WORD_END;
  for (int m = 1; m <= c->size; ++m)
    c->send(c->context, m, &end, sizeof end);
}

/* The designs of a piece, answered on the member's threads. */
static km_status answer_piece(km_evaluation *b, reading *r, km_text *reply, km_error *error) {
  const km_design_study *s = b->study;
  double values[KM_MAX_DESIGN_PARAMETERS], begin = km_clock(), seconds;
  int designs[MAX_PIECE], wanted[MAX_PIECE], questions = s->def->question_count;
  km_status status = KM_OK;
  km_evaluation_clear(b);
  while (r->good && r->left && !status && b->count < MAX_PIECE) {
    int i = b->count;
    designs[i] = take_whole(r);
    wanted[i] = take_whole(r);
    km_design_values(s, designs[i], values);
    status = km_evaluation_add(b, values, error);
    for (int q = 0; q < questions; ++q)
      b->wanted[i * questions + q] = (wanted[i] & 1 << q) != 0;
  }
  if (!status)
    km_evaluation_compute(b);
  seconds = km_clock() - begin;
  add_whole(reply, WORD_ANSWERS);
  km_text_bytes(reply, &seconds, sizeof seconds);
  for (int i = 0; i < b->count && !status; ++i) {
    if (b->statuses[i])
      status = km_fail(error, b->statuses[i], "%s", b->errors[i].text);
    add_whole(reply, designs[i]);
    add_whole(reply, wanted[i]);
    for (int q = 0; q < questions && !status; ++q)
      if (wanted[i] & 1 << q)
        add_answer(s, q, &b->answers[i][q], reply);
  }
  return status;
}

static km_status serve(km_evaluation *b, const km_design_workers *c, km_error *error) {
  for (;;) {
    const void *bytes = NULL;
    size_t size = 0;
    km_text reply = {0};
    int from = c->receive(c->context, true, &bytes, &size);
    reading r = {bytes, size, from == 0};
    if (take_whole(&r) != WORD_PIECE || !r.good)
      return from == 0 ? KM_OK : km_fail(error, KM_IO, "the leader can't be reached");
    km_status status = answer_piece(b, &r, &reply, error);
    if (!status)
      status = send(c, 0, &reply, error);
    km_text_free(&reply);
    if (status)
      return status;
  }
}

km_status km_design_study_run_worker(km_design_study *s, int jobs, const km_design_workers *c, km_error *error) {
  km_evaluation batch = {0};
  km_error found = {.text = ""};
  km_status status = km_check_given(s != NULL, "study", error);
  if (!status)
    status = km_worker_processes_check(c, error);
  if (!status && (jobs < 1 || jobs > 1024))
    status = km_fail(error, KM_USAGE, "found %d threads; expected 1 to 1024", jobs);
  if (status)
    return status;
  status = km_evaluation_open(&batch, s, jobs, MAX_PIECE, &found);
  if (!status)
    status = serve(&batch, c, &found);
  km_evaluation_close(&batch);
  if (!status)
    return KM_OK;
  km_text message = {0};
  add_whole(&message, WORD_FAILED);
  km_text_add(&message, found.text);
  send(c, 0, &message, NULL);
  return km_fail(error, status, "%s", found.text);
}
