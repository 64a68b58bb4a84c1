/* Events of functions f = n/d along a sweep (theory 10.1): zeros, poles, extrema. Private to sweep/. */
#ifndef KM_SWEEP_ZERO_POLE_SEARCH_H
#define KM_SWEEP_ZERO_POLE_SEARCH_H

#include "sweep/sweep.h"

typedef enum km_event_kind {
  KM_EVENT_ZERO,      /* n = 0 */
  KM_EVENT_POLE,      /* d = 0: f is unbounded */
  KM_EVENT_UNDEFINED, /* n = d = 0 */
  KM_EVENT_MINIMUM,
  KM_EVENT_MAXIMUM
} km_event_kind;

typedef struct km_event {
  km_event_kind kind;
  int function;
  double s, value;
} km_event;

typedef struct km_events {
  km_event *items;
  size_t count, capacity;
} km_events;

/* The last samples of f since its last pole or branch switch, the newest first. */
typedef struct km_sample_run {
  double s[3], f[3];
  int have;
} km_sample_run;

/* Samples at the start or the end of a sweep, the outermost first. */
enum { KM_MAX_END_SAMPLES = 14 };
typedef struct km_end_samples {
  int have;
  double s[KM_MAX_END_SAMPLES], *n, *d; /* [KM_MAX_END_SAMPLES × count] */
} km_end_samples;

/* Functions f_i = n_i / d_i of the configuration, sampled along a sweep. n_i and d_i are smooth along the motion:
 * events are found from them, never from the size of neighbouring values of f_i. */
typedef struct km_event_search {
  int count;
  void *self;
  /* Computes n[count] and d[count] at the state's configuration; d is preset to 1; NaN if f has no value. */
  void (*values)(void *self, km_sweeper *sweeper, double *n, double *d);
  /* Called after `values` at a sample: makes this sample the reference of the next ones. NULL: not needed. */
  void (*sampled)(void *self, km_sweeper *sweeper);
  /* Takes an additional sample near a pole; the state is at s. NULL: not requested. */
  bool (*between)(void *self, km_sweeper *sweeper, double s);
  bool ratios, extremes;     /* search for zeros and poles; for extrema */
  bool accepts_best_sample;  /* the best sample counts as the extremum if configurations near it are not reached */
  km_events *events;         /* NULL: no events are requested, and nothing is sampled */
  double s[2], *n[2], *d[2]; /* the last two samples, the newest first */
  int have;                  /* number of valid samples; 0 restarts the search */
  double *probe_n, *probe_d; /* [count] */
  km_sample_run *runs;       /* [count] */
  km_end_samples first, last;
  double sampled_pole; /* pole for which `between` was called last */
} km_event_search;

/* Allocates the arrays for `count` functions; false without memory. */
bool km_event_search_reserve(km_event_search *search, int count);
void km_event_search_free(km_event_search *search);
/* Samples the functions at the state's configuration s and finds the events since the last sample (Brent's methods,
 * GSL). Returns to the row by the mover. KM_MEMORY. */
km_status km_event_search_sample(km_event_search *search, km_sweeper *sweeper, double s, km_error *error);
/* Moves the state to s and computes probe_n and probe_d; false if the configuration is not reached. */
bool km_event_search_probe(const km_event_search *search, km_sweeper *sweeper, double s);
/* Calls `between` at configurations from s towards a pole, or (away) in reverse order. The state stays at one of
 * them. */
km_status km_event_search_approach_pole(km_event_search *search, km_sweeper *sweeper, double s, double pole, bool away,
                                        km_error *error);
/* Records the newest sample among the last ones and, until its array is full, among the first ones. */
void km_event_record_end_sample(km_event_search *search);
/* Finds zeros and poles at a turning point of the driver, `end`, which is the first or the last row: functions vary
 * there as the root of the driver's distance. After the last sample. */
km_status km_event_at_end(km_event_search *search, km_sweeper *sweeper, double end, km_error *error);

km_status km_events_add(km_events *events, km_event event, km_error *error);
/* Sorts the events in the order of the sweep. */
void km_events_sort(km_events *events, const km_sweep_plan *plan);

#endif
