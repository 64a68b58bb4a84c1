/* Growing bytes for answers. */
#include "kview/buffer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void kv_buffer_free(kv_buffer *b) {
  free(b->data);
  *b = (kv_buffer){0};
}

static char *room(kv_buffer *b, size_t more) {
  size_t need = b->size + more + 1;
  if (b->failed)
    return NULL;
  if (need > b->capacity) {
    size_t capacity = need < 512 ? 1024 : 2 * need;
    char *data = realloc(b->data, capacity);
    b->failed = !data;
    if (!data)
      return NULL;
    b->data = data;
    b->capacity = capacity;
  }
  return b->data + b->size;
}

void kv_add_bytes(kv_buffer *b, const void *bytes, size_t size) {
  char *to = room(b, size);
  if (!to)
    return;
  if (size)
    memcpy(to, bytes, size);
  b->size += size;
  b->data[b->size] = '\0';
}

void kv_add(kv_buffer *b, const char *format, ...) {
  va_list list, again;
  va_start(list, format);
  va_copy(again, list);
  int size = vsnprintf(NULL, 0, format, list);
  va_end(list);
  char *to = size < 0 ? NULL : room(b, (size_t)size);
  if (to) {
    vsnprintf(to, (size_t)size + 1, format, again);
    b->size += (size_t)size;
  }
  va_end(again);
}

void kv_add_string(kv_buffer *b, const char *text) {
  kv_add_bytes(b, "\"", 1);
  for (const char *at = text ? text : ""; *at; ++at) {
    unsigned char c = (unsigned char)*at;
    if (c == '"' || c == '\\')
      kv_add(b, "\\%c", c);
    else if (c < 0x20 || c == '<') /* a page holds answers inside a script */
      kv_add(b, "\\u%04x", c);
    else
      kv_add_bytes(b, at, 1);
  }
  kv_add_bytes(b, "\"", 1);
}

void kv_add_number(kv_buffer *b, double value) {
  if (!isfinite(value)) {
    kv_add(b, "null");
    return;
  }
  for (int digits = 9; digits <= 17; digits += 4) {
    char text[40];
    snprintf(text, sizeof text, "%.*g", digits, value);
    if (digits == 17 || strtod(text, NULL) == value) {
      kv_add(b, "%s", text);
      return;
    }
  }
}

void kv_add_numbers(kv_buffer *b, const double *values, int count) {
  kv_add(b, "[");
  for (int i = 0; i < count; ++i) {
    kv_add_comma(b);
    kv_add_number(b, values[i]);
  }
  kv_add(b, "]");
}

void kv_add_comma(kv_buffer *b) {
  char last = b->size ? b->data[b->size - 1] : '[';
  if (last != '[' && last != '{' && last != ':')
    kv_add(b, ",");
}

void kv_add_u32(kv_buffer *b, uint32_t value) {
  const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8), (unsigned char)(value >> 16),
                                  (unsigned char)(value >> 24)};
  kv_add_bytes(b, bytes, sizeof bytes);
}

void kv_add_f64(kv_buffer *b, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  kv_add_u32(b, (uint32_t)bits);
  kv_add_u32(b, (uint32_t)(bits >> 32));
}

void kv_add_f32(kv_buffer *b, double value) {
  float single = (float)value;
  uint32_t bits;
  memcpy(&bits, &single, sizeof bits);
  kv_add_u32(b, bits);
}
