/* Products of the rows of a sparse matrix, A Aᵀ, in a given order of its rows. The entries of A that each product sums
 * are listed once per pattern. Private to linalg/. */
#ifndef KM_LINALG_SPARSE_ROW_PRODUCTS_H
#define KM_LINALG_SPARSE_ROW_PRODUCTS_H

#include "base/memory.h"

#include <stdbool.h>

/* Indices of two entries of A that are multiplied. */
typedef struct km_factors {
  int first, second;
} km_factors;

/* One triangle of A Aᵀ: row r has index position[r]. The lower triangle has the entry of a pair of rows in the column
 * of the earlier row, the upper one in the column of the later row. */
typedef struct km_row_products {
  long rows, *start, *row; /* pattern of A Aᵀ by column, ascending: row[start[k] … start[k+1]-1] */
  double *value;
  long *diagonal;   /* [rows] index of the diagonal entry of each row of A */
  long *pair_start; /* [entries + 1] entry i sums the products pair[pair_start[i]] … pair[pair_start[i+1]-1] */
  km_factors *pair;
} km_row_products;

/* Creates the lists for matrices whose column c has entries in the rows row[start[c] … start[c+1]-1]. `upper`: the
 * triangle above the diagonal, else that below. False when out of memory; free it then too. */
bool km_row_products_create(int rows, int columns, const int *start, const int *row, const long *position, bool upper,
                            km_row_products *out);
void km_row_products_free(km_row_products *products);
/* Computes A Aᵀ of the entries, O(pairs). An unused row, whose entries must be 0, has the diagonal entry 1. */
void km_row_products_compute(km_row_products *products, const double *entries, const bool *used_rows);

#endif
