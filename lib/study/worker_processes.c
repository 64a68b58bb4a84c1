/* Worker processes that compute a study's designs together. The leader sends pieces: design numbers with the
 * missing requests. The answers return as bytes, and only the leader writes the store, so the result doesn't depend
 * on the distribution. */
#include "study/worker_processes.h"

#include "base/arguments.h"
#include "base/clock.h"
#include "study/design_evaluation.h"

#include <string.h>

enum { MAX_PIECE = 4096 };
static const double piece_seconds = 0.5;

/* Kind of a message: its first number. */
typedef enum message_kind { MESSAGE_PIECE, MESSAGE_END, MESSAGE_ANSWERS, MESSAGE_FAILED } message_kind;

typedef struct member {
  int size;        /* size of the next piece */
  int outstanding; /* designs in work; 0: idle */
} member;

struct km_worker_processes {
  km_design_study *study;
  const km_design_workers *members;
  member *state; /* [1 + size] */
  km_arena arena;
  km_design_answer *answers; /* work array: answers of one design */
};

km_status km_worker_processes_check(const km_design_workers *c, km_error *error) {
  km_status status =
      km_check_given(c && c->send && c->receive, "worker processes with functions to send and receive", error);
  return status || c->size >= 0 ? status
                                : km_fail(error, KM_USAGE, "found %d worker processes; expected at least 0", c->size);
}

km_status km_worker_processes_open(km_design_study *study, const km_design_workers *members, km_worker_processes **out,
                                   km_error *error) {
  km_worker_processes *c = *out = KM_NEW(km_worker_processes, 1);
  if (!c)
    return km_fail(error, KM_MEMORY, "out of memory for worker processes");
  *c = (km_worker_processes){.study = study, .members = members};
  c->state = KM_ARENA_NEW(&c->arena, member, (size_t)members->size + 1);
  c->answers = km_design_answers(study, &c->arena);
  for (int m = 1; m <= members->size && c->state; ++m)
    c->state[m].size = 1;
  return c->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for worker processes") : KM_OK;
}

void km_worker_processes_close(km_worker_processes *c) {
  if (!c)
    return;
  km_arena_free(&c->arena);
  km_free(c);
}

static void write_int(km_text *message, int number) {
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

/* Requests of a design that are missing in the store, as bits; 0: none. */
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

/* Sends a piece of designs with missing answers to a member. */
static km_status send_piece(km_worker_processes *c, int m, int *next, int end, km_error *error) {
  km_text message = {0};
  km_status status = KM_OK;
  write_int(&message, MESSAGE_PIECE);
  while (!status && *next < end && c->state[m].outstanding < c->state[m].size) {
    int wanted;
    status = find_missing(c, *next, &wanted, error);
    if (!wanted)
      c->study->found++;
    else {
      write_int(&message, *next);
      write_int(&message, wanted);
      c->state[m].outstanding++;
    }
    ++*next;
  }
  if (!status && c->state[m].outstanding)
    return send(c->members, m, &message, error);
  km_text_free(&message);
  return status;
}

km_status km_worker_processes_send(km_worker_processes *c, int *next, int end, km_error *error) {
  km_status status = KM_OK;
  for (int m = 1; m <= c->members->size && !status && *next < end; ++m)
    if (!c->state[m].outstanding)
      status = send_piece(c, m, next, end, error);
  return status;
}

/* Reader of a message. */
typedef struct message_reader {
  const char *at;
  size_t left;
  bool is_ok;
} message_reader;

static void read_bytes(message_reader *r, void *out, size_t size) {
  r->is_ok = r->is_ok && size <= r->left;
  if (!r->is_ok)
    return;
  memcpy(out, r->at, size);
  r->at += size;
  r->left -= size;
}

static int read_int(message_reader *r) {
  int number = 0;
  read_bytes(r, &number, sizeof number);
  return number;
}

static void read_answer(const km_design_study *s, int question, message_reader *r, km_design_answer *out) {
  out->outcome = (km_design_outcome)read_int(r);
  read_bytes(r, out->reason, sizeof out->reason);
  read_bytes(r, out->figures, (size_t)s->def->questions[question].figure_count * sizeof(double));
  read_bytes(r, out->bands, (size_t)km_design_band_numbers(s, question) * sizeof(double));
  out->reason[sizeof out->reason - 1] = '\0';
  r->is_ok = r->is_ok && (unsigned)out->outcome < KM_DESIGN_MISSING;
}

static void write_answer(const km_design_study *s, int question, const km_design_answer *a, km_text *message) {
  write_int(message, (int)a->outcome);
  km_text_bytes(message, a->reason, sizeof a->reason);
  km_text_bytes(message, a->figures, (size_t)s->def->questions[question].figure_count * sizeof(double));
  if (a->bands)
    km_text_bytes(message, a->bands, (size_t)km_design_band_numbers(s, question) * sizeof(double));
}

/* Stores the answers of one piece: design, requests, then each answer. */
static km_status store_answers(km_worker_processes *c, int from, message_reader *r, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS], seconds = 0.0;
  km_status status = KM_OK;
  member *m = &c->state[from];
  read_bytes(r, &seconds, sizeof seconds);
  while (!status && r->is_ok && r->left) {
    int design = read_int(r), wanted = read_int(r);
    r->is_ok = r->is_ok && design >= 0 && design < km_designs_planned(c->study);
    if (r->is_ok)
      km_design_values(c->study, design, values);
    for (int q = 0; q < c->study->def->question_count && !status && r->is_ok; ++q) {
      if (!(wanted & 1 << q))
        continue;
      read_answer(c->study, q, r, &c->answers[q]);
      if (r->is_ok)
        status = km_design_put(c->study, q, values, &c->answers[q], error);
    }
    c->study->computed++;
  }
  m->size = km_batch_next_size(m->size, seconds, piece_seconds, 1, MAX_PIECE);
  m->outstanding = 0;
  return status || r->is_ok ? status : km_fail(error, KM_IO, "rank %d sent an answer that can't be read", from);
}

