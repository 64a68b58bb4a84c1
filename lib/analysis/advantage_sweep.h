/* Sweeps of leverage side by side. Private to analysis/. */
#ifndef KM_ANALYSIS_ADVANTAGE_SWEEP_H
#define KM_ANALYSIS_ADVANTAGE_SWEEP_H

#include "analysis/sweeper.h"
#include "kmech/advantage_sweep.h"

/* One of them: what km_advantage_sweep_run is given, and how it ended. */
typedef struct km_advantage_job {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  const km_handle *input, *output;
  bool transmission;
  km_advantage_sweep *out;
  km_sweep_room *room; /* NULL: none */
  km_status status;
  km_error *error;
} km_advantage_job;

/* Up to KM_DRIVE_LANES of them, side by side: the same bits as one by one. */
void km_advantage_sweeps_run(km_advantage_job *jobs, int count);

#endif
