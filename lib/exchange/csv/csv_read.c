/* Reads tables of comma-separated values. */
#include "kmech/report.h"

#include "base/arguments.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/units.h"

#include <math.h>
#include <string.h>

typedef enum ending { FIELD_ENDS, ROW_ENDS, TEXT_ENDS, QUOTE_OPEN } ending;

typedef struct sheet {
  const char *file, *at, *end;
  size_t line; /* position of the next character */
  km_text field;
  km_table *table;
  km_error *error;
} sheet;

static void take(sheet *s) {
  s->line += *s->at == '\n';
  km_text_bytes(&s->field, s->at++, 1);
}

/* Reads a quoted field, from after the opening quote to after the closing one. */
static bool read_quoted(sheet *s) {
  while (s->at < s->end) {
    if (*s->at == '"' && (s->at + 1 == s->end || s->at[1] != '"')) {
      ++s->at;
      return true;
    }
    s->at += *s->at == '"';
    take(s);
  }
  return false;
}

/* Reads the next field, and what ended it. */
static ending read_field(sheet *s) {
  s->field.size = 0;
  km_text_add(&s->field, "");
  if (s->at < s->end && *s->at == '"') {
    ++s->at;
    if (!read_quoted(s))
      return QUOTE_OPEN;
  }
  while (s->at < s->end && *s->at != ',' && *s->at != '\n') {
    if (*s->at == '\r' && (s->at + 1 == s->end || s->at[1] == '\n'))
      ++s->at;
    else
      take(s);
  }
  if (s->at == s->end)
    return TEXT_ENDS;
  s->line += *s->at == '\n';
  return *s->at++ == ',' ? FIELD_ENDS : ROW_ENDS;
}

static km_status complain(const sheet *s, size_t line, const char *what) {
  return km_fail(s->error, KM_IO, "%s: line %zu: %s", s->file, line, what);
}

static bool is_unit_word(const char *text, size_t length) {
  for (int q = 0; q < KM_QUANTITIES; ++q)
    for (const km_unit *unit = km_quantity_units((km_quantity)q); unit->word; ++unit)
      if (strlen(unit->suffix) == length && memcmp(unit->suffix, text, length) == 0)
        return true;
  return false;
}

/* Units of the model format, each with a power or without, with * and / between them: "m/s^2". */
static bool is_unit(const char *text) {
  for (;;) {
    size_t length = strcspn(text, "*/"), word = strcspn(text, "*/^");
    bool powered = word < length;
    if (!is_unit_word(text, word) || (powered && word + 1 + strspn(text + word + 1, "0123456789") < length))
      return false;
    if (!text[length])
      return true;
    text += length + 1;
  }
}

/* Adds the column of a header's field. */
static km_status add_column(sheet *s) {
  char *name = s->field.data, *low = strrchr(name, '_');
  bool number = strncmp(name, "m.", 2) == 0;
  const char *unit = NULL;
  if (low && low > name && !number && is_unit(low + 1)) {
    *low = '\0';
    unit = low + 1;
  }
  return km_table_add_column(s->table, name, unit) < 0 ? km_fail(s->error, KM_MEMORY, "out of memory for a table")
                                                       : KM_OK;
}

static km_status read_header(sheet *s, ending *last) {
  km_status status = KM_OK;
  do {
    size_t line = s->line;
    *last = read_field(s);
    if (s->field.failed)
      return km_fail(s->error, KM_MEMORY, "out of memory for a table");
    if (*last == QUOTE_OPEN)
      return complain(s, line, "a quote is opened and never closed");
    status = add_column(s);
  } while (!status && *last == FIELD_ENDS);
  return status;
}

static bool read_number(const char *text, double *out) {
  char *end;
  text += strspn(text, " \t");
  if (*text == '\0') {
    *out = nan("");
    return true;
  }
  *out = km_number_read(text, &end);
  return end != text && end[strspn(end, " \t")] == '\0';
}

