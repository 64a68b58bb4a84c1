/* Numbers and strings of answers. */
#include "kview/server/encode.h"

#include <math.h>
#include <string.h>

void kv_add_string(km_text *out, const char *text) {
  km_text_bytes(out, "\"", 1);
  for (const char *at = text ? text : ""; *at; ++at) {
    unsigned char c = (unsigned char)*at;
    if (c == '"' || c == '\\')
      km_text_format(out, "\\%c", c);
    else if (c < 0x20 || c == '<') /* a page holds answers inside a script */
      km_text_format(out, "\\u%04x", c);
    else
      km_text_bytes(out, at, 1);
  }
  km_text_bytes(out, "\"", 1);
}

void kv_add_number(km_text *out, double value) {
  if (isfinite(value))
    km_text_number(out, value);
  else
    km_text_add(out, "null");
}

void kv_add_numbers(km_text *out, const double *values, int count) {
  km_text_add(out, "[");
  for (int i = 0; i < count; ++i) {
    kv_add_comma(out);
    kv_add_number(out, values[i]);
  }
  km_text_add(out, "]");
}

void kv_add_comma(km_text *out) {
  char last = out->size ? out->data[out->size - 1] : '[';
  if (last != '[' && last != '{' && last != ':')
    km_text_add(out, ",");
}

void kv_add_u32(km_text *out, uint32_t value) {
  const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8), (unsigned char)(value >> 16),
                                  (unsigned char)(value >> 24)};
  km_text_bytes(out, bytes, sizeof bytes);
}

void kv_add_f64(km_text *out, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  kv_add_u32(out, (uint32_t)bits);
  kv_add_u32(out, (uint32_t)(bits >> 32));
}

void kv_add_f32(km_text *out, double value) {
  float single = (float)value;
  uint32_t bits;
  memcpy(&bits, &single, sizeof bits);
  kv_add_u32(out, bits);
}
