/* Q R of a large matrix with few entries: projections and solutions of least norm. SuiteSparse's SPQR does it (T. Davis,
 * Algorithm 915, 2011), loaded when it is first needed. */
#ifndef KM_LINALG_SPARSE_SPARSE_QR_H
#define KM_LINALG_SPARSE_SPARSE_QR_H

#include "kmech/base.h"

#include <stdbool.h>

typedef struct km_sparse_qr km_sparse_qr;

/* Space for matrices of rows × columns with up to `entries` entries. KM_IO: the library isn't installed. KM_MEMORY. */
km_status km_sparse_qr_create(int rows, int columns, int entries, km_sparse_qr **out, km_error *error);
void km_sparse_qr_free(km_sparse_qr *q);

/* The matrix to fill before km_sparse_qr_factor, by columns: entries start[c] … start[c+1]-1 of `row`, ascending, and
 * `value`. */
typedef struct km_columns {
  long *start, *row;
  double *value;
} km_columns;
km_columns km_sparse_qr_columns(km_sparse_qr *q);

/* Columns of which no more than `tolerance` is left over those before them count as spanned by these. False when out of
 * memory. O(entries of R), by COLAMD's order. */
bool km_sparse_qr_factor(km_sparse_qr *q, double tolerance);
int km_sparse_qr_rank(const km_sparse_qr *q);

/* Takes out of each of `count` vectors v[rows · count] what the columns span of it. False when out of memory. */
bool km_sparse_qr_remove(km_sparse_qr *q, double *v, int count);
/* |v|² of what the columns span of each of `count` vectors v[rows · count]. False when out of memory. */
bool km_sparse_qr_projected_squares(km_sparse_qr *q, double *v, int count, double *squares);
/* The same of every unit vector: share[row], by R alone. False when out of memory, or where the columns depend on each
 * other to the tolerance. Factors by itself, the columns as they stand or in an order of nested dissection. O(entries of R that the
 * rows of the matrix reach). */
bool km_sparse_qr_squared_norms(km_sparse_qr *q, double tolerance, bool as_they_stand, double *share);
/* The columns of which more than `tolerance` is left over those before them, in COLAMD's order: list[rank], no order. Returns
 * the rank, -1: out of memory. Factors by itself. */
int km_sparse_qr_independent_columns(km_sparse_qr *q, double tolerance, int *list);
/* The x[rows] of least |x| with Aᵀx = b[columns], which must have one. False when out of memory. */
bool km_sparse_qr_minimum_norm(km_sparse_qr *q, const double *b, double *x);

#endif
