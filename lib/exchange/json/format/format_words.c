/* The format table in words: shapes, units, and tables in Markdown for the guide. */
#include "exchange/json/format/format_rows.h"

#include <string.h>

void km_field_shape_text(const km_field *field, km_text *out) {
  static const char *const words[] = {
      [KM_SHAPE_NUMBER] = "number",
      [KM_SHAPE_STRING] = "text",
      [KM_SHAPE_BOOLEAN] = "true or false",
      [KM_SHAPE_VECTOR] = "[x, y, z]",
      [KM_SHAPE_POINT] = "[x, y] or [x, y, z]",
      [KM_SHAPE_MATRIX] = "three rows of three numbers",
      [KM_SHAPE_NUMBERS] = "list of numbers",
      [KM_SHAPE_COORDINATES] = "number, or a list of them",
      [KM_SHAPE_RANGE] = "[low, high]",
      [KM_SHAPE_RANGES] = "[low, high], or a list of them",
      [KM_SHAPE_ROWS] = "list of lists of numbers",
      [KM_SHAPE_TIME_LAW] = "number, list of numbers, list of lists of numbers, or expression of t",
      [KM_SHAPE_EXPRESSION] = "expression of t",
      [KM_SHAPE_STRINGS] = "text, or a list of texts",
      [KM_SHAPE_PATH] = "path",
      [KM_SHAPE_PATHS] = "list of paths",
      [KM_SHAPE_PATH_PAIR] = "[path, path]",
      [KM_SHAPE_COORDINATE_MAP] = "{joint: number or list}",
      [KM_SHAPE_POSES] = "{name: {joint: number or list}}",
      [KM_SHAPE_PARAMETERS] = "{name: number or %s}",
      [KM_SHAPE_VALUE_MAPS] = "{name: {parameter: number}}",
      [KM_SHAPE_TEXT_MAP] = "{name: text}",
      [KM_SHAPE_MAP] = "{name: %s}",
      [KM_SHAPE_LIST_MAP] = "{name: list of numbers, or %s}",
      [KM_SHAPE_WORD_MAP] = "{name: text, or %s}",
      [KM_SHAPE_OBJECT] = "%s",
      [KM_SHAPE_OBJECTS] = "list of %s",
      [KM_SHAPE_METHODS] = "text, %s, or a list of either",
      [KM_SHAPE_END] = "path, or %s",
      [KM_SHAPE_ANY] = "anything",
  };
  const char *word = words[field->shape], *name = strstr(word, "%s");
  km_text_bytes(out, word, name ? (size_t)(name - word) : strlen(word));
  if (name)
    km_text_format(out, "`%s`%s", field->object->name, name + 2);
}

/* The factors of one sign, as `force*length`; returns how many. */
static int factors(km_dimension d, int sign, km_text *out) {
  static const char *const names[] = {"angle", "mass", "force", "time", "length"};
  const int exponents[] = {d.angle, d.mass, d.force, d.time, d.length};
  int count = 0;
  for (int i = 0; i < 5; ++i) {
    int exponent = sign * exponents[i];
    if (exponent > 0)
      km_text_format(out, "%s%s", count++ ? "*" : "", names[i]);
    if (exponent > 1)
      km_text_format(out, "^%d", exponent);
  }
  return count;
}

void km_field_unit_text(const km_field *field, km_text *out) {
  static const char *const words[] = {
      [KM_MEASURE_FIXED] = "",
      [KM_MEASURE_COORDINATE] = "angle or length",
      [KM_MEASURE_RATIO] = "1, of a slide 1/length",
      [KM_MEASURE_FOLLOWING] = "rad or length, over (rad or length)^k",
      [KM_MEASURE_STIFFNESS] = "torque/rad or force/length",
      [KM_MEASURE_FORCE] = "torque or force",
      [KM_MEASURE_INERTIA] = "mass*length^2 or mass",
      [KM_MEASURE_POLYNOMIAL] = "angle or length, over time^k",
      [KM_MEASURE_TABLE] = "time; angle or length",
      [KM_MEASURE_SWEEP] = "angle or length",
      [KM_MEASURE_KNOTS] = "rad or length",
      [KM_MEASURE_PIECES] = "torque/rad^k or force/length^k",
      [KM_MEASURE_LAW_TABLE] = "time; torque or force",
      [KM_MEASURE_LAW_POLYNOMIAL] = "torque or force, over time^k",
      [KM_MEASURE_REFERENCE] = "rad or length",
      [KM_MEASURE_MODULE_FORCE] = "torque or force",
      [KM_MEASURE_GAIN] = "torque/rad or force/length",
      [KM_MEASURE_LAW_X] = "that of x",
      [KM_MEASURE_LAW_VALUE] = "that of the value",
      [KM_MEASURE_LAW_ROWS] = "that of x; that of the value",
      [KM_MEASURE_LAW_SERIES] = "that of the value, over x^k",
  };
  km_text above = {0}, below = {0};
  int over = factors(field->dimension, 1, &above), under = factors(field->dimension, -1, &below);
  const char *word = words[field->measure];
  km_text_add(out, word);
  if (over)
    km_text_format(out, "%s%s", word[0] ? ", times " : "", above.data ? above.data : "");
  if (under)
    km_text_format(out, "%s%s", over ? "/" : word[0] ? ", over " : "1/", below.data ? below.data : "");
  out->failed = out->failed || above.failed || below.failed;
  km_text_free(&above);
  km_text_free(&below);
}

static void row(const km_field *field, km_text *out) {
  km_text_format(out, "| `%s` | ", field->key);
  km_field_shape_text(field, out);
  km_text_add(out, " | ");
  km_field_unit_text(field, out);
  km_text_format(out, " | %s | %s |\n",
                 field->required   ? "required"
                 : field->unstated ? field->unstated
                                   : "",
                 field->help);
}

/* Objects in the order in which they are met from the root, each once. */
enum { MOST_OBJECTS = 64 };
typedef struct objects {
  const km_object_format *items[MOST_OBJECTS];
  int count;
} objects;

static void gather(const km_object_format *format, objects *all) {
  for (int i = 0; i < all->count; ++i)
    if (all->items[i] == format)
      return;
  if (all->count == MOST_OBJECTS)
    return;
  all->items[all->count++] = format;
  for (const km_field *field = format->fields; field->key; ++field)
    if (field->object)
      gather(field->object, all);
}

void km_format_markdown(const km_object_format *root, km_text *out) {
  objects all = {0};
  gather(root, &all);
  for (int i = 0; i < all.count; ++i) {
    const km_object_format *format = all.items[i];
    km_text_format(out, "%s<!-- keys: %s -->\n", i ? "\n" : "", format->name);
    km_text_add(out, "| key | shape | unit | without it | meaning |\n| --- | --- | --- | --- | --- |\n");
    for (const km_field *field = format->fields; field->key; ++field)
      row(field, out);
  }
}
