/* Threads that stay, beside those of kmech/base.h. */
#ifndef KM_BASE_PARALLEL_H
#define KM_BASE_PARALLEL_H

#include "kmech/base.h"

/* So many threads are started beside the caller's at most. */
enum { KM_MAX_THREADS = 64 };

/* Threads that stay, for many small rounds of such work. NULL when out of memory (and then every round is done on the
 * caller's thread). One caller at a time. */
typedef struct km_team km_team;
km_team *km_team_create(int jobs);
void km_team_free(km_team *team);
/* km_parallel_for on the team's threads. */
void km_team_run(km_team *team, int count, void (*work)(void *context, int index), void *context);

/* Calls work(context) while no other thread is in here: for libraries that keep things for the whole process. */
void km_serially(void (*work)(void *context), void *context);

/* An address that tells the calling thread from every other that runs. */
const void *km_thread_mark(void);

#endif
