/* Answers from the store, and from workers where it has none. Private to study/. */
#ifndef KM_STUDY_DESIGN_EVALUATION_H
#define KM_STUDY_DESIGN_EVALUATION_H

#include "study/design_study.h"
#include "study/result_store.h"

#include <stdatomic.h>

/* Some designs that are asked together, each on one of several threads. */
typedef struct km_evaluation {
  km_design_study *study;
  km_arena arena;
  int room, count;
  double *values;             /* [room × parameters] */
  bool *wanted;               /* [room × questions] the store hasn't got it */
  km_design_answer **answers; /* [room][questions] */
  km_status *statuses;        /* [room] */
  km_design_worker **workers; /* [jobs] */
  km_error *errors;           /* [room] */
  atomic_bool *answered;      /* [room] in this turn */
  struct km_team *team;
  int jobs;
  bool is_new; /* the store has had nothing to begin with, and isn't asked for designs that are added */
} km_evaluation;

/* Free in any case. KM_MEMORY, KM_MODEL. */
km_status km_evaluation_open(km_evaluation *batch, km_design_study *study, int jobs, int room, km_error *error);
void km_evaluation_close(km_evaluation *batch);
/* Adds a design, with what the store knows of it; there must be room. */
km_status km_evaluation_add(km_evaluation *batch, const double *values, km_error *error);
/* Asks what is wanted of all, on the batch's threads; and stores it, on the caller's. The answers stay until the next add
 * after a clear. */
void km_evaluation_compute(km_evaluation *batch);
km_status km_evaluation_store(km_evaluation *batch, km_error *error);
/* Both, so that the caller stores what is answered while the others go on. */
km_status km_batch_run(km_evaluation *batch, km_error *error);
void km_evaluation_clear(km_evaluation *batch);
/* After a batch of `size` designs that took so many seconds: how many the next one takes, so that it takes about `target`
 * seconds; and longer where that is too short to fill the lanes of all `jobs` threads, but not more than two seconds. Four
 * times as many at most. */
int km_batch_next_size(int size, double seconds, double target, int jobs, int most);
/* The figures of all questions of design i of the batch, and its worst outcome. */
void km_evaluation_result(const km_evaluation *batch, int index, km_design_result *out);
/* The same of any answers [questions]. */
void km_design_gather(const km_design_study *study, const km_design_answer *answers, km_design_result *out);

/* Puts an answer into the store, whoever gave it. */
km_status km_design_put(const km_design_study *study, int question, const double *values,
                        const km_design_answer *answer, km_error *error);
/* How many numbers a question's bands have. */
int km_design_band_numbers(const km_design_study *study, int question);
/* What the store has of a question; the caller's answer has room. */
km_status km_design_look_up(const km_design_study *study, int question, const double *values, km_design_answer *out,
                            bool *found, km_error *error);

#endif
