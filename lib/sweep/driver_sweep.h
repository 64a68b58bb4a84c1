/* A driven sweep on its way from row to row. Private to sweep/driver_sweep.c and batch_sweep.c. */
#ifndef KM_SWEEP_DRIVER_SWEEP_H
#define KM_SWEEP_DRIVER_SWEEP_H

#include "sweep/sweep.h"

/* A drive, and whether it has left the row for a look at poses beside it. */
typedef struct km_seat {
  km_driver_motion *drive;
  bool away;
} km_seat;

/* The rows of one sweep as they come: what is left to do, beside the sweeper. */
typedef struct km_driver_sweep {
  km_sweeper *r;
  km_sweep_job *job;
  km_seat at;
  int step, row; /* the next ones; step 0 leads to the first row */
  double last;
  int crossings; /* of the drive, at the last row */
  bool over;
} km_driver_sweep;

/* The driver's value at a step of the plan, from 1 on. */
static inline double km_walk_value(const km_sweep_plan *plan, int step) {
  return step == plan->steps ? plan->to : plan->from + (plan->to - plan->from) * step / plan->steps;
}

/* The observer is going to look where the drive has arrived: gets ready for it. */
void km_driver_sweep_prepare(km_driver_sweep *walk);

/* Moves the walks `going` to their next rows, at targets[lane], side by side where there are lanes (NULL: none), and shows their
 * observers the way. Where an observer doesn't look at all rows several are passed and written: targets[lane] is then of the
 * row where the walk arrives. */
void km_driver_sweeps_advance(km_driver_sweep *walks, unsigned going, km_batch *lanes, double *targets,
                              km_motion_end *reaches);

#endif
