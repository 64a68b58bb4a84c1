/* Minima of the smallest singular value along a sweep. Private to sweep/. */
#ifndef KM_SWEEP_SINGULAR_VALUE_MINIMA_H
#define KM_SWEEP_SINGULAR_VALUE_MINIMA_H

#include "kmech/sweep.h"
#include "mobility/jacobian_singular_values.h"
#include "sweep/event_search.h"

/* The smallest singular value over a sweep. */
typedef struct km_singular_value_watch {
  km_singular_value_workspace *singular; /* NULL: not asked for */
  int generic;                           /* how many values the poses keep that have the least freedom so far */
  km_event_search scan;
  km_events events;
} km_singular_value_watch;

/* False when out of memory. */
bool km_singular_value_watch_make(km_singular_value_watch *watch, const km_mechanism *mechanism);
void km_singular_value_watch_free(km_singular_value_watch *watch);

/* The smallest singular value that is kept at the state's pose: the rank'th. NaN where nothing moves. */
double km_singular_value_kept(km_singular_value_watch *watch, const km_sweeper *sweeper);
/* At a row or a pose between rows: notes the least value so far, and where it has a minimum. Leaves the state there.
 * KM_MEMORY; KM_USAGE for a substructure that doesn't fit. */
km_status km_singular_value_observe(km_singular_value_watch *watch, km_sweeper *sweeper, double s,
                                    km_mobility_sweep *out, km_error *error);

#endif
