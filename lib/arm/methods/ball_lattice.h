/* Points of a cubic lattice within a ball: the null-space steps tan φ that dynamic programming tries, evenly spread
 * over all directions. */
#ifndef KM_ARM_METHODS_BALL_LATTICE_H
#define KM_ARM_METHODS_BALL_LATTICE_H

#include "base/memory.h"

typedef struct km_lattice {
  int count;            /* number of points; the first one is the origin */
  int steps_per_radius; /* steps from the origin to the sphere along an axis */
  bool is_coarse;       /* steps are longer than requested, because the number of points is limited */
  double *points;       /* [count × freedom] in the arena */
} km_lattice;

/* Integer multiples of radius/steps_per_radius along every axis, at most `radius` from the origin. `wanted` steps
 * per radius are used as far as they are at most 8 and the points at most 33 (two steps along each of three axes) or
 * those of one step. False: out of memory. */
bool km_lattice_create(int freedom, double radius, double wanted, km_arena *arena, km_lattice *out);

#endif
