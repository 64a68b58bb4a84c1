/* A driven sweep between two rows. Private to driver_sweep.c and batch_sweep.c. */
#ifndef KM_SWEEP_DRIVER_SWEEP_H
#define KM_SWEEP_DRIVER_SWEEP_H

#include "sweep/sweep.h"

/* A driven motion, and whether it is away from the row for a probe. */
typedef struct km_probing_driver {
  km_driver_motion *motion;
  bool is_probing;
} km_probing_driver;

/* Progress of one driven sweep. */
typedef struct km_driver_sweep {
  km_sweeper *r;
  km_sweep_job *job;
  km_probing_driver at;
  int step, row; /* next step of the plan (step 0 leads to the first row), next row of the table */
  double last;
  int crossings; /* branch points that the motion had crossed at the last row */
  bool is_finished;
} km_driver_sweep;

/* Returns the driver's value at a step of the plan, from 1 on. */
static inline double km_driver_sweep_value(const km_sweep_plan *plan, int step) {
  return step == plan->steps ? plan->to : plan->from + (plan->to - plan->from) * step / plan->steps;
}

/* Prepares the sweeper for the observer at the reached configuration, batched or single. */
void km_driver_sweep_prepare(km_driver_sweep *sweep);

/* Moves the sweeps `active` to their next rows, at targets[lane], in a batch if `lanes` is given (NULL: singly), and
 * takes their observers' samples between. If an observer does not read all rows, several are passed and written:
 * targets[lane] is then of the row that is reached. */
void km_driver_sweeps_advance(km_driver_sweep *sweeps, unsigned active, km_batch *lanes, double *targets,
                              km_motion_end *reaches);

#endif
