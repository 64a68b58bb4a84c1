/* The parts of a mobility sweep. Private to analysis/. */
#ifndef KM_ANALYSIS_SWEEPER_H
#define KM_ANALYSIS_SWEEPER_H

#include "kinematics/state.h"
#include "kmech/mobility_sweep.h"

/* How the mechanism moves from row to row: by a driver or by arc length. */
typedef struct km_mover {
  void *self;
  /* Rates of all coordinates per unit of s at the row; false where there is no direction. */
  bool (*rates)(void *self, double *rates);
  /* The same at another s near the row. May leave the row; `settle` comes back to it. */
  bool (*probe)(void *self, double s, double *rates);
  void (*settle)(void *self, double s);
} km_mover;

/* Everything that one sweep needs at hand. */
typedef struct km_sweeper {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  km_mobility_sweep *out;
  km_mover mover;
  int substructure;   /* the one that moves, -1: none */
  double *rates;      /* [coordinate] */
  double *z, *last_z; /* [coordinate] unit direction of motion at the row and at the row before */
  double *scratch;    /* [coordinate] */
  double last_s;
  bool have_last;
  double other_residual; /* of the substructures that stand still */
  int other_mobility;
} km_sweeper;

km_status km_sweeper_columns(const km_sweeper *sweeper, km_error *error);
/* The numbers of what stands still, once. */
void km_sweeper_prepare(km_sweeper *sweeper);
/* A row at the state's pose, and the toggles since the last one. */
km_status km_sweeper_row(km_sweeper *sweeper, int step, double s, km_error *error);

/* Looks for toggles since the last row. KM_MEMORY. */
km_status km_sweeper_toggles(km_sweeper *sweeper, double s, km_error *error);
bool km_sweeper_add_toggle(km_mobility_sweep *out, int coordinate, double s);

/* Lists a branch point. KM_MEMORY. */
km_status km_sweeper_add_branch(km_sweeper *sweeper, km_branch_point point, km_error *error);
/* The drive has passed a singular pose on the way to the last row: finds where, and what meets there. */
km_status km_sweeper_find_branch(km_sweeper *sweeper, km_error *error);
/* At a branch point no direction is the mechanism's own: a short step leads onto the motion that moves the
 * coordinate most, from where the branch point can be passed smoothly. */
km_status km_sweeper_leave_branch(km_sweeper *sweeper, int coordinate, km_error *error);

/* The rows of a driven sweep, and of one by arc length. */
km_status km_sweep_by_driver(km_sweeper *sweeper, km_error *error);
km_status km_sweep_by_length(km_sweeper *sweeper, km_error *error);

/* Asks the progress callback; false: cancelled. */
static inline bool km_sweeper_goes_on(const km_sweeper *r, int step) {
  return !r->plan->progress || r->plan->progress(r->plan->context, (double)step / r->plan->steps);
}

#endif
