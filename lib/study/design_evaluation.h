/* Answers of designs, from the store or from workers. Private to study/. */
#ifndef KM_STUDY_DESIGN_EVALUATION_H
#define KM_STUDY_DESIGN_EVALUATION_H

#include "study/design_study.h"
#include "study/result_store.h"

#include <stdatomic.h>

/* Batch of designs that are evaluated together by several threads. */
typedef struct km_evaluation {
  km_design_study *study;
  km_arena arena;
  int capacity, count;
  double *values;             /* [capacity × parameters] */
  bool *wanted;               /* [capacity × requests] true: not in the store */
  km_design_answer **answers; /* [capacity][requests] */
  km_status *statuses;        /* [capacity] */
  km_design_worker **workers; /* [jobs] */
  km_error *errors;           /* [capacity] */
  atomic_bool *answered;      /* [capacity] true: answered in this computation */
  struct km_team *team;
  int jobs;
  bool is_new; /* the store was empty at the start, so added designs aren't looked up */
} km_evaluation;

/* Opens a batch evaluation. Close it in any case. KM_MEMORY, KM_MODEL. */
km_status km_evaluation_open(km_evaluation *batch, km_design_study *study, int jobs, int capacity, km_error *error);
void km_evaluation_close(km_evaluation *batch);
/* Adds a design with its answers from the store; the capacity must suffice. */
km_status km_evaluation_add(km_evaluation *batch, const double *values, km_error *error);
/* Computes all missing answers on the batch's threads. km_evaluation_store stores them on the caller's thread. The
 * answers remain until the next add after a clear. */
void km_evaluation_compute(km_evaluation *batch);
km_status km_evaluation_store(km_evaluation *batch, km_error *error);
/* Computes and stores: the caller's thread stores answers while the others continue. */
km_status km_batch_run(km_evaluation *batch, km_error *error);
void km_evaluation_clear(km_evaluation *batch);
/* Size of the next batch, after `size` designs took `seconds`, so that it takes about `target` seconds. It can take
 * up to two seconds to fill the lanes of all `jobs` threads. The size grows at most fourfold. */
int km_batch_next_size(int size, double seconds, double target, int jobs, int most);
/* Figures of all requests of design `index` of the batch, and its worst outcome. */
void km_evaluation_result(const km_evaluation *batch, int index, km_design_result *out);
/* Collects figures and worst outcome from answers[requests]. */
void km_design_collect(const km_design_study *study, const km_design_answer *answers, km_design_result *out);

/* Puts an answer into the store. */
km_status km_design_put(const km_design_study *study, int question, const double *values,
                        const km_design_answer *answer, km_error *error);
/* Number of values in a request's bands. */
int km_design_band_numbers(const km_design_study *study, int question);
/* Looks up the answer of a request in the store; the caller's answer must be allocated. */
km_status km_design_look_up(const km_design_study *study, int question, const double *values, km_design_answer *out,
                            bool *found, km_error *error);

#endif
