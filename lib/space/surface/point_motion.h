/* The surface on which a point moves: the mechanism's plane, or the plane or sphere of places along a random motion.
 *
 *   step : dq = N du,  |dq| = 0.2, du in a random direction; closed with the controls fixed; back where that fails
 *   σ_1 >= σ_2 of (v_1 v_2), the point's velocities over the size for orthonormal tangents: the largest of all places
 *   say whether it rests, moves along a curve or over a surface. */
#ifndef KM_SPACE_POINT_MOTION_H
#define KM_SPACE_POINT_MOTION_H

#include "space/driver_surface.h"

/* Finds f->point_surface at a closed configuration, to which the state returns. KM_USAGE: none of the
 * two, or the point rests or moves along a curve. */
km_status km_point_motion_find_surface(km_driver_surface *f, km_error *error);

#endif
