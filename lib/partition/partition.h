/* Coordinate partitioning of one constraint matrix: rank, dependent and independent columns, null space.
 * Knows matrices, never mechanisms. Sources: thesis 3.4, 4.1, 9.1; equations (163), (271), (275)-(279).
 *
 * Matrices are column-major. With P_r J P_cᵀ = [L; L_R][U U_R] the pivot rows are the primary constraints, the
 * pivot columns the dependent coordinates; B = U⁻¹U_R, q̇_d = −B q̇_i, N = [−B; I]. */
#ifndef KM_PARTITION_PARTITION_H
#define KM_PARTITION_PARTITION_H

#include "base/memory.h"

#include <stdbool.h>

/* The result of a factorisation, with its evidence. */
typedef struct km_partition {
  int rows, columns; /* of the matrix */
  int rank;
  int *row;     /* [rows] row[0 … rank-1] are the primary constraints, in pivot order */
  int *column;  /* [columns] first the dependent coordinates in pivot order, then the independent ones */
  double *lu;   /* [columns × rows, leading dimension `rows`] L (unit diagonal, below) and U, U_R of the primary rows */
  double *B;    /* [freedom × rank, leading dimension `rank`] */
  double scale; /* largest entry of the matrix */
  double first_pivot, last_pivot, first_dropped; /* magnitudes; first_dropped 0: nothing was left */
  double largest_b, pivoted_b; /* max |B_ij|, and its value when pivots were last searched */
  int sign;                    /* of the product of the pivots: flips where det of the pivot block does */
  unsigned searches;           /* how often pivots were searched */
  bool forced_dependent;       /* a column that should be independent had to be a pivot */
} km_partition;

/* Space for matrices of up to rows × columns; false (and arena->failed) when out of memory. */
bool km_partition_reserve(km_partition *partition, int rows, int columns, km_arena *arena);

/* Complete pivoting. Pivots stop at |pivot| ≤ tolerance · (largest entry). Columns with forced[c] (may be
 * NULL) stay independent while the others can give full rank. `matrix` is kept. O(rows·columns·rank). */
void km_partition_factor(km_partition *partition, const double *matrix, int rows, int columns,
                         const bool *forced, double tolerance);

/* The same pivots on new values, primary rows only, no search. False where max |B| passes twice its value at
 * the last search (or a pivot vanishes): then factor again. O(rank²·columns). */
bool km_partition_refactor(km_partition *partition, const double *matrix);

static inline int km_partition_freedom(const km_partition *p) { return p->columns - p->rank; }

/* Particular solution of the primary rows of J x = rhs with the independent coordinates 0.
 * rhs[rows], x[columns]. */
void km_partition_solve(const km_partition *partition, const double *rhs, double *x);

/* Orthonormal basis Z of diag(weight)·range(N), of its first `count` independent coordinates only (the forced
 * ones come last): Z[count × columns, leading dimension columns], rows in the matrix's column order. The basis
 * is not unique, its range is. */
void km_partition_null(const km_partition *partition, const double *weight, int count, double *Z);

/* The null vector that moves independent column `column` by 1 and the other independent ones not at all. */
void km_partition_direction(const km_partition *partition, int column, double *direction);

/* Mobility numbers m_j = Σ_k Z_jk², (278). */
void km_mobility_numbers(const double *Z, int columns, int freedom, double *numbers);

#endif
