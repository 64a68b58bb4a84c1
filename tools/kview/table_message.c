/* Binary answers with a table: docs/kview-protocol.md. */
#include "kview/messages.h"

#include "kmech/data.h"

enum { MOST_NUMBERS = 4000000 };

void kv_add_columns(const km_table *table, km_text *out) {
  km_text_add(out, ",\"columns\":[");
  for (size_t c = 0; c < km_table_columns(table); ++c) {
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, km_table_name(table, c));
    km_text_add(out, ",\"unit\":");
    kv_add_string(out, km_table_unit(table, c));
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

/* The header, with the bytes before it, is a multiple of 8 bytes long. */
km_status kv_add_table(const kv_call *call, km_text *header, const km_table *table, km_error *error) {
  size_t rows = km_table_rows(table), columns = km_table_columns(table);
  km_text *out = &call->answer->bytes;
  if (rows * columns > MOST_NUMBERS)
    return km_fail(error, KM_USAGE, "a table of %zu rows and %zu columns is more than a page shows", rows, columns);
  while (!header->failed && header->size % 8 != 4)
    km_text_add(header, " ");
  call->answer->binary = true;
  kv_add_u32(out, KV_TABLE);
  kv_add_u32(out, call->request);
  kv_add_u32(out, (uint32_t)header->size);
  kv_add_u32(out, (uint32_t)rows);
  kv_add_u32(out, (uint32_t)columns);
  km_text_bytes(out, header->data ? header->data : "", header->size);
  for (size_t r = 0; r < rows; ++r)
    for (size_t c = 0; c < columns; ++c)
      kv_add_f64(out, km_table_row(table, r)[c]);
  out->failed = out->failed || header->failed;
  return KM_OK;
}
