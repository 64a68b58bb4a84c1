/* Data: trees of values, which JSON text holds, and tables of numbers with named columns and units. */
#ifndef KMECH_DATA_H
#define KMECH_DATA_H

#include "kmech/base.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Records: named scalars, lists and objects as one ordered tree, which is what JSON holds; and JSON text. */

/* What a value is. */
typedef enum km_kind {
  KM_NULL,    /* nothing; a number that isn't finite */
  KM_BOOLEAN, /* true or false */
  KM_NUMBER,  /* a double */
  KM_STRING,  /* text */
  KM_LIST,    /* values in order */
  KM_OBJECT   /* values with keys, in order */
} km_kind;

/* A tree lives in an arena and is freed with it. */
typedef struct km_value {
  km_kind kind;                         /* which members count */
  const char *key;                      /* inside an object, else NULL */
  double number;                        /* KM_NUMBER; KM_BOOLEAN: 0 or 1 */
  const char *string;                   /* KM_STRING; else NULL */
  struct km_value *first, *last, *next; /* members of a list or an object, and the next sibling */
  size_t count;                         /* of the members */
} km_value;

/* Each adds a member to `parent` (key NULL for a list; parent NULL for a root) and returns it, NULL when out of memory. A
 * parent that is NULL because an earlier call failed is caught by the arena's flag. Texts are copied. A `number`, a `string`: the member's value. */
KM_API km_value *km_value_add(km_arena *arena, km_value *parent, const char *key, km_kind kind);
KM_API km_value *km_value_number(km_arena *arena, km_value *parent, const char *key, double number);
KM_API km_value *km_value_string(km_arena *arena, km_value *parent, const char *key, const char *string);
/* The text's words; frees it. */
KM_API km_value *km_value_words(km_arena *arena, km_value *parent, const char *key, km_text *text);
/* `truth`: 0 is false. */
KM_API km_value *km_value_boolean(km_arena *arena, km_value *parent, const char *key, int truth);
/* A list of numbers. */
KM_API km_value *km_value_numbers(km_arena *arena, km_value *parent, const char *key, const double *numbers,
                                  size_t count);
/* The member of that key; NULL if there is none. O(members). */
KM_API const km_value *km_value_get(const km_value *object, const char *key);

/* Parses `size` bytes of JSON (a byte order mark is skipped). Duplicate keys, NaN, numbers out of range, strings with NUL
 * and nesting past 2048 are KM_MODEL, with line and column. The tree lives in `arena`. O(bytes). */
KM_API km_status km_json_parse(const char *bytes, size_t size, km_arena *arena, const km_value **root, km_error *error);
/* Appends the record as text, two spaces a level; lists of scalars stay on one line. Numbers that are not finite are
 * written as null. O(bytes). */
KM_API void km_json_write(const km_value *value, km_text *out);

/* ---- A table of numbers with named columns and units: what sweeps give and reports write. */

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
