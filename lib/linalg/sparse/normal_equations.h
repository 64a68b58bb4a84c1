/* Least solutions by the normal equations of a matrix with few entries, several times as fast as by Q R: SuiteSparse's CHOLMOD
 * factors them (Y. Chen, T. Davis, W. Hager, S. Rajamanickam, Algorithm 887, 2008), loaded when it is first needed. The order
 * of elimination is found once for all matrices of a pattern. Private to partition/. */
#ifndef KM_LINALG_SPARSE_NORMAL_EQUATIONS_H
#define KM_LINALG_SPARSE_NORMAL_EQUATIONS_H

#include "linalg/partition.h"

/* Is the library there? It is loaded. */
bool km_normal_equations_is_installed(void);

/* For matrices in which column c can have entries in the rows row[start[c] … start[c+1]-1]. NULL where the library isn't
 * installed or memory is out. */
km_normal_equations *km_normal_equations_create(int rows, int columns, const int *start, const int *row);

/* All rows in the order that nested dissection of their products finds (METIS), whatever is used: found once. NULL: no memory. */
const long *km_normal_equations_dissection(km_normal_equations *normal);

/* A is the matrix, given by its entries, over the columns' weights. What isn't `used` counts as 0: rows and columns. False
 * where the rows that are used depend on each other. What was factored last isn't factored again. O(entries of the factor). */
bool km_normal_equations_factor(km_normal_equations *normal, const double *matrix, const double *weight,
                                const bool *used_rows, const bool *used_columns);
/* Was what was factored last of these rows and columns? */
bool km_normal_equations_is_factored(const km_normal_equations *normal, const bool *used_rows,
                                     const bool *used_columns);
/* About the smallest singular value of A in the rows that are used, over its largest entry; 0 where it can't be found. */
double km_normal_equations_smallest_singular_value(km_normal_equations *normal);
/* The x[columns] of least |x| with A x = b[rows] in the rows that are used. Corrected until nothing but rounding is left to
 * correct; false where that takes long, since the equations square the condition of A: then Q R is needed. */
bool km_normal_equations_minimum_norm(km_normal_equations *normal, const double *b, double *x);
/* The same with b = A y: what the rows have of y[columns]. */
bool km_normal_equations_project(km_normal_equations *normal, const double *y, double *x);

#endif
