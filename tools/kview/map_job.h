/* A map that is computed in a thread of its own while its page goes on. */
#ifndef KVIEW_MAP_JOB_H
#define KVIEW_MAP_JOB_H

#include "kmech/space.h"

typedef struct kv_map_job kv_map_job;

/* Starts a map from the state's configuration, of which it takes a copy; def->point_name is copied. The mechanism and
 * its model must not change until kv_map_job_end. KM_MEMORY, KM_INTERNAL: no thread. */
km_status kv_map_job_start(const km_mechanism *mechanism, const km_state *state, const km_space_map_def *def,
                           kv_map_job **out, km_error *error);
/* The share that is done, 0 … 1; 1 only where the map is finished. */
double kv_map_job_done(const kv_map_job *job);
/* Cancels the map where it isn't finished. */
void kv_map_job_cancel(kv_map_job *job);
/* Waits until the map is finished or cancelled, and frees the job. KM_CANCELLED, with the finished sheets in `*map`, if
 * there are any. is_complete: the modes from which the sheets were followed are all. Free `*map` in any case. */
km_status kv_map_job_end(kv_map_job *job, km_space_map *map, bool *is_complete, km_error *error);

#endif
