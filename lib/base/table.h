/* Table functions of the library beyond kmech/data.h. */
#ifndef KM_BASE_TABLE_H
#define KM_BASE_TABLE_H

#include "kmech/data.h"

/* Appends a column named prefix + name + suffix. False when out of memory. */
bool km_table_add_joined_column(km_table *table, const char *prefix, const char *name, const char *suffix,
                                const char *unit);
/* Restarts a table: without rows and columns, but with their memory, so that adding equal columns again costs
 * nothing. NULL creates a table. Returns NULL when out of memory. */
km_table *km_table_restart(km_table *table);

/* Appends `count` rows with undefined contents, for a caller that sets every cell. */
double *km_table_add_raw_rows(km_table *table, size_t count);
/* The cells of a row, to be changed; NULL if there is no such row. */
double *km_table_cells(km_table *table, size_t row);
/* Removes the last row. */
void km_table_drop_row(km_table *table);

/* The first row with the column's smallest value (sign 1) or largest value (sign −1); the number of rows if no row
 * has a value. */
size_t km_table_extreme_row(const km_table *table, size_t column, double sign);

#endif
