/* A drive and what it remembers. Private to kinematics/. */
#ifndef KM_KINEMATICS_DRIVE_H
#define KM_KINEMATICS_DRIVE_H

#include "kinematics/least_path.h"
#include "kinematics/state.h"
#include "kmech/sweep.h"

/* The longest step, radians or substructure sizes. */
static const double km_drive_longest = 0.3;

/* Where a drive is: all that the next step depends on, but for the state's pose. */
typedef struct km_drive_place {
  double s;                   /* the driver, scaled */
  double largest;             /* the step that step control allows now */
  double stopped;             /* the direction that ended here, ±1, while the pose is close to that end; else 0 */
  int crossings;              /* singular poses passed so far */
  bool known;                 /* t belongs to the present pose */
  double *t;                  /* [columns] */
  double *last_t, *last_move; /* [columns] the step before this pose, for the predictor */
  double last_h;              /* 0: none */
  km_partition reference;     /* pivots of the present pose, to compare signs with */
} km_drive_place;

struct km_drive {
  km_arena arena;
  km_drive_place here, mark;
  double *mark_pose; /* of the state at `mark` */
  bool marked;       /* `mark` is a place */
  const km_mechanism *mechanism;
  km_state *state;
  int coordinate, substructure, column;
  bool ignore_limits;
  bool passing;               /* this step goes over a singular pose on purpose */
  double *next_t, *move;      /* [columns] */
  double *saved, *near, *far; /* poses to come back to */
  km_least_path path;         /* where other freedoms are left */
  double strain;              /* of the last prediction by it: at 1 its error is all that is allowed */
};

static inline const km_substructure *km_drive_driven(const km_drive *d) {
  return &d->mechanism->substructures[d->substructure];
}

#endif
