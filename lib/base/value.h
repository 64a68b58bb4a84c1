/* Records: named scalars, lists and objects as one ordered tree. What JSON holds, and what analyses hand
 * to the report writers. A tree lives in an arena and is freed with it. */
#ifndef KM_BASE_VALUE_H
#define KM_BASE_VALUE_H

#include "base/text.h"

typedef enum km_kind { KM_NULL, KM_BOOLEAN, KM_NUMBER, KM_STRING, KM_LIST, KM_OBJECT } km_kind;

typedef struct km_value {
  km_kind kind;
  const char *key; /* inside an object, else NULL */
  double number;   /* KM_NUMBER; KM_BOOLEAN: 0 or 1 */
  const char *string;
  struct km_value *first, *last, *next; /* members of a list or an object, and the next sibling */
  size_t count;
} km_value;

/* Each adds a member to `parent` (key NULL for a list; parent NULL for a root) and returns it, NULL when
 * out of memory. A parent that is NULL because an earlier call failed is caught by the arena's flag. */
km_value *km_value_add(km_arena *arena, km_value *parent, const char *key, km_kind kind);
km_value *km_value_number(km_arena *arena, km_value *parent, const char *key, double number);
km_value *km_value_string(km_arena *arena, km_value *parent, const char *key, const char *string);
/* The text's words; frees it. */
km_value *km_value_words(km_arena *arena, km_value *parent, const char *key, km_text *text);
km_value *km_value_boolean(km_arena *arena, km_value *parent, const char *key, int truth);
/* A list of numbers. */
km_value *km_value_numbers(km_arena *arena, km_value *parent, const char *key, const double *numbers, size_t count);

const km_value *km_value_get(const km_value *object, const char *key); /* NULL if absent */
const char *km_kind_name(km_kind kind);                                /* "a number", … */

#endif
