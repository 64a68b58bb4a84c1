/* A drive and what it remembers. Private to kinematics/. */
#ifndef KM_KINEMATICS_DRIVE_H
#define KM_KINEMATICS_DRIVE_H

#include "kinematics/continuation.h"
#include "kinematics/least_path.h"
#include "kmech/sweep.h"

/* The longest step, radians or substructure sizes. */
static const double km_drive_longest = 0.3;

/* Where a drive is, beside its course and the state's pose. */
typedef struct km_drive_place {
  double s;       /* the driver, scaled */
  double largest; /* the step that step control allows now */
  double stopped; /* the direction that ended here, ±1, while the pose is close to that end; else 0 */
  int crossings;  /* singular poses passed so far */
  bool known;     /* the course's tangent belongs to the present pose */
} km_drive_place;

struct km_drive {
  km_arena arena;
  km_continuation c;
  km_drive_place here, mark;
  km_course mark_course;
  double *mark_pose;  /* of the state at `mark` */
  bool marked;        /* `mark` is a place */
  bool passing;       /* this step goes over a singular pose on purpose */
  double *near, *far; /* poses to come back to */
  km_least_path path; /* where other freedoms are left */
  double strain;      /* of the last prediction by it: at 1 its error is all that is allowed */
};

static inline const km_substructure *km_drive_driven(const km_drive *d) {
  return km_continuation_sub(&d->c);
}

#endif
