/* Coulomb friction in a motion that is known: how much load is left. Private to analysis/. */
#ifndef KM_TRANSFER_COULOMB_FRICTION_H
#define KM_TRANSFER_COULOMB_FRICTION_H

#include "base/memory.h"

#include <gsl/gsl_linalg.h>

typedef enum km_friction_answer {
  KM_FRICTION_MOVES, /* load > 0: the input moves the output against so much */
  KM_FRICTION_LOCKS, /* on the way from no friction to all of it the load has passed through 0 */
  KM_FRICTION_OPEN   /* neither is proved */
} km_friction_answer;

/* The normal forces N_c ≥ 0 of `count` places that rub: N_c = |a_c + t Σ_k B_ck N_k| under a fixed input force, where
 * the load that is left is 1 − t Σ w_k N_k; t = 0 without friction, 1 with all of it. a_c, B_ck: vectors. */
typedef struct km_friction {
  int count;
  double *a; /* [count][3] */
  double *B; /* [count][count][3] */
  double *w; /* [count] */
  double load;
  double locks_from; /* KM_FRICTION_LOCKS: the share t of the friction with which nothing is left of the load */
  /* Where the search stands: */
  double *N, *tried, *predicted, *slope; /* [count] */
  gsl_matrix J;
  gsl_vector rhs, step;
  gsl_permutation *pivots;
} km_friction;

/* Space for `most` places; false when out of memory. */
bool km_friction_reserve(km_friction *friction, int most, km_arena *arena);
/* Solves from count, a, B, w: Newton's method (the equations have kinks where an a_c + … vanishes), continued in t.
 * Of the dissipated power the load that is left can't exceed 1, and N grows without bound only where it has passed
 * through 0: that proves a lock. */
km_friction_answer km_friction_solve(km_friction *friction);

#endif
