/* Finding where functions of the pose vanish, peak or grow without bound between the rows of a sweep. Private to
 * analysis/. */
#ifndef KM_SWEEP_EVENT_SEARCH_H
#define KM_SWEEP_EVENT_SEARCH_H

#include "sweep/sweep.h"

typedef enum km_event_kind {
  KM_EVENT_ZERO,      /* the numerator vanishes */
  KM_EVENT_POLE,      /* the denominator vanishes: the function grows without bound */
  KM_EVENT_UNDEFINED, /* both vanish */
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

/* The last samples of a function since its last pole or corner, the newest first. */
typedef struct km_entry_range {
  double s[3], f[3];
  int have;
} km_entry_range;

/* Samples at the beginning or the end of a sweep, the one at its end first. */
enum { KM_ENDING = 14 };
typedef struct km_ending {
  int have;
  double s[KM_ENDING], *n, *d; /* [KM_ENDING × count] */
} km_ending;

/* Functions f_i = n_i / d_i of the pose, sampled along a sweep. n_i and d_i are smooth where the motion is: what f_i
 * does between samples is told by them, never by the size of its neighbours. */
typedef struct km_event_search {
  int count;
  void *self;
  /* n[count] and d[count] at the state's pose; d is 1 where nothing else is written; NaN where f has no value. */
  void (*values)(void *self, km_sweeper *sweeper, double *n, double *d);
  /* After `values` at a sample: what comes is to be seen from there. NULL: nothing depends on it. */
  void (*sampled)(void *self, km_sweeper *sweeper);
  /* The state stands at s, near a pole where one more sample shows the function's course; NULL: nobody asks. */
  bool (*between)(void *self, km_sweeper *sweeper, double s);
  bool ratios, extremes;     /* what to look for: zeros and poles; extremes */
  bool best_counts;          /* an extreme next to which poses can't be reached is the best one found */
  km_events *events;         /* NULL: nobody reads any, and nothing is sampled or looked for */
  double s[2], *n[2], *d[2]; /* the last two samples, the newest first */
  int have;                  /* of them; 0 to forget them */
  double *probe_n, *probe_d; /* [count] */
  km_entry_range *runs;      /* [count] */
  km_ending first, last;
  double shown; /* the pole that `between` has been shown last */
} km_event_search;

/* Space for `count` functions; false when out of memory. */
bool km_event_search_reserve(km_event_search *scan, int count);
void km_event_search_free(km_event_search *scan);
/* The state stands at s: samples the functions, and looks between this sample and the last ones (Brent's methods, GSL).
 * Comes back to where the mover settles. KM_MEMORY. */
km_status km_event_search_sample(km_event_search *scan, km_sweeper *sweeper, double s, km_error *error);
/* Moves the state to s, and fills probe_n and probe_d there; false where the pose can't be reached. */
bool km_event_search_visit(const km_event_search *scan, km_sweeper *sweeper, double s);
/* Shows `between` the poses on the way from s to a pole, or away from it. Leaves the state at one of them. */
km_status km_event_search_add_row(km_event_search *scan, km_sweeper *sweeper, double s, double pole, bool away,
                                  km_error *error);
/* The newest sample becomes the first of the last ones, and, while there is room, the last of the first ones. */
void km_event_keep_ending(km_event_search *scan);
/* The driver gives out at `end`, which is the first or the last row. Whatever else stands there comes to it as the root
 * of the way: tells the zeros and poles. After the last sample. */
km_status km_event_at_end(km_event_search *scan, km_sweeper *sweeper, double end, km_error *error);

km_status km_events_add(km_events *events, km_event event, km_error *error);
/* Into the order in which the sweep passed them. */
void km_events_sort(km_events *events, const km_sweep_plan *plan);

#endif
