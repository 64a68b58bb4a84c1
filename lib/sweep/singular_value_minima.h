/* Minima of the smallest kept singular value along a sweep (theory 10.4). Private to sweep/. */
#ifndef KM_SWEEP_SINGULAR_VALUE_MINIMA_H
#define KM_SWEEP_SINGULAR_VALUE_MINIMA_H

#include "kmech/sweep.h"
#include "mobility/jacobian_singular_values.h"
#include "sweep/events/event_search.h"

/* Search for the minima over a sweep. */
typedef struct km_singular_value_minima {
  km_singular_value_workspace *singular; /* NULL: not requested */
  int regular_rank;                      /* regular rank: largest rank found so far */
  km_event_search search;
  km_events events;
} km_singular_value_minima;

/* False without memory. */
bool km_singular_value_minima_create(km_singular_value_minima *minima, const km_mechanism *mechanism,
                                     const km_sweep_plan *plan);
void km_singular_value_minima_free(km_singular_value_minima *minima);

/* Returns the smallest kept singular value at the state's configuration, number rank; NaN without a moving
 * substructure. */
double km_singular_value_kept(km_singular_value_minima *minima, const km_sweeper *sweeper);
/* Samples at a row or between rows: updates the smallest value and locates minima since the last sample. The state
 * keeps its configuration. KM_MEMORY; KM_USAGE for a substructure that is too large. */
km_status km_singular_value_minima_sample(km_singular_value_minima *minima, km_sweeper *sweeper, double s,
                                          km_mobility_sweep *out, km_error *error);

#endif
