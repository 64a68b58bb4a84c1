/* Gauss-Jordan elimination of small matrices (up to 12 rows and 64 columns), with the search for pivots in the
 * update. */
#ifndef KM_LINALG_DENSE_REGISTER_ELIMINATION_H
#define KM_LINALG_DENSE_REGISTER_ELIMINATION_H

#include "linalg/factor_private.h"

enum { KM_SMALL_ROWS = 12, KM_SMALL_COLUMNS = 64 };

/* Factors a matrix with columns in the order p->column, of which the first `candidates` are preferred. Sets row,
 * column, reduced, inverse, scale, rank and the evidence about pivots. */
void km_register_factor(km_factor *p, const double *matrix, int candidates, double tolerance);

/* Refactors with the known pivots: sets reduced and inverse. False if a value is not finite. */
bool km_register_refactor(const km_factor *p, const double *matrix);

#endif
