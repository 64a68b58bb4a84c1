/* Minimum-norm solutions by the normal equations of a sparse matrix (docs/theory.md 3.5). Private to linalg/.
 *
 *   x = Aᵀ (A Aᵀ)⁻¹ b         A = J D⁻¹ in the used rows and columns
 *
 * A Aᵀ is factored by SuiteSparse's CHOLMOD (Y. Chen and others 2008), loaded at the first use: several times faster
 * than QR. The elimination order is found once per pattern. */
#ifndef KM_LINALG_SPARSE_NORMAL_EQUATIONS_H
#define KM_LINALG_SPARSE_NORMAL_EQUATIONS_H

#include "linalg/factor_private.h"

/* Creates normal equations for matrices whose column c has entries in the rows row[start[c] … start[c+1]-1]. NULL
 * without the library or memory. */
km_normal_equations *km_normal_equations_create(int rows, int columns, const int *start, const int *row);

/* Factors A Aᵀ of the matrix, given by its entries, over the column weights. Unused rows and columns count as 0. False
 * if the used rows are dependent. Equal data are not factored again. O(entries of the factor). */
bool km_normal_equations_factor(km_normal_equations *normal, const double *matrix, const double *weight,
                                const bool *used_rows, const bool *used_columns);
/* Minimum-norm solution x[columns] of A x = b[rows] in the used rows. Refined until only rounding remains; false if
 * refinement converges slowly, since the equations square the condition of A: then QR is needed. */
bool km_normal_equations_minimum_norm(km_normal_equations *normal, const double *b, double *x);
/* Projection of y[columns] onto the row space of A: the minimum-norm solution for b = A y. */
bool km_normal_equations_project(km_normal_equations *normal, const double *y, double *x);

#endif
