/* Observers of the analyses. Private to the library. */
#ifndef KM_SWEEP_SWEEP_OBSERVER_H
#define KM_SWEEP_SWEEP_OBSERVER_H

#include "kmech/sweep.h"
#include "sweep/sweep.h"

/* Each function sets the observer that fills `out` in km_sweeps_run. The job has its mechanism, state and plan; the
 * other arguments are those of km_mobility_sweep_run, km_advantage_sweep_run and km_statics_sweep_run, and must stay
 * valid. */
/* `ports`: input and output of the transmission, whose columns are added; NULL: none. */
void km_mobility_sweep_open(km_sweep_job *job, const km_port *ports, km_mobility_sweep *out);
void km_advantage_sweep_open(km_sweep_job *job, const km_port *input, const km_port *output, bool transmission,
                             km_advantage_sweep *out);
void km_statics_sweep_open(km_sweep_job *job, km_forces *forces, km_statics *statics, km_statics_sweep *out);
void km_allowance_sweep_open(km_sweep_job *job, const km_fit_defaults *defaults, km_allowance_sweep *out);
/* The pairs are those of the plan. */
void km_clearance_sweep_open(km_sweep_job *job, km_clearance_sweep *out);
/* `rate` of the plan's driver, its unit per time unit, with the sense of the range. */
void km_motion_sweep_open(km_sweep_job *job, double rate, km_motion_sweep *out);
void km_motion_sweep_free(km_motion_sweep *sweep);

#endif
