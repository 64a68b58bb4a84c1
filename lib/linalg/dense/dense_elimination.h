/* Back end of km_factor for dense matrices: Gauss-Jordan elimination with complete pivoting. Private to linalg/. */
#ifndef KM_LINALG_DENSE_DENSE_ELIMINATION_H
#define KM_LINALG_DENSE_DENSE_ELIMINATION_H

#include "linalg/factor_private.h"

/* Factors a matrix: sets row, column, reduced, inverse, B, scale, rank and the evidence about pivots, which the caller
 * has cleared. The rows without a pivot are not set. `forced`: as in km_factor_options. */
void km_dense_factor(km_factor *p, const double *matrix, const bool *forced, double tolerance);
/* Refactors with the known pivots: sets reduced, inverse, B, max_b and sign. False if a value is not finite. */
bool km_dense_refactor(km_factor *p, const double *matrix);
/* Solves by the elimination steps; independent columns are 0. */
void km_dense_solve(const km_factor *p, const double *rhs, double *x);

#endif
