/* What a force n/d does along densely spaced poses: its zeros, poles and peaks, each between two of them. */
#ifndef KM_TESTS_COURSE_H
#define KM_TESTS_COURSE_H

#include "kmech/sweep.h"
#include "support/forces.h"

typedef struct course {
  int count;
  double *s, *n, *d; /* [count] */
  double piece;      /* the longest way between two poses that the sweep looks at */
  bool by_root;      /* the driver has given out at its end */
  bool differences;  /* n and d are what changes along pieces of the way that have the places s in their middle */
} course;

/* Where what two of the places show has to be: between them, or of differences anywhere on their two pieces, as the
 * mean value theorem has it. */
void course_span(const course *c, int first, int last, double *low, double *high);

/* For that sweep. */
course course_make(int count, const km_sweep_plan *plan, const km_sweep *motion);
void course_free(course *c);

/* Moves a fixture of its own along the way of a sweep, from its start to the end that it came to, and shows `count`
 * poses: where the driver gives out, the nearer to one another. False where that isn't possible. */
typedef void (*course_look)(void *context, fixture *f, int i, double s);
bool course_walk(fixture *f, const km_sweep_plan *plan, const km_sweep *motion, int count, course_look look,
                 void *context);
/* What an actuator's force does at an end. */
typedef enum course_end {
  COURSE_BOUNDED,
  COURSE_UNCLEAR, /* the places are too far apart to tell */
  COURSE_UNBOUNDED
} course_end;
course_end course_ends(const course *c);

/* Are the events of the sweep's actuator those of the course, one for one, with that at the end beside them?
 * `slack`: of a place, over the range. Says what isn't. */
bool course_agrees(const course *c, const km_statics_sweep *sweep, int actuator, double slack, family_count *count);

#endif
