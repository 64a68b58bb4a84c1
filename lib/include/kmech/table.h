/* A table of numbers with named columns and units: what sweeps give and reports write. */
#ifndef KMECH_TABLE_H
#define KMECH_TABLE_H

#include "kmech/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct km_table km_table;

/* NULL when out of memory. The caller frees it. */
km_table *km_table_create(void);
void km_table_free(km_table *table);
/* Appends a column before the first row is added; unit NULL: dimensionless. Returns its index, -1 when out of
 * memory. */
int km_table_add_column(km_table *table, const char *name, const char *unit);
/* The same for a column whose header has no unit in CSV (`s`); its unit is known all the same. */
int km_table_add_plain_column(km_table *table, const char *name, const char *unit);
/* A new row, filled with NaN; NULL when out of memory. Valid until the next row. */
double *km_table_add_row(km_table *table);

size_t km_table_rows(const km_table *table);
size_t km_table_columns(const km_table *table);
const char *km_table_name(const km_table *table, size_t column); /* borrowed, without unit */
const char *km_table_unit(const km_table *table, size_t column); /* "": dimensionless */
int km_table_is_plain(const km_table *table, size_t column);
const double *km_table_row(const km_table *table, size_t row); /* borrowed */
/* Index of a column by its name without unit, -1 if there is none. */
int km_table_find(const km_table *table, const char *name);

/* Columns of one kind, side by side: the first one's index and how many there are. */
typedef struct km_span {
  size_t first, count;
} km_span;
/* The columns whose names begin with `prefix` ("q."); count 0 if there are none. */
km_span km_table_span(const km_table *table, const char *prefix);

#ifdef __cplusplus
}
#endif
#endif
