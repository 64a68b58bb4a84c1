/* Growing bytes for answers: JSON text and numbers as the page reads them (little-endian). */
#ifndef KVIEW_BUFFER_H
#define KVIEW_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct kv_buffer {
  char *data;
  size_t size, capacity;
  bool failed; /* out of memory; stays */
} kv_buffer;

void kv_buffer_free(kv_buffer *buffer);
void kv_add_bytes(kv_buffer *buffer, const void *bytes, size_t size);
void kv_add(kv_buffer *buffer, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* A JSON string, with its quotation marks. */
void kv_add_string(kv_buffer *buffer, const char *text);
/* A JSON number; null where it isn't finite. */
void kv_add_number(kv_buffer *buffer, double value);
/* A JSON list of numbers. */
void kv_add_numbers(kv_buffer *buffer, const double *values, int count);
/* Before an element of a list or an object: a comma unless it is the first one. */
void kv_add_comma(kv_buffer *buffer);

void kv_add_u32(kv_buffer *buffer, uint32_t value);
void kv_add_f64(kv_buffer *buffer, double value);
void kv_add_f32(kv_buffer *buffer, double value);

#endif
