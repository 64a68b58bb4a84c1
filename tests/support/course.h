/* Reference for a quotient n/d at densely spaced samples: its zeros, poles and peaks, each between two samples. */
#ifndef KM_TESTS_COURSE_H
#define KM_TESTS_COURSE_H

#include "kmech/sweep.h"
#include "support/forces.h"

typedef struct course {
  int count;
  double *s, *n, *d; /* [count] */
  double piece;      /* the longest way between two poses that the sweep looks at */
  bool by_root;      /* the driver is at a dead point at its end */
  bool differences;  /* n and d are what changes along pieces of the way that have the places s in their middle */
} course;

/* Interval of an event shown by two places: between them, or for differences anywhere on their two pieces, by the
 * mean value theorem. */
void course_span(const course *c, int first, int last, double *low, double *high);

/* Reference for a sweep. */
course course_make(int count, const km_sweep_plan *plan, const km_sweep *motion);
void course_free(course *c);

/* Moves a separate fixture along a sweep, from its start to its end, and visits `count` samples, denser towards a
 * dead point. False if that isn't possible. */
typedef void (*course_look)(void *context, fixture *f, int i, double s);
bool course_walk(fixture *f, const km_sweep_plan *plan, const km_sweep *motion, int count, course_look look,
                 void *context);
/* Behaviour of an actuator's force at an end. */
typedef enum course_end {
  COURSE_BOUNDED,
  COURSE_UNCLEAR, /* the places are too far apart */
  COURSE_UNBOUNDED
} course_end;
course_end course_ends(const course *c);

/* True if the events of the sweep's actuator match the reference one to one, including the end. `slack`: tolerance
 * of a place, over the range. Prints mismatches. */
bool course_agrees(const course *c, const km_statics_sweep *sweep, int actuator, double slack, family_count *count);

#endif
