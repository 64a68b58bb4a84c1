/* Mechanisms that move in parallel planes. */
#ifndef KMECH_PLANE_H
#define KMECH_PLANE_H

#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Do all free joints of the mechanism, or of one loop (0 …), turn about one direction and slide across it, at a pose
 * whose poses are updated (km_poses_update)? Then `normal` is that direction, a unit vector along the inertial axes whose
 * largest component is positive. False too where nothing turns and all slides are parallel. O(joints). */
KM_API bool km_mechanism_plane(const km_mechanism *mechanism, const km_state *state, double normal[3]);
KM_API bool km_loop_plane(const km_mechanism *mechanism, const km_state *state, int loop, double normal[3]);

#ifdef __cplusplus
}
#endif
#endif
