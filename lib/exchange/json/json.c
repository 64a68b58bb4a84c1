/* JSON text to trees of values. The only user of the JSON library. */
#include "exchange/json/json.h"

#include "base/arguments.h"
#include "base/utf16.h"

#include <ctype.h>
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

static bool is_blank(const char *bytes, size_t size) {
  size_t i = 0;
  while (i < size && bytes[i] && strchr(" \t\r\n", bytes[i]))
    ++i;
  return i == size;
}

/* The likely mistake where jansson gives up: by the last token that it read, which ends at `end`. */
static const char *likely(const char *bytes, size_t size, size_t end) {
  size_t at = end < size ? end : size;
  char token = 0, before = 0;
  while (at > 0 && strchr(" \t\r\n", bytes[at - 1]))
    --at;
  size_t from = at; /* start of the token, searched back to a blank or a JSON delimiter */
  while (from > 0 && !strchr(" \t\r\n,:[]{}\"", bytes[from - 1]))
    --from;
  from -= from == at && from > 0;
  token = bytes[from];
  for (size_t i = from; i > 0 && !before; --i)
    before = strchr(" \t\r\n", bytes[i - 1]) ? 0 : bytes[i - 1];
  static const struct {
    const char *begins, *words;
  } mistakes[] = {{"/", "JSON has no comments"},
                  {"#", "JSON has no comments"},
                  {"'", "JSON has texts in double quotes"},
                  {"\xE2\x80", "JSON has texts in straight double quotes"},
                  {"True", "JSON writes true"},
                  {"False", "JSON writes false"},
                  {"None", "JSON writes null"},
                  {"NaN", "JSON has no NaN"},
                  {"Infinity", "JSON has no infinity"},
                  {"-Infinity", "JSON has no infinity"},
                  {"inf", "JSON has no infinity"},
                  {"+", "JSON has no sign + before a number"},
                  {".", "JSON has a digit before the decimal point"},
                  {"=", "JSON has a colon between a key and its value"}};
  for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; ++i) {
    size_t length = strlen(mistakes[i].begins);
    if (size - from >= length && memcmp(bytes + from, mistakes[i].begins, length) == 0)
      return mistakes[i].words;
  }
  if (before == ',' && (token == '}' || token == ']'))
    return "JSON has no comma before the closing bracket";
  if (at > 0 && bytes[at - 1] == ';')
    return "JSON has commas between values";
  if (strchr("\"{[", token) && before && !strchr(",:[{", before))
    return "a comma is missing before it";
  if (isalpha((unsigned char)token) && (before == '{' || before == ','))
    return "JSON has keys in double quotes";
  return NULL;
}

km_status km_json_parse_open(const char *bytes, size_t size, km_arena *arena, km_value **root, km_error *error) {
  static const char mark[] = "\xEF\xBB\xBF";
  if (size >= 3 && memcmp(bytes, mark, 3) == 0) {
    bytes += 3;
    size -= 3;
  }
  if (km_is_wide(bytes, size))
    return km_fail(error, KM_MODEL, "the text is in UTF-16; expected JSON text in UTF-8");
  if (is_blank(bytes, size))
    return km_fail(error, KM_MODEL, "the text is empty; expected JSON text");
  json_error_t problem;
  json_t *json = json_loadb(bytes, size, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_DECODE_ANY, &problem);
  if (!json) {
    const char *mistake = likely(bytes, size, problem.position > 0 ? (size_t)problem.position : 0);
    return km_fail(error, KM_MODEL, "line %d, column %d: %s%s%s%s; expected JSON text", problem.line, problem.column,
                   problem.text, mistake ? " (" : "", mistake ? mistake : "", mistake ? ")" : "");
  }
  *root = convert(arena, NULL, NULL, json);
  json_decref(json);
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory while reading JSON") : KM_OK;
}

km_status km_json_parse(const char *bytes, size_t size, km_arena *arena, const km_value **root, km_error *error) {
  km_value *open = NULL;
  if (!bytes || !arena || !root)
    return km_check_given(false, !bytes ? "text" : !arena ? "arena" : "place for the result", error);
  km_status status = km_json_parse_open(bytes, size, arena, &open, error);
  *root = open;
  return status;
}
