#include "base/similar_names.h"
#include "base/text.h"
#include "exchange/json/format/format.h"
#include "exchange/json/json_location.h"
#include "model/curve/expression.h"

#include <math.h>
#include <string.h>

/* Past this a product of a few numbers overflows; no mechanism needs it. */
static const double largest_number = 1e60;

static void expected(km_messages *m, const km_place *place, const km_value *found, const char *what) {
  char where[KM_PLACE_TEXT], number[KM_NUMBER_TEXT];
  km_place_text(place, where);
  if (found->kind == KM_STRING)
    km_messages_add(m, KM_ERROR, "%s: found the string \"%.60s\"; expected %s", where, found->string, what);
  else if (found->kind == KM_NUMBER) {
    km_number_format(number, found->number);
    km_messages_add(m, KM_ERROR, "%s: found %s; expected %s", where, number, what);
  } else if (found->kind == KM_LIST)
    km_messages_add(m, KM_ERROR, "%s: found a list of %zu; expected %s", where, found->count, what);
  else
    km_messages_add(m, KM_ERROR, "%s: found %s; expected %s", where, km_kind_name(found->kind), what);
}

static void check_number(km_messages *m, const km_place *place, const km_value *value) {
  if (value->kind != KM_NUMBER)
    expected(m, place, value, "a number");
  else if (!(fabs(value->number) <= largest_number))
    expected(m, place, value, "a number of magnitude up to 1e60");
}

/* `count` 0: any number of items. */
static void check_numbers(km_messages *m, const km_place *place, const km_value *value, size_t count,
                          const char *what) {
  if (value->kind != KM_LIST || (count && value->count != count)) {
    expected(m, place, value, what);
    return;
  }
  km_place item = {place, NULL, 0};
  for (const km_value *v = value->first; v; v = v->next, ++item.index)
    check_number(m, &item, v);
}

static void check_rows(km_messages *m, const km_place *place, const km_value *value, size_t rows, size_t columns,
                       const char *what) {
  if (value->kind != KM_LIST || (rows && value->count != rows)) {
    expected(m, place, value, what);
    return;
  }
  km_place item = {place, NULL, 0};
  for (const km_value *v = value->first; v; v = v->next, ++item.index)
    check_numbers(m, &item, v, columns, columns ? what : "a list of numbers");
}

static void check_strings(km_messages *m, const km_place *place, const km_value *value, const char *what) {
  if (value->kind == KM_STRING)
    return;
  if (value->kind != KM_LIST || value->count == 0) {
    expected(m, place, value, what);
    return;
  }
  km_place item = {place, NULL, 0};
  for (const km_value *v = value->first; v; v = v->next, ++item.index)
    if (v->kind != KM_STRING)
      expected(m, &item, v, what);
}

static const char path_words[] = "a name or a non-empty list of names";

static void check_paths(km_messages *m, const km_place *place, const km_value *value, size_t count, const char *what) {
  if (value->kind != KM_LIST || (count && value->count != count)) {
    expected(m, place, value, what);
    return;
  }
  km_place item = {place, NULL, 0};
  for (const km_value *v = value->first; v; v = v->next, ++item.index)
    check_strings(m, &item, v, path_words);
}

static void check_coordinates(km_messages *m, const km_place *place, const km_value *value) {
  if (value->kind == KM_LIST)
    check_numbers(m, place, value, 0, "a number, or a list with one number a coordinate");
  else
    check_number(m, place, value);
}

static void check_object(km_messages *m, const km_place *place, const km_value *value, const km_object_format *format);

static void check_objects(km_messages *m, const km_place *place, const km_value *value,
                          const km_object_format *format) {
  if (value->kind != KM_LIST) {
    expected(m, place, value, "a list of objects");
    return;
  }
  km_place item = {place, NULL, 0};
  for (const km_value *v = value->first; v; v = v->next, ++item.index)
    check_object(m, &item, v, format);
}

typedef void checker(km_messages *m, const km_place *place, const km_value *value);

/* An object whose members are all of one kind. */
static void check_members(km_messages *m, const km_place *place, const km_value *value, const char *what,
                          checker *check) {
  if (value->kind != KM_OBJECT) {
    expected(m, place, value, what);
    return;
  }
  for (const km_value *v = value->first; v; v = v->next) {
    km_place item = {place, v->key, 0};
    check(m, &item, v);
  }
}

static void check_map(km_messages *m, const km_place *place, const km_value *value) {
  check_members(m, place, value, "an object {name: value}", check_coordinates);
}

