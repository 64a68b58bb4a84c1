/* Errors and lists of messages. */
#include "kmech/base.h"

#include "base/memory.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ERRORS = 20 };

typedef struct finding {
  km_severity severity;
  char text[KM_ERROR_TEXT];
} finding;

struct km_messages {
  finding *items;
  size_t count, capacity, errors;
};

km_status km_fail(km_error *error, km_status status, const char *format, ...) {
  if (!format)
    format = "";
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    error->status = status;
  }
  return status;
}

km_messages *km_messages_create(void) {
  return KM_NEW(km_messages, 1);
}

void km_messages_free(km_messages *messages) {
  if (!messages)
    return;
  km_free(messages->items);
  km_free(messages);
}

void km_messages_add(km_messages *messages, km_severity severity, const char *format, ...) {
  if (!messages || !format)
    return;
  if (severity == KM_ERROR && ++messages->errors > MOST_ERRORS)
    return;
  void *items = messages->items;
  if (!km_reserve(&items, &messages->capacity, messages->count + 1, sizeof *messages->items))
    return;
  messages->items = items;
  finding *item = &messages->items[messages->count++];
  item->severity = severity;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(item->text, sizeof item->text, format, arguments);
  va_end(arguments);
}

size_t km_messages_count(const km_messages *messages) {
  return messages ? messages->count : 0;
}

size_t km_messages_errors(const km_messages *messages) {
  return messages ? messages->errors : 0;
}

km_severity km_messages_severity(const km_messages *messages, size_t index) {
  if (index >= km_messages_count(messages))
    return KM_NOTE;
  return messages->items[index].severity;
}

const char *km_messages_text(const km_messages *messages, size_t index) {
  if (index >= km_messages_count(messages))
    return "";
  return messages->items[index].text;
}
