/* Trees of values as JSON text. */
#include "exchange/json/json.h"

#include <math.h>

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

/* Level of values that are written on one line. */
enum { ON_ONE_LINE = -1 };

static void write_members(const km_value *value, int level, int flat, km_text *out) {
  flat = flat || level == ON_ONE_LINE;
  for (const km_value *member = value->first; member; member = member->next) {
    if (!flat)
      indent(out, level + 1);
    if (member->key) {
      write_string(member->key, out);
      km_text_add(out, ": ");
    }
    write_value(member, level == ON_ONE_LINE ? level : level + 1, out);
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
  if (!value || !out)
    return;
  write_value(value, 0, out);
  km_text_add(out, "\n");
}

void km_json_write_line(const km_value *value, km_text *out) {
  if (!value || !out)
    return;
  write_value(value, ON_ONE_LINE, out);
  km_text_add(out, "\n");
}
