/* Mechanical advantage over a sweep. */
#ifndef KMECH_ADVANTAGE_SWEEP_H
#define KMECH_ADVANTAGE_SWEEP_H

#include "kmech/sweep_plan.h"
#include "kmech/transmission.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pose at which the advantage is 0, infinite or undefined, located by root finding. */
typedef struct km_advantage_toggle {
  km_advantage_state state; /* the advantage there, never finite */
  double s;                 /* of the driver, model's unit, or arc length */
} km_advantage_toggle;

/* A value of a sweep, and where; s is NaN if there is none. */
typedef struct km_peak {
  double value, s; /* the extreme; of the driver or arc length */
} km_peak;

/* The rows of a sweep with their advantages, and what lies between the rows. */
typedef struct km_advantage_sweep {
  km_sweep motion;              /* its table has ma.<input>/<output>, and force_ratio. where joints have friction */
  km_handle input, output;      /* the ends that were asked for */
  size_t column;                /* of the advantage, in the table */
  bool friction;                /* some joint has friction: the next column is the actual force ratio */
  km_advantage_method method;   /* of the first row */
  km_advantage_toggle *toggles; /* in the order of the sweep */
  size_t toggle_count;
  km_transmission last; /* of the last row, with why metrics are undefined there; if the transmission was asked for */
  km_peak lowest, highest; /* of the advantage, between the rows too; infinite beside a toggle */
  km_peak least;           /* its value of the least size, between the rows too */
} km_advantage_sweep;

/* Sweeps as km_mobility_sweep_run does, and looks between the rows for toggles of the advantage (to 1e-9 of the
 * driver) and for its extremes. `transmission` adds the metrics of kmech/transmission.h as columns. KM_USAGE: the ends
 * can't be input and output (km_lever_create). Names of the ends are borrowed by `out`. Free `*out` in any case. */
KM_API km_status km_advantage_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                        const km_handle *input, const km_handle *output, bool transmission,
                                        km_advantage_sweep *out, km_error *error);
KM_API void km_advantage_sweep_free(km_advantage_sweep *sweep);

#ifdef __cplusplus
}
#endif
#endif
