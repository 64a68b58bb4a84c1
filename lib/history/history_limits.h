/* Limits of joints that a motion over time passes. Private to analysis/. */
#ifndef KM_HISTORY_HISTORY_LIMITS_H
#define KM_HISTORY_HISTORY_LIMITS_H

#include "forces/motion_forces.h"
#include "kmech/dynamics.h"

/* The limits that are watched: of joints that aren't held, and whose limits no stop guards. */
typedef struct km_limit_watch {
  const km_mechanism *m;
  double slack;           /* radians or characteristic lengths beyond a limit that don't count */
  km_passed_limit *limit; /* [count] */
  bool *is_passed;        /* [count] */
  int count;
  km_crossing *crossings; /* [crossing_count] the caller's, then those of limits */
  int user_count, crossing_count;
} km_limit_watch;

/* `simulation`: the run whose crossings locate them; NULL: rows alone tell. KM_MEMORY. */
km_status km_limits_watch(km_limit_watch *watch, const km_mechanism *mechanism, const km_forces *forces,
                          const km_simulation_def *simulation, km_error *error);
/* Notes what is beyond its limits at the state. */
void km_limits_row(km_limit_watch *watch, const km_state *state);
/* Takes a crossing of a limit; false: it is one of the caller's. */
bool km_limits_crossed(km_limit_watch *watch, const km_crossing_met *met);
/* Hands over the limits that were passed and frees the rest. */
void km_limits_report(km_limit_watch *watch, km_history *history);

#endif
