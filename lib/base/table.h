/* Tables inside of the library: kmech/table.h, rows that aren't filled first, and where a column is least. */
#ifndef KM_BASE_TABLE_H
#define KM_BASE_TABLE_H

#include "kmech/table.h"

/* Several km_table_add_row for a caller that sets every cell: what they hold at first is anything. */
double *km_table_add_raw_rows(km_table *table, size_t count);

/* The first row of a column's smallest value, of its largest with sign −1; the number of rows where none has a value. */
size_t km_table_extreme_row(const km_table *table, size_t column, double sign);

#endif
