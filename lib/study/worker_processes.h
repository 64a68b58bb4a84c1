/* The leader's side of a crew: pieces of work out, answers in. Private to study/. */
#ifndef KM_STUDY_WORKER_PROCESSES_H
#define KM_STUDY_WORKER_PROCESSES_H

#include "study/design_study.h"

typedef struct km_worker_processes km_worker_processes;

km_status km_worker_processes_check(const km_design_workers *members, km_error *error);
km_status km_worker_processes_open(km_design_study *study, const km_design_workers *members, km_worker_processes **out,
                                   km_error *error);
void km_worker_processes_close(km_worker_processes *crew);
/* Gives every member that has nothing to do some designs from *next on, which moves past them; those that the store has are
 * counted, not given. */
km_status km_worker_processes_give(km_worker_processes *crew, int *next, int end, km_error *error);
/* Takes the answers that have come; `all`: waits for those of all pieces. */
km_status km_worker_processes_take(km_worker_processes *crew, bool all, km_error *error);

#endif
