/* Idle freedoms: one body, or a few, can move in place while everything else stands, as the spin of a rod between two
 * ball joints. They count in the mobility, but no other joint drives or feels them. */
#ifndef KMECH_IDLE_H
#define KMECH_IDLE_H

#include "kmech/mobility.h"
#include "kmech/progress.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  KM_MOST_IDLE_BODIES = 4 /* of one group */
};

/* A group of bodies that hinges and slides tie together, all of whose other joints have several coordinates. */
typedef struct km_idle_freedom {
  int substructure; /* that the group lies in */
  int freedoms;     /* of the group while all other bodies stand, at the pose and a short way along the motion */
  int body_count;
  int bodies[KM_MOST_IDLE_BODIES]; /* of the model; 0 is the inertial frame and never in a group */
} km_idle_freedom;

/* All such groups. */
typedef struct km_idle_freedoms {
  int count, mobility;    /* groups; the sum of their freedoms */
  km_idle_freedom *items; /* [count] */
} km_idle_freedoms;

/* At an assembled pose; the state is left at it. By test: rank of the group's own joints with its neighbours fixed.
 * Cost: linear in joints. Free `*out` in any case. */
KM_API km_status km_idle_freedoms_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                       void *context, km_idle_freedoms *out, km_error *error);
/* Which coordinates belong to the joints that idle bodies turn in: marks[coordinate count]. They say nothing of the rest of
 * the mechanism. O(joints · groups). */
KM_API void km_idle_coordinates(const km_mechanism *mechanism, const km_idle_freedoms *freedoms, bool *marks);
KM_API void km_idle_freedoms_free(km_idle_freedoms *freedoms);

#ifdef __cplusplus
}
#endif
#endif
