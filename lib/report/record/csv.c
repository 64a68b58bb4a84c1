/* Tables as CSV. */
#include "report/record/csv.h"

#include <string.h>

static void write_field(const char *name, const char *unit, km_text *out) {
  bool quoted = strpbrk(name, ",\"\r\n") != NULL;
  if (quoted)
    km_text_add(out, "\"");
  for (const char *c = name; *c; ++c) {
    if (*c == '"')
      km_text_add(out, "\"");
    km_text_bytes(out, c, 1);
  }
  if (unit[0])
    km_text_format(out, "_%s", unit);
  if (quoted)
    km_text_add(out, "\"");
}

void km_csv_write(const km_table *table, km_text *out) {
  size_t columns = km_table_columns(table);
  for (size_t c = 0; c < columns; ++c) {
    if (c)
      km_text_add(out, ",");
    write_field(km_table_name(table, c), km_table_is_plain(table, c) ? "" : km_table_unit(table, c), out);
  }
  km_text_add(out, "\r\n");
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    const double *row = km_table_row(table, r);
    for (size_t c = 0; c < columns; ++c) {
      if (c)
        km_text_add(out, ",");
      km_text_number(out, row[c]);
    }
    km_text_add(out, "\r\n");
  }
}
