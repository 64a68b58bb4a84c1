/* What a force n/d does along densely spaced poses: its zeros, poles and peaks, each between two of them. */
#ifndef KM_TESTS_COURSE_H
#define KM_TESTS_COURSE_H

#include "kmech/statics_sweep.h"
#include "support/forces.h"

typedef struct course {
  int count;
  double *s, *n, *d; /* [count] */
} course;

course course_make(int count);
void course_free(course *c);

/* Are the events of the sweep's actuator those of the course, one for one? An end at which the actuator has no bound
 * beside them: `ends`. `slack`: of a place, over the range. Says what isn't. */
bool course_agrees(const course *c, const km_statics_sweep *sweep, int actuator, bool ends, double slack,
                   family_count *count);

#endif
