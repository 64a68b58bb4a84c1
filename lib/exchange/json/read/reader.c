#include "exchange/json/read/reader.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void report(km_reader *reader, km_severity severity, const km_place *place, const char *format,
                   va_list arguments) {
  char where[KM_PLACE_TEXT], text[KM_ERROR_TEXT];
  if (reader->arena->failed) /* later missing elements may be a consequence */
    return;
  vsnprintf(text, sizeof text, format, arguments);
  km_messages_add(reader->messages, severity, "%s: %s", km_place_text(place, where), text);
}

void km_reader_error(km_reader *reader, const km_place *place, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  report(reader, KM_ERROR, place, format, arguments);
  va_end(arguments);
}

void km_reader_note(km_reader *reader, const km_place *place, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  report(reader, KM_NOTE, place, format, arguments);
  va_end(arguments);
}

void km_reader_warning(km_reader *reader, const km_place *place, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  report(reader, KM_WARNING, place, format, arguments);
  va_end(arguments);
}

const char *km_reader_where(km_reader *reader, const km_place *place) {
  char where[KM_PLACE_TEXT];
  return km_arena_string(&reader->model->arena, km_place_text(place, where));
}

bool km_reader_active(const km_value *object) {
  const km_value *active = km_value_get(object, "active");
  return !active || active->number != 0.0;
}

double km_reader_number(const km_value *object, const char *key, double otherwise) {
  const km_value *value = km_value_get(object, key);
  return value ? value->number : otherwise;
}

void km_reader_positive(km_reader *reader, const km_place *place, const char *key, double value) {
  km_place at = {place, key, 0};
  if (!(value > 0.0))
    km_reader_error(reader, &at, "found %s; expected a number greater than 0", KM_SHOWN(value));
}

void km_reader_not_negative(km_reader *reader, const km_value *object, const char *key, const km_place *place) {
  double value = km_reader_number(object, key, 0.0);
  km_place at = {place, key, 0};
  if (value < 0.0)
    km_reader_error(reader, &at, "found %s; expected a number of at least 0", KM_SHOWN(value));
}

km_vec3 km_reader_vector(const km_value *object, const char *key) {
  const km_value *list = km_value_get(object, key);
  if (!list)
    return (km_vec3){0, 0, 0};
  const km_value *x = list->first;
  return (km_vec3){x->number, x->next->number, x->next->next ? x->next->next->number : 0.0};
}

const char *km_reader_string(const km_value *object, const char *key) {
  const km_value *value = km_value_get(object, key);
  return value ? value->string : NULL;
}

const char *km_reader_name(km_reader *reader, const km_value *object, const km_place *place, km_names *names, int scope,
                           const char *reserved) {
  const char *name = km_reader_string(object, "name");
  km_place at = {place, "name", 0};
  if (!name[0])
    km_reader_error(reader, &at, "found an empty name; expected at least one character");
  else if (reserved && strcmp(name, reserved) == 0)
    km_reader_error(reader, &at, "\"%s\" is reserved; expected another name", name);
  else if (km_names_get(names, scope, name) >= 0)
    km_reader_error(reader, &at, "\"%.80s\" is used twice here; expected a name of its own", name);
  return name;
}

const char *km_reader_free_name(km_reader *reader, const km_names *names, int scope, const char *name,
                                const char *mark) {
  km_text text = {0};
  km_text_add(&text, name);
  if (mark && (km_names_get(names, scope, name) != KM_NOT_FOUND || strcmp(name, "origin") == 0))
    km_text_format(&text, ":%s", mark);
  while (!text.failed && km_names_get(names, scope, text.data) != KM_NOT_FOUND)
    km_text_add(&text, ":");
  const char *kept = text.failed ? NULL : km_arena_string(&reader->model->arena, text.data);
  reader->model->arena.failed = reader->model->arena.failed || !kept;
  km_text_free(&text);
  return kept ? kept : "";
}

int km_reader_make_frame(km_reader *reader, int body, const char *name, km_pose pose) {
  return km_reader_add_frame(reader, km_reader_free_name(reader, &reader->frames, body, name, "joint"), body, pose);
}

void km_reader_named(km_reader *reader, const km_value *object, const km_place *place) {
  km_place at = {place, "name", 0};
  if (!km_reader_string(object, "name")[0])
    km_reader_error(reader, &at, "found an empty name; expected at least one character");
}

void km_reader_each(km_reader *reader, const km_value *object, const char *key, int owner, const km_place *place,
                    km_element_read read) {
  const km_value *list = km_value_get(object, key);
  if (!list)
    return;
  km_place at = {place, key, 0};
  km_place item = {&at, NULL, 0};
  for (const km_value *element = list->first; element; element = element->next, ++item.index)
    read(reader, element, owner, &item);
}

static void visit_list(km_reader *reader, const km_value *parent, const km_place *place, int *next,
                       km_assembly_visit visit) {
  const km_value *list = km_value_get(parent, "assemblies");
  if (!list)
    return;
  km_place at = {place, "assemblies", 0};
  km_place item = {&at, NULL, 0};
  for (const km_value *assembly = list->first; assembly; assembly = assembly->next, ++item.index) {
    if (!km_reader_active(assembly))
      continue;
    int index = (*next)++;
    visit(reader, assembly, index, &item);
    visit_list(reader, assembly, &item, next, visit);
  }
}

void km_reader_visit(km_reader *reader, const km_value *root, km_assembly_visit visit) {
  int next = 0;
  visit_list(reader, root, NULL, &next, visit);
}
