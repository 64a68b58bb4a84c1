/* A growing text, and numbers as text. */
#ifndef KMECH_TEXT_H
#define KMECH_TEXT_H

#include "kmech/bytes.h"
#include "kmech/memory.h"
#include "kmech/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes are followed by a NUL that `size` doesn't count. `failed` is sticky (out of memory). Start from {0}. */
typedef struct km_text {
  char *data;            /* the bytes, NULL while there are none */
  size_t size, capacity; /* without the closing NUL; room */
  bool failed;           /* memory ran out: the text isn't whole */
} km_text;

KM_API void km_text_free(km_text *text);
/* Moves the text into an arena, whose failure it shares, and frees it. "" when out of memory. */
KM_API const char *km_text_keep(km_text *text, km_arena *arena);
/* Hands the text over, and leaves an empty one. KM_MEMORY if it failed. */
KM_API km_status km_text_give(km_text *text, km_bytes *out, km_error *error);
/* Each appends: bytes, a `string`, a `format` of printf. O(bytes). */
KM_API void km_text_bytes(km_text *text, const void *bytes, size_t size);
KM_API void km_text_add(km_text *text, const char *string);
KM_API void km_text_format(km_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Bytes of UTF-8 in which control characters and those that turn the direction of writing are written as \u001b: a terminal or a page then
 * shows them and doesn't obey them. Line ends and tabs stay. */
KM_API void km_text_visible(km_text *text, const char *bytes, size_t size);
/* Bytes in base64 (RFC 4648), with padding. */
KM_API void km_text_base64(km_text *text, const void *bytes, size_t size);
/* The shortest decimal text of a `value` that reads back to the same double, in the C locale whatever the process's locale is; inf,
 * -inf, nan. */
KM_API void km_text_number(km_text *text, double value);

enum {
  KM_NUMBER_TEXT = 48 /* bytes of the longest number, the NUL included */
};
/* The same of a `value` into a buffer. Returns the length. */
KM_API size_t km_number_format(char out[KM_NUMBER_TEXT], double value);

#ifdef __cplusplus
}
#endif
#endif
