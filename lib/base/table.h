/* Tables inside of the library: kmech/data.h, rows that aren't filled first, and where a column is least. */
#ifndef KM_BASE_TABLE_H
#define KM_BASE_TABLE_H

#include "kmech/data.h"

/* Appends a column called prefix + name + suffix; false when out of memory. */
bool km_table_join_column(km_table *table, const char *prefix, const char *name, const char *suffix, const char *unit);
/* No rows and no columns, but the memory of both: whoever adds the same columns again gets them without any work. NULL: a new
 * table, NULL when out of memory. */
km_table *km_table_begin_again(km_table *table);

/* Several km_table_add_row for a caller that sets every cell: what they hold at first is anything. */
double *km_table_add_raw_rows(km_table *table, size_t count);
/* Takes the last row away: what was to stand in it can't be found. */
void km_table_drop_row(km_table *table);

/* The first row of a column's smallest value, of its largest with sign −1; the number of rows where none has a value. */
size_t km_table_extreme_row(const km_table *table, size_t column, double sign);

#endif
