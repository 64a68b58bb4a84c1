/* Points of a cubic lattice within a ball: tilts in every direction alike. */
#ifndef KM_ARM_METHODS_BALL_LATTICE_H
#define KM_ARM_METHODS_BALL_LATTICE_H

#include "base/memory.h"

typedef struct km_lattice {
  int count;      /* of the points; the first one is the origin */
  int each;       /* steps from the origin to the sphere along an axis */
  bool wider;     /* the steps are longer than they were to be */
  double *points; /* [count × freedom] the arena's */
} km_lattice;

/* Whole multiples of radius / each along every axis, at most `radius` from the origin. `each` is the number of steps that is wanted, as far
 * as it is at most 8 and the points are at most 33 (two steps along each of three axes) or those of one step. False: out of memory. */
bool km_lattice_make(int freedom, double radius, double wanted, km_arena *arena, km_lattice *out);

#endif
