/* A table of numbers with named columns and units: what sweeps give and reports write. */
#ifndef KMECH_TABLE_H
#define KMECH_TABLE_H

#include "kmech/status.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Rows of numbers in named columns. */
typedef struct km_table km_table;

/* NULL when out of memory. The caller frees it. */
KM_API km_table *km_table_create(void);
KM_API void km_table_free(km_table *table);
/* Appends a column before the first row is added; unit NULL: dimensionless. Returns its index, -1 when out of
 * memory. */
KM_API int km_table_add_column(km_table *table, const char *name, const char *unit);
/* The same for a column whose header has no unit in CSV (`s`); its unit is known all the same. */
KM_API int km_table_add_plain_column(km_table *table, const char *name, const char *unit);
/* Room for so many rows at once, which then needn't grow one by one; false when out of memory. */
KM_API bool km_table_reserve(km_table *table, size_t rows);
/* A new row, filled with NaN; NULL when out of memory. Valid until the next row. */
KM_API double *km_table_add_row(km_table *table);

/* How many rows and columns there are. */
KM_API size_t km_table_rows(const km_table *table);
KM_API size_t km_table_columns(const km_table *table);
KM_API const char *km_table_name(const km_table *table, size_t column); /* borrowed, without unit */
KM_API const char *km_table_unit(const km_table *table, size_t column); /* "": dimensionless */
/* Is the column's header without its unit? */
KM_API bool km_table_is_plain(const km_table *table, size_t column);
/* A whole column: values[rows]. KM_USAGE: there is no such column. */
KM_API km_status km_table_column(const km_table *table, size_t column, double *values, km_error *error);
/* RFC 4180: a header row (name, then _unit), then the numbers in their shortest exact form, whatever the locale. As
 * text: returns how many bytes there are without the closing NUL, and writes as many as fit into text[size] with one
 * (text NULL: none); 0 when out of memory. Or to a file: KM_IO, KM_MEMORY. */
KM_API size_t km_table_csv(const km_table *table, char *text, size_t size);
KM_API km_status km_table_write_csv(const km_table *table, const char *path, km_error *error);
KM_API const double *km_table_row(const km_table *table, size_t row); /* borrowed */
/* Index of a column by its name without unit, -1 if there is none. */
KM_API int km_table_find(const km_table *table, const char *name);

/* Columns of one kind, side by side: the first one's index and how many there are. */
typedef struct km_span {
  size_t first, count; /* 0: there are none */
} km_span;
/* The columns whose names begin with `prefix` ("q."); count 0 if there are none. */
KM_API km_span km_table_span(const km_table *table, const char *prefix);

/* A figure of merit of a column over the rows. */
typedef enum km_figure {
  KM_FIGURE_MIN,  /* the least value */
  KM_FIGURE_MAX,  /* the greatest */
  KM_FIGURE_SPAN, /* max − min */
  KM_FIGURE_MEAN, /* over s, by the trapezoidal rule */
  KM_FIGURE_AT    /* at a given s: between rows by the line through both */
} km_figure;
/* Rows without a value (NaN) don't count; a mean next to an infinite value is infinite. `at`: the s of KM_FIGURE_AT;
 * `where` (may be NULL): s of the extreme. NaN where no row has a value, or `at` lies outside them. KM_USAGE: there is
 * no such column. O(rows). */
KM_API km_status km_table_figure(const km_table *table, const char *column, km_figure figure, double at, double *value,
                                 double *where, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
