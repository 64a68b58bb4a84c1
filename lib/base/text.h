/* A growing byte buffer, and numbers as text. */
#ifndef KM_BASE_TEXT_H
#define KM_BASE_TEXT_H

#include "base/memory.h"
#include "kmech/bytes.h"
#include "kmech/status.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

/* Bytes are followed by a NUL that `size` doesn't count. `failed` is sticky (out of memory). */
typedef struct km_text {
  char *data;
  size_t size, capacity;
  bool failed;
} km_text;

void km_text_free(km_text *text);
/* Moves the text into an arena, whose failure it shares, and frees it. */
const char *km_text_keep(km_text *text, km_arena *arena);
/* Hands the text over, and leaves an empty one. KM_MEMORY if it failed. */
km_status km_text_give(km_text *text, km_bytes *out, km_error *error);
void km_text_bytes(km_text *text, const void *bytes, size_t size);
void km_text_add(km_text *text, const char *string);
void km_text_format(km_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same into an arena. NULL when out of memory. */
char *km_arena_format_list(km_arena *arena, const char *format, va_list arguments);
void km_text_number(km_text *text, double value);

enum { KM_NUMBER_TEXT = 48 };
/* The shortest decimal text that reads back to the same double, in the C locale whatever the process's
 * locale is; inf, -inf, nan. Returns the length. */
size_t km_number_format(char out[KM_NUMBER_TEXT], double value);
/* The same for a message, where it is asked for. */
#define KM_SHOWN(x) km_number_shown((char[KM_NUMBER_TEXT]){0}, x)
const char *km_number_shown(char out[KM_NUMBER_TEXT], double value); /* returns `out` */

#endif
