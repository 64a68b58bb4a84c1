/* Sparse QR of a large matrix: projections and minimum-norm solutions (docs/theory.md 3.4, 3.5). SuiteSparse's SPQR (T.
 * Davis 2011) is loaded at the first use. */
#ifndef KM_LINALG_SPARSE_SPARSE_QR_H
#define KM_LINALG_SPARSE_SPARSE_QR_H

#include "kmech/base.h"

#include <stdbool.h>

typedef struct km_sparse_qr km_sparse_qr;

/* Reserves a factorisation of rows × columns with up to `entries` entries. KM_IO: the library is not installed.
 * KM_MEMORY. */
km_status km_sparse_qr_create(int rows, int columns, int entries, km_sparse_qr **out, km_error *error);
void km_sparse_qr_free(km_sparse_qr *q);

/* Matrix to fill before km_sparse_qr_factor, by columns: entries start[c] … start[c+1]-1 of `row`, ascending, and
 * `value`. */
typedef struct km_columns {
  long *start, *row;
  double *value;
} km_columns;
km_columns km_sparse_qr_columns(km_sparse_qr *q);

/* Factors the matrix. A column whose remainder is at most `tolerance` counts as dependent. False when out of memory.
 * O(entries of R), in COLAMD order. */
bool km_sparse_qr_factor(km_sparse_qr *q, double tolerance);
int km_sparse_qr_rank(const km_sparse_qr *q);

/* Removes from each of `count` vectors v[rows · count] its projection onto the column space, v <- (I − Q Qᵀ) v. False
 * when out of memory. */
bool km_sparse_qr_remove(km_sparse_qr *q, double *v, int count);
/* Squared length |Qᵀ v|² of the projection of each of `count` vectors v[rows · count] onto the column space. False when
 * out of memory. */
bool km_sparse_qr_projected_squares(km_sparse_qr *q, double *v, int count, double *squares);
/* Squared length of the projection of every unit vector onto the column space: square[row] = |R⁻ᵀ b|² of row b of the
 * matrix. False when out of memory or if columns are dependent to the tolerance. Factors by itself, by nested
 * dissection. O(entries of R that the rows of the matrix reach). */
bool km_sparse_qr_squared_norms(km_sparse_qr *q, double tolerance, double *square);
/* Independent columns to the tolerance, in COLAMD order: list[rank], unordered. Returns the rank; -1: out of memory.
 * Factors by itself. */
int km_sparse_qr_independent_columns(km_sparse_qr *q, double tolerance, int *list);
/* Minimum-norm solution x[rows] of Aᵀ x = b[columns], which must be solvable. False when out of memory. */
bool km_sparse_qr_minimum_norm(km_sparse_qr *q, const double *b, double *x);

#endif