static void check_number_map(km_messages *m, const km_place *place, const km_value *value) {
  check_members(m, place, value, "an object {name: number}", check_number);
}

static void check_poses(km_messages *m, const km_place *place, const km_value *value) {
  check_members(m, place, value, "an object {name: {joint: value}}", check_map);
}

static void check_parameters(km_messages *m, const km_place *place, const km_value *value,
                             const km_object_format *format) {
  if (value->kind != KM_OBJECT) {
    expected(m, place, value, "an object {name: number}");
    return;
  }
  for (const km_value *v = value->first; v; v = v->next) {
    km_place item = {place, v->key, 0};
    if (v->kind == KM_OBJECT)
      check_object(m, &item, v, format);
    else
      check_number(m, &item, v);
  }
}

/* {name: number} under a name, an object, or (wrongly) no text. */
static void check_member(km_messages *m, const km_place *place, const km_value *value, const km_field *field) {
  if (field->shape == KM_SHAPE_TEXT_MAP)
    expected(m, place, value, "a string");
  else if (field->shape == KM_SHAPE_VALUE_MAPS)
    check_number_map(m, place, value);
  else if (value->kind != KM_OBJECT && field->shape == KM_SHAPE_LIST_MAP)
    expected(m, place, value, "a list of numbers, or an object {\"from\": …}");
  else if (value->kind != KM_OBJECT && field->shape == KM_SHAPE_WORD_MAP)
    expected(m, place, value, "a text such as \"min q.A\", or an object {\"figure\": …}");
  else
    check_object(m, place, value, field->object);
}

/* Members in short form are checked by the reader, their numbers here. */
static void check_object_map(km_messages *m, const km_place *place, const km_value *value, const km_field *field) {
  if (value->kind != KM_OBJECT) {
    expected(m, place, value, "an object {name: …}");
    return;
  }
  for (const km_value *v = value->first; v; v = v->next) {
    km_place item = {place, v->key, 0};
    if (field->shape == KM_SHAPE_LIST_MAP && v->kind == KM_LIST)
      check_numbers(m, &item, v, 0, "a list of numbers");
    else if (field->shape == KM_SHAPE_TEXT_MAP ? v->kind != KM_STRING
                                               : field->shape != KM_SHAPE_WORD_MAP || v->kind != KM_STRING)
      check_member(m, &item, v, field);
  }
}

static void check_time_law(km_messages *m, const km_place *place, const km_value *value) {
  if (value->kind == KM_STRING && km_expression_uses(value->string, "t"))
    return;
  if (value->kind != KM_LIST)
    check_number(m, place, value);
  else if (value->first && value->first->kind == KM_LIST)
    check_rows(m, place, value, 0, 2, "a list of rows [time, value]");
  else if (value->first)
    check_numbers(m, place, value, 0, "a number, a list of numbers, or rows [time, value]");
  else
    expected(m, place, value, "a number, a list of numbers, or rows [time, value]");
}

static void check_range(km_messages *m, const km_place *place, const km_value *value, int many) {
  if (many && value->kind == KM_LIST && value->first && value->first->kind == KM_LIST)
    check_rows(m, place, value, 0, 2, "[low, high] for each coordinate");
  else
    check_numbers(m, place, value, 2, "two numbers [low, high]");
}

