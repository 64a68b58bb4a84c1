/* Tables inside of the library: kmech/table.h, and rows that aren't filled first. */
#ifndef KM_BASE_TABLE_H
#define KM_BASE_TABLE_H

#include "kmech/table.h"

/* Several km_table_add_row for a caller that sets every cell: what they hold at first is anything. */
double *km_table_add_raw_rows(km_table *table, size_t count);

#endif
