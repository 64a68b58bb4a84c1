/* Texts that grow, and numbers as text. */
#include "base/text.h"

#include "base/arguments.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Length in bytes of the control character or bidirectional mark at the start of the text, and its code; 0 if there
 * is none. */
static size_t control_at(const unsigned char *c, size_t size, unsigned *code) {
  *code = c[0];
  if (c[0] == '\r' && size >= 2 && c[1] == '\n')
    return 0;
  if (c[0] < 0x20 || c[0] == 0x7F)
    return c[0] != '\n' && c[0] != '\t';
  if (size >= 2 && (c[0] & 0xE0) == 0xC0) {
    *code = (c[0] & 0x1Fu) << 6 | (c[1] & 0x3Fu);
    return (*code >= 0x80 && *code <= 0x9F) || *code == 0x61C ? 2 : 0;
  }
  if (size < 3 || c[0] != 0xE2)
    return 0;
  *code = 0x2000u | (c[1] & 0x3Fu) << 6 | (c[2] & 0x3Fu);
  bool turns = (*code >= 0x200E && *code <= 0x200F) || (*code >= 0x202A && *code <= 0x202E) ||
               (*code >= 0x2066 && *code <= 0x2069);
  return turns ? 3 : 0;
}

static bool grow(km_text *text, size_t more) {
  void *data = text->data;
  if (text->failed || !km_reserve(&data, &text->capacity, text->size + more + 1, 1)) {
    text->failed = true;
    return false;
  }
  text->data = data;
  return true;
}

const char *km_text_move_to_arena(km_text *text, km_arena *arena) {
  if (!text || !arena)
    return "";
  const char *kept = text->failed ? NULL : km_arena_string(arena, text->data ? text->data : "");
  arena->failed = arena->failed || text->failed;
  km_text_free(text);
  return kept ? kept : "";
}

void km_text_visible(km_text *text, const char *bytes, size_t size) {
  if (!text || !bytes)
    return;
  size_t from = 0;
  for (size_t i = 0; i < size;) {
    unsigned code;
    size_t length = control_at((const unsigned char *)bytes + i, size - i, &code);
    if (length) {
      km_text_bytes(text, bytes + from, i - from);
      km_text_format(text, "\\u%04x", code);
      from = i + length;
    }
    i += length ? length : 1;
  }
  km_text_bytes(text, bytes + from, size - from);
}

void km_text_free(km_text *text) {
  if (!text)
    return;
  km_free(text->data);
  *text = (km_text){0};
}

km_status km_text_move_to_bytes(km_text *text, km_bytes *out, km_error *error) {
  if (!text || !out)
    return km_check_given(false, text ? "place for the result" : "text", error);
  km_text_add(text, "");
  if (text->failed) {
    km_text_free(text);
    return km_fail(error, KM_MEMORY, "out of memory for a text");
  }
  *out = (km_bytes){text->data, text->size};
  *text = (km_text){0};
  return KM_OK;
}

void km_bytes_free(km_bytes *bytes) {
  if (!bytes)
    return;
  km_free(bytes->data);
  *bytes = (km_bytes){0};
}

void km_text_bytes(km_text *text, const void *bytes, size_t size) {
  if (!text || (!bytes && size))
    return;
  if (!grow(text, size))
    return;
  if (size)
    memcpy(text->data + text->size, bytes, size);
  text->size += size;
  text->data[text->size] = '\0';
}

void km_text_base64(km_text *text, const void *bytes, size_t size) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const unsigned char *from = bytes;
  for (size_t i = 0; from && i < size; i += 3) {
    size_t left = size - i;
    unsigned all =
        (unsigned)from[i] << 16 | (left > 1 ? (unsigned)from[i + 1] : 0u) << 8 | (left > 2 ? from[i + 2] : 0u);
    const char four[4] = {digits[all >> 18], digits[all >> 12 & 63], left > 1 ? digits[all >> 6 & 63] : '=',
                          left > 2 ? digits[all & 63] : '='};
    km_text_bytes(text, four, sizeof four);
  }
}

void km_text_add(km_text *text, const char *string) {
  if (string)
    km_text_bytes(text, string, strlen(string));
}

void km_text_format(km_text *text, const char *format, ...) {
  if (!text || !format)
    return;
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  int length = vsnprintf(NULL, 0, format, arguments);
  if (length >= 0 && grow(text, (size_t)length)) {
    vsnprintf(text->data + text->size, (size_t)length + 1, format, again);
    text->size += (size_t)length;
  }
  va_end(again);
  va_end(arguments);
}

char *km_arena_format_list(km_arena *arena, const char *format, va_list arguments) {
  va_list again;
  va_copy(again, arguments);
  int length = vsnprintf(NULL, 0, format, arguments);
  char *text = length < 0 ? NULL : km_arena_alloc(arena, 1, (size_t)length + 1);
  if (text)
    vsnprintf(text, (size_t)length + 1, format, again);
  va_end(again);
  return text;
}

void km_text_number(km_text *text, double value) {
  char number[KM_NUMBER_TEXT];
  km_text_bytes(text, number, km_number_format(number, value));
}
