/* Distance of a convex hull from the surface that it encloses. */
#ifndef KM_CLEARANCE_HULL_ERROR_H
#define KM_CLEARANCE_HULL_ERROR_H

#include "base/memory.h"
#include "model/geometry/mesh.h"

/* Bound of the largest distance of a point of the hull's surface from the mesh: distances from the hull are too small
 * by at most that. For a closed convex mesh it is rounding, 1e-8 of the size; else at most 2e-3 of the size above the
 * exact value. Infinite without memory. Cost: triangles of the mesh times those of the hull, and of its parts. */
double km_hull_error(const km_mesh *mesh, const km_mesh *hull, double size);

#endif
