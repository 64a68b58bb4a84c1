#include "base/json.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

static km_value *convert(km_arena *arena, km_value *parent, const char *key, const json_t *json) {
  switch (json_typeof(json)) {
  case JSON_OBJECT: {
    km_value *object = km_value_add(arena, parent, key, KM_OBJECT);
    const char *name;
    json_t *member;
    json_object_foreach((json_t *)(size_t)json, name, member) {
      if (object)
        convert(arena, object, name, member);
    }
    return object;
  }
  case JSON_ARRAY: {
    km_value *list = km_value_add(arena, parent, key, KM_LIST);
    size_t count = json_array_size(json);
    for (size_t i = 0; list && i < count; ++i)
      convert(arena, list, NULL, json_array_get(json, i));
    return list;
  }
  case JSON_STRING:
    return km_value_string(arena, parent, key, json_string_value(json));
  case JSON_INTEGER:
  case JSON_REAL:
    return km_value_number(arena, parent, key, json_number_value(json));
  case JSON_TRUE:
    return km_value_boolean(arena, parent, key, 1);
  case JSON_FALSE:
    return km_value_boolean(arena, parent, key, 0);
  default:
    return km_value_add(arena, parent, key, KM_NULL);
  }
}

km_status km_json_parse(const char *bytes, size_t size, km_arena *arena, const km_value **root, km_error *error) {
  static const char mark[] = "\xEF\xBB\xBF";
  if (size >= 3 && memcmp(bytes, mark, 3) == 0) {
    bytes += 3;
    size -= 3;
  }
  json_error_t problem;
  json_t *json = json_loadb(bytes, size, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_DECODE_ANY, &problem);
  if (!json)
    return km_fail(error, KM_MODEL, "line %d, column %d: %s; expected JSON text", problem.line, problem.column,
                   problem.text);
  *root = convert(arena, NULL, NULL, json);
  json_decref(json);
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory while reading JSON") : KM_OK;
}

static void write_string(const char *string, km_text *out) {
  km_text_bytes(out, "\"", 1);
  for (const char *c = string; *c; ++c) {
    if (*c == '"' || *c == '\\')
      km_text_format(out, "\\%c", *c);
    else if (*c == '\n')
      km_text_add(out, "\\n");
    else if ((unsigned char)*c < 0x20)
      km_text_format(out, "\\u%04x", (unsigned)*c);
    else
      km_text_bytes(out, c, 1);
  }
  km_text_bytes(out, "\"", 1);
}

static int is_flat(const km_value *list) {
  for (const km_value *member = list->first; member; member = member->next)
    if (member->kind == KM_OBJECT || (member->kind == KM_LIST && !is_flat(member)))
      return 0;
  return 1;
}

static void indent(km_text *out, int level) {
  km_text_bytes(out, "\n", 1);
  for (int i = 0; i < level; ++i)
    km_text_bytes(out, "  ", 2);
}

static void write_value(const km_value *value, int level, km_text *out);

static void write_members(const km_value *value, int level, int flat, km_text *out) {
  for (const km_value *member = value->first; member; member = member->next) {
    if (!flat)
      indent(out, level + 1);
    if (member->key) {
      write_string(member->key, out);
      km_text_add(out, ": ");
    }
    write_value(member, level + 1, out);
    if (member->next)
      km_text_add(out, flat ? ", " : ",");
  }
  if (!flat && value->first)
    indent(out, level);
}

static void write_value(const km_value *value, int level, km_text *out) {
  switch (value->kind) {
  case KM_NULL:
    km_text_add(out, "null");
    break;
  case KM_BOOLEAN:
    km_text_add(out, value->number != 0.0 ? "true" : "false");
    break;
  case KM_NUMBER:
    if (isfinite(value->number))
      km_text_number(out, value->number);
    else
      km_text_add(out, "null");
    break;
  case KM_STRING:
    write_string(value->string, out);
    break;
  case KM_LIST:
    km_text_add(out, "[");
    write_members(value, level, is_flat(value), out);
    km_text_add(out, "]");
    break;
  case KM_OBJECT:
    km_text_add(out, "{");
    write_members(value, level, 0, out);
    km_text_add(out, "}");
    break;
  }
}

void km_json_write(const km_value *value, km_text *out) {
  write_value(value, 0, out);
  km_text_add(out, "\n");
}
