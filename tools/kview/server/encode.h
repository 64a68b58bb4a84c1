/* Numbers and strings of answers: as JSON text, and as the page reads them (little-endian). */
#ifndef KT_KVIEW_SERVER_ENCODE_H
#define KT_KVIEW_SERVER_ENCODE_H

#include "kmech/base.h"

#include <stdint.h>

/* A JSON string, with its quotation marks. */
void kv_add_string(km_text *out, const char *text);
/* A JSON number; null where it isn't finite. */
void kv_add_number(km_text *out, double value);
/* A JSON list of numbers. */
void kv_add_numbers(km_text *out, const double *values, int count);
/* Before an element of a list or an object: a comma unless it is the first one. */
void kv_add_comma(km_text *out);

void kv_add_u32(km_text *out, uint32_t value);
void kv_add_f64(km_text *out, double value);
void kv_add_f32(km_text *out, double value);

#endif
