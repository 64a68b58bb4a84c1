/* Teams of persistent threads, mutual exclusion, and identity of threads. */
#ifndef KM_BASE_PARALLEL_H
#define KM_BASE_PARALLEL_H

#include "kmech/base.h"

/* Largest number of threads beside the caller's. */
enum { KM_MAX_THREADS = 64 };

/* Persistent threads for many small parallel loops. NULL when out of memory; loops then run on the caller's thread.
 * One caller at a time. */
typedef struct km_team km_team;
km_team *km_team_create(int jobs);
void km_team_free(km_team *team);
/* km_parallel_for on the threads of the team. */
void km_team_run(km_team *team, int count, void (*work)(void *context, int index), void *context);

/* Calls work(context) under a process-wide lock, for libraries with global data. */
void km_serially(void (*work)(void *context), void *context);

/* An address that is unique to the calling thread among all running threads. */
const void *km_thread_mark(void);

#endif
