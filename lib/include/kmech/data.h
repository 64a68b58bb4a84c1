/* Data: trees of values, which JSON text holds, and tables of numbers with named columns and units. */
#ifndef KMECH_DATA_H
#define KMECH_DATA_H

#include "kmech/base.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Trees of values: named scalars, lists and objects in order, as in JSON; and JSON text. */

/* Kind of a value. */
typedef enum km_kind {
  KM_NULL,    /* nothing; a number that isn't finite */
  KM_BOOLEAN, /* true or false */
  KM_NUMBER,  /* a double */
  KM_STRING,  /* text */
  KM_LIST,    /* values in order */
  KM_OBJECT   /* values with keys, in order */
} km_kind;

/* A value. A tree lives in an arena and is freed with it. */
typedef struct km_value {
  km_kind kind;                         /* selects the members that are valid */
  const char *key;                      /* key inside an object, else NULL */
  double number;                        /* the number; 0 or 1 of a KM_BOOLEAN */
  const char *string;                   /* the text of a KM_STRING, else NULL */
  struct km_value *first, *last, *next; /* members of a list or an object, and the next sibling */
  size_t count;                         /* number of members */
} km_value;

/* Adds a member with `key` (NULL in a list) to `parent` (NULL: creates a root) and returns it, NULL when out of
 * memory; a parent that is NULL because an earlier call failed is detected by the arena's `failed`. Texts are
 * copied. `number`, `string`: value of the member. */
KM_API km_value *km_value_add(km_arena *arena, km_value *parent, const char *key, km_kind kind);
KM_API km_value *km_value_number(km_arena *arena, km_value *parent, const char *key, double number);
KM_API km_value *km_value_string(km_arena *arena, km_value *parent, const char *key, const char *string);
/* Adds the text as a string, and frees the text. */
KM_API km_value *km_value_words(km_arena *arena, km_value *parent, const char *key, km_text *text);
/* Adds a boolean; `truth` 0 is false. */
KM_API km_value *km_value_boolean(km_arena *arena, km_value *parent, const char *key, int truth);
/* Adds a list of numbers. */
KM_API km_value *km_value_numbers(km_arena *arena, km_value *parent, const char *key, const double *numbers,
                                  size_t count);
/* The member with `key`; NULL if there is none. O(members). */
KM_API const km_value *km_value_get(const km_value *object, const char *key);

/* Parses `size` bytes of JSON (a byte order mark is skipped). Duplicate keys, NaN, numbers out of range, strings
 * with NUL and nesting past 2048 are KM_MODEL, with line and column. The tree lives in `arena`. O(bytes). */
KM_API km_status km_json_parse(const char *bytes, size_t size, km_arena *arena, const km_value **root, km_error *error);
/* Appends the record as text, two spaces a level; lists of scalars stay on one line. Numbers that are not finite are
 * written as null. O(bytes). */
KM_API void km_json_write(const km_value *value, km_text *out);
/* Appends the record on one line. */
KM_API void km_json_write_line(const km_value *value, km_text *out);

/* ---- Tables of numbers with named columns and units. */

/* A table. */
typedef struct km_table km_table;

/* Returns NULL when out of memory. The caller frees the table. */
KM_API km_table *km_table_create(void);
KM_API void km_table_free(km_table *table);
/* Appends a column before the first row is added; unit NULL: dimensionless. Returns its index, -1 when out of
 * memory. */
KM_API int km_table_add_column(km_table *table, const char *name, const char *unit);
/* Like km_table_add_column; the CSV header of the column has no unit (`s`). */
KM_API int km_table_add_plain_column(km_table *table, const char *name, const char *unit);
/* Allocates memory for `rows` rows. False when out of memory. */
KM_API bool km_table_reserve(km_table *table, size_t rows);
/* Appends a row of NaN and returns it; NULL when out of memory. Valid until the next row is added. */
KM_API double *km_table_add_row(km_table *table);

/* Numbers of rows and columns. */
KM_API size_t km_table_rows(const km_table *table);
KM_API size_t km_table_columns(const km_table *table);
KM_API const char *km_table_name(const km_table *table, size_t column); /* borrowed, without unit */
KM_API const char *km_table_unit(const km_table *table, size_t column); /* "": dimensionless */
/* True if the CSV header of the column has no unit. */
KM_API bool km_table_is_plain(const km_table *table, size_t column);
/* Copies a column to values[rows]. KM_USAGE: the column doesn't exist. */
KM_API km_status km_table_column(const km_table *table, size_t column, double *values, km_error *error);
/* CSV by RFC 4180: a header row (name_unit), then the numbers in their shortest exact form with a decimal point.
 * km_table_csv writes as many bytes as fit, with a NUL, into text[size] (may be NULL) and returns the full length
 * without the NUL; 0 when out of memory. km_table_write_csv writes a file. KM_IO, KM_MEMORY. */
KM_API size_t km_table_csv(const km_table *table, char *text, size_t size);
KM_API km_status km_table_write_csv(const km_table *table, const char *path, km_error *error);
KM_API const double *km_table_row(const km_table *table, size_t row); /* borrowed */
/* Index of the column with `name` (without unit); -1 if there is none. */
KM_API int km_table_find(const km_table *table, const char *name);

/* Adjacent columns of one kind: index of the first, and their number. */
typedef struct km_span {
  size_t first, count; /* 0 if there are none */
} km_span;
/* The columns whose names begin with `prefix` ("q."); count 0 if there are none. */
KM_API km_span km_table_span(const km_table *table, const char *prefix);

/* Figure of merit of a column over the rows. */
typedef enum km_figure {
  KM_FIGURE_MIN,     /* minimum */
  KM_FIGURE_MAX,     /* maximum */
  KM_FIGURE_SPAN,    /* maximum − minimum */
  KM_FIGURE_MEAN,    /* mean: 1/S ∫ y ds by the trapezoidal rule */
  KM_FIGURE_AT,      /* value at a given s, by linear interpolation between rows */
  KM_FIGURE_RMS,     /* root mean square: sqrt(1/S ∫ y² ds), y linear between rows */
  KM_FIGURE_PEAK,    /* largest magnitude */
  KM_FIGURE_LAST,    /* value of the last row that has one */
  KM_FIGURE_SETTLING /* s from which on y stays within `at` times its largest distance from its last value */
} km_figure;
/* Returns the variable s of a table's rows: the column "s" of a sweep or a track, "t" of a motion over time; -1: neither
 * exists. */
KM_API int km_table_variable(const km_table *table);
/* Computes a figure of merit of a column over the table's variable s. NaN rows are skipped; a mean with an infinite
 * value is infinite. `at`: the s of KM_FIGURE_AT, the fraction of KM_FIGURE_SETTLING (0.02: to 2 %). `where` (may be
 * NULL): s of the extremum, of the peak, of the last value; NaN of other figures. The result is NaN if no row has a
 * value, `at` lies outside the rows, or the fraction isn't between 0 and 1. Settling is measured from the first row's
 * s; the crossing of the bound is linear between rows. KM_USAGE: the column doesn't exist. O(rows). */
KM_API km_status km_table_figure(const km_table *table, const char *column, km_figure figure, double at, double *value,
                                 double *where, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