static km_status complain_of_number(const sheet *s, size_t line, size_t column) {
  return km_fail(s->error, KM_IO, "%s: line %zu, column %zu (%s): found \"%.40s\"; expected a number, inf or nan",
                 s->file, line, column + 1, km_table_name(s->table, column), s->field.data);
}

/* A row with another number of fields than the header has. */
static km_status complain_of_row(const sheet *s, size_t line, size_t fields) {
  return km_fail(s->error, KM_IO, "%s: line %zu: found %zu fields; expected %zu, as in the header", s->file, line,
                 fields, km_table_columns(s->table));
}

static km_status read_row(sheet *s, ending *last) {
  size_t columns = km_table_columns(s->table), count = 0, line = s->line;
  double *row = km_table_add_row(s->table);
  km_status status = KM_OK;
  if (!row)
    return km_fail(s->error, KM_MEMORY, "out of memory for a table");
  do {
    *last = read_field(s);
    if (s->field.failed)
      return km_fail(s->error, KM_MEMORY, "out of memory for a table");
    if (*last == QUOTE_OPEN)
      return complain(s, line, "a quote is opened and never closed");
    if (count < columns && !status && !read_number(s->field.data, &row[count]))
      status = complain_of_number(s, line, count);
    ++count;
  } while (*last == FIELD_ENDS);
  return count == columns ? status : complain_of_row(s, line, count);
}

/* Empty lines are no rows. */
static void skip_empty_lines(sheet *s) {
  for (;;) {
    const char *at = s->at + strspn(s->at, " \t\r");
    if (at >= s->end || *at != '\n') {
      s->at = at >= s->end ? s->end : s->at;
      return;
    }
    ++s->line;
    s->at = at + 1;
  }
}

static km_status read_all(sheet *s) {
  static const char mark[] = "\xEF\xBB\xBF"; /* byte order mark, which some spreadsheets write */
  ending last;
  if (s->end - s->at >= 3 && memcmp(s->at, mark, 3) == 0)
    s->at += 3;
  skip_empty_lines(s);
  if (s->at == s->end)
    return km_fail(s->error, KM_IO, "%s is empty; expected a table: a header row and rows of numbers", s->file);
  if (memchr(s->at, '\0', (size_t)(s->end - s->at)))
    return km_fail(s->error, KM_IO, "%s holds a NUL byte; expected a table as text", s->file);
  km_status status = read_header(s, &last);
  for (skip_empty_lines(s); !status && last != TEXT_ENDS && s->at < s->end; skip_empty_lines(s))
    status = read_row(s, &last);
  if (!status && km_table_rows(s->table) == 0)
    status = complain(s, s->line, "the table ends behind its header; expected rows of numbers");
  return status;
}

km_status km_csv_read(const km_text *text, const char *file, km_table **out, km_error *error) {
  if (!text || !out)
    return km_check_given(false, text ? "place for the result" : "text of a table", error);
  const char *data = text->data ? text->data : "";
  sheet s = {file, data, data + text->size, 1, {0}, km_table_create(), error};
  km_status status = s.table ? read_all(&s) : km_fail(error, KM_MEMORY, "out of memory for a table");
  km_text_free(&s.field);
  if (status) {
    km_table_free(s.table);
    s.table = NULL;
  }
  *out = s.table;
  return status;
}

/* "name" or "name_unit". */
static bool is_called(const km_table *table, size_t column, const char *wanted, bool whole) {
  const char *name = km_table_name(table, column), *unit = km_table_unit(table, column);
  size_t length = strlen(name);
  if (!whole || !*unit)
    return strcmp(name, wanted) == 0;
  return strncmp(name, wanted, length) == 0 && wanted[length] == '_' && strcmp(wanted + length + 1, unit) == 0;
}

int km_csv_find(const km_table *table, const char *name) {
  if (!table || !name)
    return -1;
  for (int whole = 1; whole >= 0; --whole)
    for (size_t c = 0; c < km_table_columns(table); ++c)
      if (is_called(table, c, name, whole))
        return (int)c;
  return -1;
}