static void check_field(km_messages *m, const km_place *place, const km_value *value, const km_field *field) {
  switch (field->shape) {
  case KM_SHAPE_NUMBER:
    check_number(m, place, value);
    break;
  case KM_SHAPE_EXPRESSION:
  case KM_SHAPE_STRING:
    if (value->kind != KM_STRING)
      expected(m, place, value, "a string");
    break;
  case KM_SHAPE_BOOLEAN:
    if (value->kind != KM_BOOLEAN)
      expected(m, place, value, "true or false");
    break;
  case KM_SHAPE_VECTOR:
    check_numbers(m, place, value, 3, "three numbers [x, y, z]");
    break;
  case KM_SHAPE_POINT:
    check_numbers(m, place, value, value->count == 2 ? 2 : 3, "three numbers [x, y, z], or two for z = 0");
    break;
  case KM_SHAPE_MATRIX:
    check_rows(m, place, value, 3, 3, "three rows of three numbers");
    break;
  case KM_SHAPE_NUMBERS:
    check_numbers(m, place, value, 0, "a list of numbers");
    break;
  case KM_SHAPE_COORDINATES:
    check_coordinates(m, place, value);
    break;
  case KM_SHAPE_RANGE:
    check_range(m, place, value, 0);
    break;
  case KM_SHAPE_RANGES:
    check_range(m, place, value, 1);
    break;
  case KM_SHAPE_ROWS:
    check_rows(m, place, value, 0, 0, "a list of lists of numbers");
    break;
  case KM_SHAPE_TIME_LAW:
    check_time_law(m, place, value);
    break;
  case KM_SHAPE_STRINGS:
    check_strings(m, place, value, "a string or a list of strings");
    break;
  case KM_SHAPE_PATH:
    check_strings(m, place, value, path_words);
    break;
  case KM_SHAPE_PATHS:
    check_paths(m, place, value, 0, "a list of names, each one name or a list of names from the root");
    break;
  case KM_SHAPE_PATH_PAIR:
    check_paths(m, place, value, 2, "two paths [[parent…, frame], [child…, frame]]");
    break;
  case KM_SHAPE_COORDINATE_MAP:
    check_map(m, place, value);
    break;
  case KM_SHAPE_POSES:
    check_poses(m, place, value);
    break;
  case KM_SHAPE_OBJECT:
    check_object(m, place, value, field->object);
    break;
  case KM_SHAPE_OBJECTS:
    check_objects(m, place, value, field->object);
    break;
  case KM_SHAPE_PARAMETERS:
    check_parameters(m, place, value, field->object);
    break;
  case KM_SHAPE_VALUE_MAPS:
  case KM_SHAPE_TEXT_MAP:
  case KM_SHAPE_MAP:
  case KM_SHAPE_LIST_MAP:
  case KM_SHAPE_WORD_MAP:
    check_object_map(m, place, value, field);
    break;
  case KM_SHAPE_METHODS:
  case KM_SHAPE_END:
  case KM_SHAPE_ANY:
    break;
  }
}

/* True if the help of a field begins with the word, such as "stiffness" with "Stiffness: force per length." */
static bool is_explained_by(const km_field *field, const char *word) {
  const size_t length = strlen(word);
  return strncasecmp(field->help, word, length) == 0 && field->help[length] == ':';
}

static void warn_unknown(km_messages *m, const km_place *place, const km_object_format *format) {
  km_nearest nearest = {.wanted = place->key};
  const char *meant = NULL;
  for (const km_field *field = format->fields; field->key; ++field) {
    km_nearest_add(&nearest, field->key);
    if (is_explained_by(field, place->key))
      meant = field->key;
  }
  char where[KM_PLACE_TEXT];
  km_messages_add(m, KM_WARNING, "%s: the format doesn't know this key; the nearest known one is \"%s\"",
                  km_place_text(place, where), meant ? meant : nearest.names[0]);
}

/* Checks that a joint is defined by frames, or in a drawing by bodies and a point. */
static void check_joint_ends(km_messages *m, const km_place *place, const km_value *joint) {
  char where[KM_PLACE_TEXT];
  if (!km_value_get(joint, "body_frame_pairs") && !km_value_get(joint, "bodies"))
    km_messages_add(m, KM_ERROR,
                    "%s: \"body_frame_pairs\" is missing; expected it in every joint, or \"bodies\" and \"at\" in a "
                    "drawn assembly",
                    km_place_text(place, where));
}

static void check_object(km_messages *m, const km_place *place, const km_value *value, const km_object_format *format) {
  if (value->kind != KM_OBJECT) {
    expected(m, place, value, "an object {…}");
    return;
  }
  for (const km_value *v = value->first; v; v = v->next) {
    km_place item = {place, v->key, 0};
    const km_field *field = km_format_field(format, v->key);
    if (field)
      check_field(m, &item, v, field);
    else
      warn_unknown(m, &item, format);
  }
  for (const km_field *field = format->fields; field->key; ++field) {
    if (!field->required || km_value_get(value, field->key))
      continue;
    char where[KM_PLACE_TEXT];
    km_messages_add(m, KM_ERROR, "%s: \"%s\" is missing; expected it in every %s", km_place_text(place, where),
                    field->key, format->name);
  }
  if (format == &km_format_joint)
    check_joint_ends(m, place, value);
}

void km_format_check_as(const km_value *root, const km_object_format *format, const km_place *place,
                        km_messages *messages) {
  check_object(messages, place, root, format);
}

void km_format_check(const km_value *root, km_messages *messages) {
  km_format_check_as(root, &km_format_model, NULL, messages);
}
