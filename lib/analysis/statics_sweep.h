/* Sweeps of the static balance side by side. Private to analysis/. */
#ifndef KM_ANALYSIS_STATICS_SWEEP_H
#define KM_ANALYSIS_STATICS_SWEEP_H

#include "analysis/sweeper.h"
#include "kmech/statics_sweep.h"

/* One of them: what km_statics_sweep_run is given, and how it ended. */
typedef struct km_statics_job {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  km_forces *forces;
  km_statics *statics;
  km_statics_sweep *out;
  km_sweep_room *room; /* NULL: none */
  km_status status;
  km_error *error;
} km_statics_job;

/* Up to KM_DRIVE_LANES of them, side by side: the same bits as one by one. */
void km_statics_sweeps_run(km_statics_job *jobs, int count);

#endif
