/* Records: named scalars, lists and objects as one ordered tree, which is what JSON holds; and JSON text. */
#ifndef KMECH_VALUE_H
#define KMECH_VALUE_H

#include "kmech/text.h"

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif
#endif
