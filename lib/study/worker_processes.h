/* Leader's side of the worker processes: sends pieces of work, receives answers. Private to study/. */
#ifndef KM_STUDY_WORKER_PROCESSES_H
#define KM_STUDY_WORKER_PROCESSES_H

#include "study/design_study.h"

typedef struct km_worker_processes km_worker_processes;

km_status km_worker_processes_check(const km_design_workers *members, km_error *error);
km_status km_worker_processes_open(km_design_study *study, const km_design_workers *members, km_worker_processes **out,
                                   km_error *error);
void km_worker_processes_close(km_worker_processes *processes);
/* Sends designs from *next on to every idle member and advances *next. Designs in the store are counted, not sent. */
km_status km_worker_processes_send(km_worker_processes *processes, int *next, int end, km_error *error);
/* Receives the answers that have arrived; `all`: waits for all pieces. */
km_status km_worker_processes_receive(km_worker_processes *processes, bool all, km_error *error);

#endif
