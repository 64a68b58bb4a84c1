/* Coulomb friction in a given motion: normal forces and the remaining load (theory 8.6). Private to transfer/. */
#ifndef KM_TRANSFER_COULOMB_FRICTION_H
#define KM_TRANSFER_COULOMB_FRICTION_H

#include "base/memory.h"

#include <gsl/gsl_linalg.h>

typedef enum km_friction_outcome {
  KM_FRICTION_MOVES, /* load > 0: the input moves the output against this load */
  KM_FRICTION_LOCKS, /* self-locking: the load passes through 0 before all friction acts */
  KM_FRICTION_OPEN   /* neither is proved */
} km_friction_outcome;

/* Equations of the normal forces N_c ≥ 0 of `count` surfaces under a fixed input force: N_c = |a_c + t Σ_k B_ck N_k|,
 * remaining load 1 − t Σ w_k N_k; t = 0 without friction, 1 with all of it. a_c, B_ck: vectors. */
typedef struct km_friction {
  int count;
  double *a; /* [count][3] */
  double *B; /* [count][count][3] */
  double *w; /* [count] */
  double load;
  double locks_from; /* KM_FRICTION_LOCKS: the load share t at which the load is 0 */
  /* State of the continuation. */
  double *N, *tried, *predicted, *slope; /* [count] */
  gsl_matrix J;
  gsl_vector rhs, step;
  gsl_permutation *pivots;
} km_friction;

/* Allocates the arrays for `most` surfaces; false without memory. */
bool km_friction_reserve(km_friction *friction, int most, km_arena *arena);
/* Solves the equations from count, a, B, w by Newton's method, continued in t; they are not smooth where an a_c + …
 * vanishes. The dissipated power cannot exceed the input, so N grows without bound only after the load has passed
 * through 0: that proves self-locking. */
km_friction_outcome km_friction_solve(km_friction *friction);

#endif
