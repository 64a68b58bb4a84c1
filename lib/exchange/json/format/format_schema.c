/* The format table as a JSON schema. */
#include "exchange/json/format/format.h"
#include "model/joint_type.h"

#include <string.h>

typedef struct schema {
  km_arena *arena;
  km_value *definitions;
} schema;

static void type(const schema *s, km_value *object, const char *name) {
  km_value_string(s->arena, object, "type", name);
}

static km_value *member(const schema *s, km_value *object, const char *key) {
  return km_value_add(s->arena, object, key, KM_OBJECT);
}

/* {"type": "array", "items": …}; most 0: any number of them. Returns the items' schema. */
static km_value *list_between(const schema *s, km_value *object, int least, int most) {
  type(s, object, "array");
  if (most) {
    km_value_number(s->arena, object, "minItems", least);
    km_value_number(s->arena, object, "maxItems", most);
  }
  return member(s, object, "items");
}

static km_value *list(const schema *s, km_value *object, int count) {
  return list_between(s, object, count, count);
}

static void reference(const schema *s, km_value *object, const char *name) {
  char text[64] = "#/$defs/";
  strncat(text, name, sizeof text - 9);
  km_value_string(s->arena, object, "$ref", text);
}

static void number(const schema *s, km_value *object) {
  reference(s, object, "number");
}

static void numbers(const schema *s, km_value *object, int count) {
  number(s, list(s, object, count));
}

static void path(const schema *s, km_value *object) {
  reference(s, object, "path");
}

/* "anyOf" with two alternatives. */
static void either(const schema *s, km_value *object, km_value **a, km_value **b) {
  km_value *options = km_value_add(s->arena, object, "anyOf", KM_LIST);
  *a = km_value_add(s->arena, options, NULL, KM_OBJECT);
  *b = km_value_add(s->arena, options, NULL, KM_OBJECT);
}

static void either_text_or(const schema *s, km_value *object, const char *name) {
  km_value *a, *b;
  either(s, object, &a, &b);
  type(s, a, "string");
  reference(s, b, name);
}

static void coordinates(const schema *s, km_value *object) {
  km_value *a, *b;
  either(s, object, &a, &b);
  number(s, a);
  numbers(s, b, 0);
}

static void words(const schema *s, km_value *object, const km_object_format *format, const char *key) {
  static const char *const versions[] = {"0.2", "1.0", "1.1", "1.2", NULL};
  km_value *list_of = NULL;
  if (format == &km_format_joint && strcmp(key, "type") == 0) {
    list_of = km_value_add(s->arena, object, "enum", KM_LIST);
    for (int t = 0; t < KM_JOINT_TYPES; ++t)
      km_value_string(s->arena, list_of, NULL, km_joint_kind_of((km_joint_type)t)->word);
    km_value_string(s->arena, list_of, NULL, "revolute");
    km_value_string(s->arena, list_of, NULL, "prismatic");
  } else if (strcmp(key, "drawn") == 0) {
    km_value_string(s->arena, km_value_add(s->arena, object, "enum", KM_LIST), NULL, "assembled");
  } else if (strcmp(key, "version") == 0) {
    list_of = km_value_add(s->arena, object, "enum", KM_LIST);
    for (const char *const *v = versions; *v; ++v)
      km_value_string(s->arena, list_of, NULL, *v);
  } else if (strcmp(format->name, "units") == 0) {
    list_of = km_value_add(s->arena, object, "enum", KM_LIST);
    for (int q = 0; q < KM_QUANTITIES; ++q)
      for (const km_unit *u = km_quantity_units((km_quantity)q);
           u->word && strcmp(km_quantity_name((km_quantity)q), key) == 0; ++u) {
        km_value_string(s->arena, list_of, NULL, u->word);
        km_value_string(s->arena, list_of, NULL, u->suffix);
      }
  } else {
    type(s, object, "string");
  }
}

static void define(const schema *s, const km_object_format *format);

/* Description of a key for the tables of the guide. */
static void explain(const schema *s, km_value *object, const km_field *field) {
  km_text text = {0}, unit = {0};
  km_field_unit_text(field, &unit);
  km_text_add(&text, field->help);
  if (unit.size)
    km_text_format(&text, " Unit: %s.", unit.data);
  if (field->unstated)
    km_text_format(&text, " Without it: %s.", field->unstated);
  text.failed = text.failed || unit.failed;
  km_text_free(&unit);
  const char *words = km_text_move_to_arena(&text, s->arena);
  km_value_string(s->arena, object, "description", words ? words : "");
}

