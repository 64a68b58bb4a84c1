/* Redundant constraints, named: what is constrained twice, and which freedom would end it. */
#ifndef KMECH_REDUNDANCY_H
#define KMECH_REDUNDANCY_H

#include "kmech/mobility.h"
#include "kmech/progress.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A joint that would remove a redundancy with another type, the mobility staying the same. */
typedef struct km_remedy {
  int joint;       /* of the model */
  const char *to;  /* "cylindrical", "universal", "spherical" */
  int freedoms;    /* that the swap adds */
  double strength; /* how squarely the new freedom meets the redundant constraint: 0 … 1 */
} km_remedy;

enum {
  KM_MOST_REMEDIES = 8 /* how many are listed */
};

/* One redundant constraint of a loop: a wrench that the loop's other constraints carry already. */
typedef struct km_redundancy {
  int substructure, loop; /* where it is; the loop it is told of */
  bool rotation;          /* a pure couple: a rotation is constrained twice; else a force: a translation is */
  double direction[3];    /* unit vector in the inertial frame */
  double point[3];        /* on the line of the force, inertial frame, model's length unit; of a couple: unused */
  double pitch;           /* couple along the force over the force, model's length unit: 0 for a plain translation */
  int loops;              /* how many loops the redundancy spans */
  bool out_of_plane;      /* of one planar loop, across its plane: such a loop has three of them by nature */
  bool lasting;           /* also a short way along the motion, not only at this pose */
  int remedy_count;
  km_remedy remedies[KM_MOST_REMEDIES]; /* what would end it: by `freedoms`, then the strongest first */
} km_redundancy;

/* All of a pose. */
typedef struct km_redundancies {
  int count;
  km_redundancy *items; /* [count] */
} km_redundancies;

/* The redundant constraints of an assembled pose: left null vectors of the six-row Jacobian, those of single loops
 * first. Remedies are found by test: the new freedom's column must raise the rank. Their number is
 * 6 · loops + couplings − rank, less those that only couplings have part in. Free `*out` in any case. */
KM_API km_status km_redundancies_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                      void *context, km_redundancies *out, km_error *error);
KM_API void km_redundancies_free(km_redundancies *redundancies);

#ifdef __cplusplus
}
#endif
#endif
