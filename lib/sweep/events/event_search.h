/* Events of functions f = n/d along a sweep (theory 10.1): zeros, poles, extrema. Private to sweep/. */
#ifndef KM_SWEEP_EVENT_SEARCH_H
#define KM_SWEEP_EVENT_SEARCH_H

#include "base/event_locator.h"
#include "sweep/events/sample_window.h"
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

/* The last samples of f since its last pole or branch switch, the newest first; equal neighbours count once. */
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

/* A change of sign of a numerator between two samples. */
typedef struct km_sign_change {
  int function;
  double a, b, fa, fb;
} km_sign_change;

/* Functions f_i = n_i / d_i of the configuration, sampled along a sweep. n_i and d_i are smooth along the motion:
 * events are found from them, never from the size of neighbouring values of f_i. */
typedef struct km_event_search {
  int count;
  void *self;
  /* Computes n[count] and d[count] at the state's configuration; d is preset to 1; NaN if f has no value. The
   * sweeper's rates are those of the motion while `is_probing`. */
  void (*values)(void *self, km_sweeper *sweeper, double *n, double *d);
  /* Called after `values` at a sample: makes this sample the reference of the next ones. NULL: not needed. */
  void (*sampled)(void *self, km_sweeper *sweeper);
  /* Takes an additional sample near a pole; the state is at s. NULL: not requested. */
  bool (*between)(void *self, km_sweeper *sweeper, double s);
  bool ratios;   /* zeros and poles by changes of sign */
  bool extremes; /* extrema */
  bool dips;     /* zeros without a change of sign, by three samples of n: n touches 0, or has two zeros between */
  bool defers;   /* zeros by changes of sign are located by km_event_search_next_probe, which lanes do together */
  bool ends;     /* samples are kept for km_event_at_end */
  bool accepts_best_sample; /* the best sample counts as the extremum if configurations near it are not reached */
  double zero;              /* a dip down to this touches 0 */
  bool is_probing;
  km_events *events;         /* NULL: no events are requested, and nothing is sampled */
  km_sample_window window;   /* n and d of the last samples: [2 × count] values */
  double *probe_n, *probe_d; /* [count] */
  km_sample_run *runs;       /* [count] */
  km_end_samples first, last;
  double sampled_pole;     /* pole for which `between` was called last */
  km_sign_change *changes; /* changes of sign since the last row, and the next one to locate */
  size_t change_count, next_change, change_capacity;
  km_root_search root; /* search at that one */
} km_event_search;

/* Search for zeros, poles, extrema and events at the ends of ratios. */
static inline km_event_search
km_event_search_of_ratios(void *self, void (*values)(void *, km_sweeper *, double *, double *), km_events *events) {
  return (km_event_search){
      .self = self, .values = values, .ratios = true, .extremes = true, .ends = true, .events = events};
}
/* Allocates the arrays for `count` functions along the plan's sweep; false without memory. */
bool km_event_search_reserve(km_event_search *search, int count, const km_sweep_plan *plan);
void km_event_search_free(km_event_search *search);
/* Reduces the number of functions, before the first sample. */
void km_event_search_set_count(km_event_search *search, int count);
/* Clears all samples: the next one does not continue them. */
void km_event_search_restart(km_event_search *search);
/* Clears the samples before the newest row, which the next one continues. */
void km_event_search_restart_at_row(km_event_search *search);

/* Adds a step between rows. Returns n[count], which the caller fills; d is 1. NULL: the step does not count. */
double *km_event_search_step(km_event_search *search, double s);
/* Samples the functions at the state's configuration s and finds the events since the last sample. Returns to the row
 * by the mover. KM_MEMORY. */
km_status km_event_search_sample(km_event_search *search, km_sweeper *sweeper, double s, km_error *error);
/* Values of function i at the newest sample (back 0) or the one before (1); NaN: there is none. */
double km_event_numerator(const km_event_search *search, int i, int back);
bool km_event_search_has_sample(const km_event_search *search);

/* Returns the next position at which the rates are required (`defers`); false: none. `probed` follows with the rates
 * there in the sweeper, or is_reached false. */
bool km_event_search_next_probe(km_event_search *search, double *s);
km_status km_event_search_probed(km_event_search *search, km_sweeper *sweeper, bool is_reached, km_error *error);

/* Moves the state to s and computes probe_n and probe_d; false if the configuration is not reached. */
bool km_event_search_probe(km_event_search *search, km_sweeper *sweeper, double s);
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
/* Sorts the events in the order of the sweep; events that are one stay in the order in which they were added. */
void km_events_sort(km_events *events, const km_sweep_plan *plan);

#endif
