/* The products of a matrix's rows, A Aᵀ in an order of its rows, of one pattern: which entries of A each of them sums is listed once.
 * Private to partition/. */
#ifndef KM_LINALG_SPARSE_ROW_PRODUCTS_H
#define KM_LINALG_SPARSE_ROW_PRODUCTS_H

#include "base/memory.h"

#include <stdbool.h>

/* Two entries of A. */
typedef struct km_factors {
  int first, second;
} km_factors;

/* The products that are kept: place[r] is where row r stands in the order, and of two rows the product is an entry of the row that
 * stands later in the column of the one that stands earlier, or the other way round. */
typedef struct km_row_products {
  long rows, *start, *row; /* of A Aᵀ by column, ascending: row[start[k] … start[k+1]-1] */
  double *value;
  long *diagonal;   /* [rows] of each row of A: the entry of its own square */
  long *pair_start; /* [entries + 1] each entry sums the products pair[pair_start[i]] … pair[pair_start[i+1]-1] */
  km_factors *pair;
} km_row_products;

/* For matrices in which column c can have entries in the rows row[start[c] … start[c+1]-1]. `upper`: the triangle above the diagonal in
 * place of that below. False when out of memory; then, too, it must be freed. */
bool km_row_products_create(int rows, int columns, const int *start, const int *row, const long *place, bool upper,
                            km_row_products *out);
void km_row_products_free(km_row_products *products);
/* The products of the entries, O(pairs); a row that isn't used is orthogonal to all others, with the square 1. Its entries must be
 * 0. */
void km_row_products_compute(km_row_products *products, const double *entries, const bool *used_rows);

#endif