static bool is_waiting(const km_worker_processes *c) {
  for (int m = 1; m <= c->members->size; ++m)
    if (c->state[m].outstanding)
      return true;
  return false;
}

km_status km_worker_processes_receive(km_worker_processes *c, bool all, km_error *error) {
  km_status status = KM_OK;
  while (!status && is_waiting(c)) {
    const void *bytes = NULL;
    size_t size = 0;
    int from = c->members->receive(c->members->context, all, &bytes, &size);
    if (from < 0)
      return all ? km_fail(error, KM_IO, "the other ranks can't be reached") : KM_OK;
    message_reader r = {bytes, size, from > 0 && from <= c->members->size};
    int what = read_int(&r);
    if (r.is_ok && what == MESSAGE_ANSWERS)
      status = store_answers(c, from, &r, error);
    else
      status = km_fail(error, KM_IO, "rank %d: %.*s", from, (int)(what == MESSAGE_FAILED ? r.left : 0), r.at);
  }
  return status;
}

void km_design_workers_stop(const km_design_workers *c) {
  if (!c || !c->send)
    return;
  int end = MESSAGE_END;
  for (int m = 1; m <= c->size; ++m)
    c->send(c->context, m, &end, sizeof end);
}

/* Computes the designs of a piece on the member's threads. */
static km_status answer_piece(km_evaluation *b, message_reader *r, km_text *reply, km_error *error) {
  const km_design_study *s = b->study;
  double values[KM_MAX_DESIGN_PARAMETERS], begin = km_clock(), seconds;
  int designs[MAX_PIECE], wanted[MAX_PIECE], questions = s->def->question_count;
  km_status status = KM_OK;
  km_evaluation_clear(b);
  while (r->is_ok && r->left && !status && b->count < MAX_PIECE) {
    int i = b->count;
    designs[i] = read_int(r);
    wanted[i] = read_int(r);
    km_design_values(s, designs[i], values);
    status = km_evaluation_add(b, values, error);
    for (int q = 0; q < questions; ++q)
      b->wanted[i * questions + q] = (wanted[i] & 1 << q) != 0;
  }
  if (!status)
    km_evaluation_compute(b);
  seconds = km_clock() - begin;
  write_int(reply, MESSAGE_ANSWERS);
  km_text_bytes(reply, &seconds, sizeof seconds);
  for (int i = 0; i < b->count && !status; ++i) {
    if (b->statuses[i])
      status = km_fail(error, b->statuses[i], "%s", b->errors[i].text);
    write_int(reply, designs[i]);
    write_int(reply, wanted[i]);
    for (int q = 0; q < questions && !status; ++q)
      if (wanted[i] & 1 << q)
        write_answer(s, q, &b->answers[i][q], reply);
  }
  return status;
}

/* Loop of a member: receives pieces, computes them, sends the answers. */
static km_status run_member_loop(km_evaluation *b, const km_design_workers *c, km_error *error) {
  for (;;) {
    const void *bytes = NULL;
    size_t size = 0;
    km_text reply = {0};
    int from = c->receive(c->context, true, &bytes, &size);
    message_reader r = {bytes, size, from == 0};
    if (read_int(&r) != MESSAGE_PIECE || !r.is_ok)
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
    status = run_member_loop(&batch, c, &found);
  km_evaluation_close(&batch);
  if (!status)
    return KM_OK;
  km_text message = {0};
  write_int(&message, MESSAGE_FAILED);
  km_text_add(&message, found.text);
  send(c, 0, &message, NULL);
  return km_fail(error, status, "%s", found.text);
}
