/* JSON text to trees of values and back. */
#ifndef KM_EXCHANGE_JSON_JSON_H
#define KM_EXCHANGE_JSON_JSON_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/status.h"

/* Parses `size` bytes (a byte order mark is skipped). Duplicate keys, NaN, numbers out of range, strings
 * with NUL and nesting past the parser's limit are errors with line and column. The tree lives in `arena`. */
km_status km_json_parse(const char *bytes, size_t size, km_arena *arena, const km_value **root, km_error *error);
/* The same as a tree that may be changed. */
km_status km_json_parse_open(const char *bytes, size_t size, km_arena *arena, km_value **root, km_error *error);

/* Appends the record as text, two spaces a level; lists of scalars stay on one line. Numbers that are not
 * finite are written as null. */
void km_json_write(const km_value *value, km_text *out);

#endif
