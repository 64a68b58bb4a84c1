/* Clearances along a sweep: columns, least values, and contacts between the rows (theory 10.7). Private to sweep/. */
#ifndef KM_SWEEP_CLEARANCE_CLEARANCE_SEARCH_H
#define KM_SWEEP_CLEARANCE_CLEARANCE_SEARCH_H

#include "base/table.h"
#include "sweep/events/event_search.h"

typedef struct km_clearance_search {
  const km_clearance *clearance; /* NULL: not requested, and the other functions do nothing */
  km_clearance_course *out;
  int count;
  km_pair_clearance *now; /* [count] at the last configuration */
  bool *overlaps;         /* [count] at the first sample */
  bool has_sample;
  km_peak sampled, probed; /* least clearance of the last sample; the least of all probes since, its pair as s */
  km_event_search contacts, least;
  km_events contact_events, least_events;
} km_clearance_search;

/* Allocates the search of a plan with clearances. KM_MEMORY. Free in any case. */
km_status km_clearance_search_create(const km_sweep_plan *plan, km_clearance_course *out, bool table_only,
                                     km_clearance_search *search, km_error *error);
void km_clearance_search_free(km_clearance_search *search);
/* Adds the columns `clearance`, the least one, and clearance.<body>/<body> of each pair. False: no memory. */
bool km_clearance_search_columns(const km_clearance_search *search, const km_sweeper *sweeper, km_table *table);
/* Writes the cells of a row and returns the next cell. */
double *km_clearance_search_cells(km_clearance_search *search, km_sweeper *sweeper, double *cell);
/* Samples at a row or between rows. KM_MEMORY. */
km_status km_clearance_search_sample(km_clearance_search *search, km_sweeper *sweeper, double s, km_error *error);
/* The motion switches to another branch. */
void km_clearance_search_restart(km_clearance_search *search);
/* Collects the contacts in the order of the sweep. KM_MEMORY. */
km_status km_clearance_search_finish(km_clearance_search *search, const km_sweep_plan *plan, km_error *error);

#endif
