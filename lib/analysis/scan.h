/* Finding where functions of the pose vanish, peak or grow without bound between the rows of a sweep. Private to
 * analysis/. */
#ifndef KM_ANALYSIS_SCAN_H
#define KM_ANALYSIS_SCAN_H

#include "analysis/sweeper.h"

typedef enum km_event_kind {
  KM_EVENT_ZERO,
  KM_EVENT_POLE, /* the function grows without bound */
  KM_EVENT_MINIMUM,
  KM_EVENT_MAXIMUM
} km_event_kind;

typedef struct km_event {
  km_event_kind kind;
  int function;
  double s, value;
} km_event;

/* The events of a scan, in the order in which they were passed. */
typedef struct km_events {
  km_event *items;
  size_t count, capacity;
} km_events;

/* Functions f_i of the pose, sampled along a sweep. */
typedef struct km_scan {
  int count;
  void *self;
  /* f[count] at the state's pose; NaN where one has no value. */
  void (*values)(void *self, km_sweeper *sweeper, double *f);
  bool zeros, extremes; /* what to look for */
  bool best_counts;     /* an extreme next to which poses can't be reached is the best one found */
  km_events *events;
  double s[3], *f[3]; /* the last samples, the newest first */
  int have;
  double *probe; /* [count] */
} km_scan;

/* Space for `count` functions; false when out of memory. */
bool km_scan_reserve(km_scan *scan, int count);
void km_scan_free(km_scan *scan);
/* The state stands at s: samples the functions, and looks between this sample and the last ones (Brent's methods, GSL).
 * Comes back to s. KM_MEMORY. */
km_status km_scan_sample(km_scan *scan, km_sweeper *sweeper, double s, km_error *error);

#endif