static void describe(const schema *s, km_value *object, const km_object_format *format, const km_field *field) {
  km_value *a, *b;
  explain(s, object, field);
  switch (field->shape) {
  case KM_SHAPE_NUMBER:
    number(s, object);
    break;
  case KM_SHAPE_STRING:
    words(s, object, format, field->key);
    break;
  case KM_SHAPE_BOOLEAN:
    type(s, object, "boolean");
    break;
  case KM_SHAPE_VECTOR:
    numbers(s, object, 3);
    break;
  case KM_SHAPE_POINT:
    number(s, list_between(s, object, 2, 3));
    break;
  case KM_SHAPE_MATRIX:
    numbers(s, list(s, object, 3), 3);
    break;
  case KM_SHAPE_NUMBERS:
    numbers(s, object, 0);
    break;
  case KM_SHAPE_COORDINATES:
    coordinates(s, object);
    break;
  case KM_SHAPE_RANGE:
    numbers(s, object, 2);
    break;
  case KM_SHAPE_RANGES:
    either(s, object, &a, &b);
    numbers(s, a, 2);
    numbers(s, list(s, b, 0), 2);
    break;
  case KM_SHAPE_ROWS:
    numbers(s, list(s, object, 0), 0);
    break;
  case KM_SHAPE_TIME_LAW:
    either(s, object, &a, &b);
    coordinates(s, a);
    numbers(s, list(s, b, 0), 2);
    break;
  case KM_SHAPE_EXPRESSION:
    type(s, object, "string");
    break;
  case KM_SHAPE_STRINGS:
  case KM_SHAPE_PATH:
    path(s, object);
    break;
  case KM_SHAPE_PATHS:
    path(s, list(s, object, 0));
    break;
  case KM_SHAPE_PATH_PAIR:
    path(s, list(s, object, 2));
    break;
  case KM_SHAPE_COORDINATE_MAP:
    type(s, object, "object");
    coordinates(s, member(s, object, "additionalProperties"));
    break;
  case KM_SHAPE_VALUE_MAPS:
    type(s, object, "object");
    a = member(s, object, "additionalProperties");
    type(s, a, "object");
    number(s, member(s, a, "additionalProperties"));
    break;
  case KM_SHAPE_TEXT_MAP:
    type(s, object, "object");
    type(s, member(s, object, "additionalProperties"), "string");
    break;
  case KM_SHAPE_MAP:
    type(s, object, "object");
    reference(s, member(s, object, "additionalProperties"), field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_LIST_MAP:
  case KM_SHAPE_WORD_MAP:
    type(s, object, "object");
    either(s, member(s, object, "additionalProperties"), &a, &b);
    if (field->shape == KM_SHAPE_LIST_MAP)
      numbers(s, a, 0);
    else
      type(s, a, "string");
    reference(s, b, field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_POSES:
    type(s, object, "object");
    a = member(s, object, "additionalProperties");
    type(s, a, "object");
    coordinates(s, member(s, a, "additionalProperties"));
    break;
  case KM_SHAPE_OBJECT:
    reference(s, object, field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_OBJECTS:
    reference(s, list(s, object, 0), field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_PARAMETERS:
    type(s, object, "object");
    either(s, member(s, object, "additionalProperties"), &a, &b);
    number(s, a);
    reference(s, b, field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_METHODS:
    either(s, object, &a, &b);
    either_text_or(s, a, field->object->name);
    either_text_or(s, list(s, b, 0), field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_END:
    either(s, object, &a, &b);
    path(s, a);
    reference(s, b, field->object->name);
    define(s, field->object);
    break;
  case KM_SHAPE_ANY:
    break;
  }
}

static void describe_object(const schema *s, km_value *object, const km_object_format *format) {
  type(s, object, "object");
  km_value *properties = member(s, object, "properties"), *required = NULL;
  for (const km_field *field = format->fields; field->key && !s->arena->failed; ++field)
    describe(s, member(s, properties, field->key), format, field);
  for (const km_field *field = format->fields; field->key; ++field) {
    if (!field->required)
      continue;
    if (!required)
      required = km_value_add(s->arena, object, "required", KM_LIST);
    km_value_string(s->arena, required, NULL, field->key);
  }
}

static void define(const schema *s, const km_object_format *format) {
  if (s->arena->failed || km_value_get(s->definitions, format->name))
    return;
  describe_object(s, member(s, s->definitions, format->name), format);
}

const km_value *km_format_schema(const km_object_format *format, const char *title, bool expressions, km_arena *arena) {
  km_value *root = km_value_add(arena, NULL, NULL, KM_OBJECT);
  km_value_string(arena, root, "$schema", "https://json-schema.org/draft/2020-12/schema");
  km_value_string(arena, root, "title", title);
  schema s = {arena, km_value_add(arena, NULL, NULL, KM_OBJECT)};
  if (arena->failed)
    return NULL;
  km_value *a, *b;
  either(&s, member(&s, s.definitions, "path"), &a, &b);
  type(&s, a, "string");
  type(&s, list(&s, b, 0), "string");
  if (expressions) {
    either(&s, member(&s, s.definitions, "number"), &a, &b);
    type(&s, a, "number");
    type(&s, b, "string");
  } else {
    type(&s, member(&s, s.definitions, "number"), "number");
  }
  describe_object(&s, root, format);
  if (arena->failed)
    return NULL;
  s.definitions->key = "$defs";
  root->last->next = s.definitions;
  root->last = s.definitions;
  root->count++;
  return root;
}
