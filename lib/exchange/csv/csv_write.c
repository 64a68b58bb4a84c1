/* Tables as comma-separated values. */
#include "kmech/report.h"

#include "base/arguments.h"
#include "base/file.h"

#include <string.h>

/* Quotes blank names, too, because readers skip blank lines, and names that begin like a byte order mark. */
static void write_field(const char *name, const char *unit, km_text *out) {
  bool quoted =
      strpbrk(name, ",\"\r\n") != NULL || name[strspn(name, " \t")] == '\0' || strncmp(name, "\xEF\xBB\xBF", 3) == 0;
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
  if (!table || !out)
    return;
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

size_t km_table_csv(const km_table *table, char *text, size_t size) {
  km_text whole = {0};
  if (text && size > 0)
    text[0] = '\0';
  if (!table)
    return 0;
  km_csv_write(table, &whole);
  size_t count = whole.failed ? 0 : whole.size, fits = size > 0 && count >= size ? size - 1 : count;
  if (text && size > 0 && count > 0) {
    memcpy(text, whole.data, fits);
    text[fits] = '\0';
  }
  km_text_free(&whole);
  return count;
}

km_status km_table_write_csv(const km_table *table, const char *path, km_error *error) {
  km_status status = km_check_given(table && path, "table or path", error);
  if (status)
    return status;
  km_text text = {0};
  km_csv_write(table, &text);
  status = text.failed ? km_fail(error, KM_MEMORY, "out of memory for a table") : km_file_write(path, &text, error);
  km_text_free(&text);
  return status;
}
