/* Events between samples of a sweep (theory 10.1). Private to event_search.c and event_location.c. */
#ifndef KM_SWEEP_EVENT_LOCATION_H
#define KM_SWEEP_EVENT_LOCATION_H

#include "sweep/events/event_search.h"

typedef enum km_event_part { KM_NUMERATOR, KM_DENOMINATOR, KM_QUOTIENT } km_event_part;

/* n and d of function i in a sample of the window. */
static inline double km_sampled_numerator(const km_event_search *search, int sample, int i) {
  return km_sample(&search->window, sample, i);
}

static inline double km_sampled_denominator(const km_event_search *search, int sample, int i) {
  return km_sample(&search->window, sample, search->count + i);
}

static inline km_status km_no_sweep_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a sweep");
}

/* Finds the root of a part of function i between two positions with different signs; false if it is not reached. The
 * state stays at the root. */
bool km_event_find_root(km_event_search *search, km_sweeper *sweeper, int i, km_event_part part, double a, double b,
                        double fa, double fb, double *root);
/* True if |x| is rounding beside the neighbouring values a and b. */
bool km_event_vanishes(double x, double a, double b);
/* Finds an extremum bracketed by the last three samples of a run (sign 1: minimum, -1: maximum). */
km_status km_event_find_extremum(km_event_search *search, km_sweeper *sweeper, int i, double sign, km_error *error);
/* Returns the position of the minimum of the parabola through three samples of |n|, if all n have one sign and the
 * minimum is so low that n may be 0 there; else NaN. */
double km_event_lowest_point(const double s[3], const double n[3]);
/* Finds the zeros of function i's numerator that no change of sign shows, since the sample before the last row. */
km_status km_event_find_dips(km_event_search *search, km_sweeper *sweeper, int i, bool *is_moved, km_error *error);

#endif
