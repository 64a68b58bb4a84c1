/* Half-branches of the motions through a configuration (docs/theory.md 5.7). */
#ifndef KM_LOCAL_HALF_BRANCHES_H
#define KM_LOCAL_HALF_BRANCHES_H

#include "local/tangent_cone.h"

enum { KM_MAX_HALF_BRANCHES = 32 };

/* Halves of the motions through the configuration of `tangents`, each given by a closed configuration at a small
 * distance. */
typedef struct km_half_branches {
  int count;
  bool truncated; /* there are more than KM_MAX_HALF_BRANCHES */
  double length;  /* |D (q - q0)| of the configurations */
  double *saved;  /* [KM_MAX_HALF_BRANCHES × 3 · columns] saved */
  double *shares; /* [KM_MAX_HALF_BRANCHES × freedom] unit directions from q0, as coefficients of the basis */
} km_half_branches;

/* Finds the half-branches from random starts around the tangent space: of branches that cross, that touch with the same
 * tangent up to an order of contact of about 5, or that end in a cusp. The basis of the tangents must be there, the
 * configuration exact. False when out of memory. A motion that no start leads to is missed. Restores the state.
 * O(starts · iterations · rows · columns²). */
bool km_half_branches_find(km_tangents *tangents, km_half_branches *out);

#endif
