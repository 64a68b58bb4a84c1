/* Joint limits that a motion over time passes. Private to history/. */
#ifndef KM_HISTORY_HISTORY_LIMITS_H
#define KM_HISTORY_HISTORY_LIMITS_H

#include "forces/motion_forces.h"
#include "kmech/dynamics.h"

/* Monitored limits: of joints that aren't held and whose limits have no stop. */
typedef struct km_limit_monitor {
  const km_mechanism *m;
  double slack;           /* tolerance beyond a limit, radians or characteristic lengths */
  km_passed_limit *limit; /* [count] */
  bool *is_passed;        /* [count] */
  int count;
  km_crossing *crossings; /* [crossing_count] crossings of the caller, then of limits */
  int user_count, crossing_count;
} km_limit_monitor;

/* Begins to monitor the limits. `simulation`: its crossings locate the passages; NULL: rows only. KM_MEMORY. */
km_status km_limits_monitor_begin(km_limit_monitor *watch, const km_mechanism *mechanism, const km_forces *forces,
                                  const km_simulation_def *simulation, km_error *error);
/* Records the coordinates that are beyond their limits at the state. */
void km_limits_row(km_limit_monitor *watch, const km_state *state);
/* Records a crossing of a limit; false: it is a crossing of the caller. */
bool km_limits_crossed(km_limit_monitor *watch, const km_crossing_met *met);
/* Number of limits that were passed, and the one of an index below it. */
int km_limits_passed_count(const km_limit_monitor *watch);
const km_passed_limit *km_limits_passed(const km_limit_monitor *watch, int index);
void km_limits_monitor_free(km_limit_monitor *watch);
/* Moves the passed limits to the history and frees the monitor. */
void km_limits_report(km_limit_monitor *watch, km_history *history);

#endif
