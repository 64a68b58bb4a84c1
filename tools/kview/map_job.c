/* A map that is computed in a thread of its own. */
#include "kview/map_job.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static const double last_report = 0.999; /* a bar of 1 says that the thread has ended */

struct kv_map_job {
  const km_mechanism *mechanism;
  km_state *state;
  km_space_map_def def;
  char *point;
  pthread_t thread;
  _Atomic double done; /* 1: finished */
  atomic_bool is_cancelled;
  km_all_modes modes;
  km_space_map map;
  km_status status;
  km_error error;
};

static bool goes_on(void *context, double done) {
  kv_map_job *job = context;
  atomic_store(&job->done, fmin(done, last_report));
  return !atomic_load(&job->is_cancelled);
}

static void *compute(void *context) {
  kv_map_job *job = context;
  job->status =
      km_space_map_find(job->mechanism, job->state, &job->def, 1, goes_on, job, &job->modes, &job->map, &job->error);
  atomic_store(&job->done, 1.0);
  return NULL;
}

static void free_job(kv_map_job *job) {
  km_state_free(job->state);
  km_all_modes_free(&job->modes);
  km_space_map_free(&job->map);
  free(job->point);
  free(job);
}

km_status kv_map_job_start(const km_mechanism *mechanism, const km_state *state, const km_space_map_def *def,
                           kv_map_job **out, km_error *error) {
  kv_map_job *job = calloc(1, sizeof *job);
  *out = NULL;
  if (!job)
    return km_fail(error, KM_MEMORY, "out of memory for a map");
  job->mechanism = mechanism;
  job->def = *def;
  job->point = strdup(def->point_name ? def->point_name : "");
  job->def.point_name = job->point;
  km_status status = job->point ? km_state_create(mechanism, &job->state, error)
                                : km_fail(error, KM_MEMORY, "out of memory for a map");
  if (!status)
    status = km_state_assign(mechanism, job->state, state, error);
  if (!status) {
    status = pthread_create(&job->thread, NULL, compute, job) == 0
                 ? KM_OK
                 : km_fail(error, KM_INTERNAL, "the system gives no thread for a map");
  }
  if (status)
    free_job(job);
  else
    *out = job;
  return status;
}

double kv_map_job_done(const kv_map_job *job) {
  return atomic_load(&job->done);
}

void kv_map_job_cancel(kv_map_job *job) {
  atomic_store(&job->is_cancelled, true);
}

km_status kv_map_job_end(kv_map_job *job, km_space_map *map, bool *is_complete, km_error *error) {
  pthread_join(job->thread, NULL);
  km_status status = job->status;
  *map = job->map;
  *is_complete = job->modes.is_complete;
  *error = job->error;
  job->map = (km_space_map){0};
  free_job(job);
  return status;
}
