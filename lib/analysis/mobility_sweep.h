/* Several mobility sweeps at once. Private to analysis/. */
#ifndef KM_ANALYSIS_MOBILITY_SWEEP_H
#define KM_ANALYSIS_MOBILITY_SWEEP_H

#include "analysis/sweeper.h"
#include "kmech/mobility_sweep.h"

/* One of them: what km_mobility_sweep_run is given, and how it ended. */
typedef struct km_mobility_job {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  km_mobility_sweep *out;
  km_sweep_room *room; /* NULL: none */
  km_status status;
  km_error *error;
} km_mobility_job;

/* Up to KM_DRIVE_LANES of them, side by side: the same bits as one by one. */
void km_mobility_sweeps_run(km_mobility_job *jobs, int count);

#endif
