/* Trees of values. */
#include "base/value.h"

#include <string.h>

km_value *km_value_add(km_arena *arena, km_value *parent, const char *key, km_kind kind) {
  if (!arena)
    return NULL;
  km_value *value = KM_ARENA_NEW(arena, km_value, 1);
  char *name = km_arena_string(arena, key);
  if (arena->failed)
    return NULL;
  value->kind = kind;
  value->key = name;
  if (parent) {
    if (parent->last)
      parent->last->next = value;
    else
      parent->first = value;
    parent->last = value;
    parent->count++;
  }
  return value;
}

km_value *km_value_number(km_arena *arena, km_value *parent, const char *key, double number) {
  km_value *value = km_value_add(arena, parent, key, KM_NUMBER);
  if (value)
    value->number = number;
  return value;
}

km_value *km_value_string(km_arena *arena, km_value *parent, const char *key, const char *string) {
  char *copy = km_arena_string(arena, string);
  km_value *value = km_value_add(arena, parent, key, KM_STRING);
  if (value)
    value->string = copy ? copy : "";
  return value;
}

km_value *km_value_words(km_arena *arena, km_value *parent, const char *key, km_text *text) {
  if (!arena)
    return NULL;
  const char *words = km_text_move_to_arena(text, arena);
  return arena->failed ? NULL : km_value_string(arena, parent, key, words);
}

km_value *km_value_boolean(km_arena *arena, km_value *parent, const char *key, int truth) {
  km_value *value = km_value_add(arena, parent, key, KM_BOOLEAN);
  if (value)
    value->number = truth ? 1.0 : 0.0;
  return value;
}

km_value *km_value_numbers(km_arena *arena, km_value *parent, const char *key, const double *numbers, size_t count) {
  km_value *list = km_value_add(arena, parent, key, KM_LIST);
  for (size_t i = 0; numbers && i < count; ++i)
    km_value_number(arena, list, NULL, numbers[i]);
  return list;
}

const km_value *km_value_get(const km_value *object, const char *key) {
  if (!object || !key || object->kind != KM_OBJECT)
    return NULL;
  for (const km_value *member = object->first; member; member = member->next)
    if (member->key && strcmp(member->key, key) == 0)
      return member;
  return NULL;
}

const char *km_kind_name(km_kind kind) {
  static const char *const names[] = {"null", "true or false", "a number", "a string", "a list", "an object"};
  return names[kind];
}
