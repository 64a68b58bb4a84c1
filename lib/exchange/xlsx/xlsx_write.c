/* Tables as workbooks (Office Open XML), by libxlsxwriter. The first sheet holds the table: a header row with the names
 * of the CSV, then a number for each finite value and an empty cell for every other one, so that a curve has a gap
 * there and a sum or a maximum is that of the finite values. The second sheet is a chart of columns over the table's
 * variable. The time of creation is constant: equal tables give equal bytes. */
#include "kmech/report.h"

#include "base/arguments.h"
#include "base/memory.h"
#include "base/text.h"
#include "exchange/xlsx/xlsx_library.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { MOST_CURVES = 8, WIDEST = 40 };
static const time_t created = 315532800; /* 1 January 1980, the first date of a ZIP file */

typedef struct book {
  const km_xlsx_functions *lib;
  const km_table *table;
  const char *sheet, *curves;
  lxw_workbook *workbook;
  lxw_error failure; /* the first one */
} book;

static void note(book *b, lxw_error failure) {
  if (!b->failure)
    b->failure = failure;
}

/* The column's name as in CSV. */
static km_text header_of(const km_table *table, size_t column) {
  km_text out = {0};
  const char *unit = km_table_is_plain(table, column) ? "" : km_table_unit(table, column);
  km_text_format(&out, "%s%s%s", km_table_name(table, column), unit[0] ? "_" : "", unit);
  return out;
}

static void write_header(book *b, lxw_worksheet *sheet, lxw_format *bold) {
  for (size_t c = 0; c < km_table_columns(b->table); ++c) {
    km_text name = header_of(b->table, c);
    const lxw_col_t column = (lxw_col_t)c;
    if (name.failed) {
      note(b, LXW_ERROR_MEMORY_MALLOC_FAILED);
    } else {
      const double width = fmin(fmax(10.0, (double)name.size + 2.0), WIDEST);
      note(b, b->lib->worksheet_set_column(sheet, column, column, width, NULL));
      note(b, b->lib->worksheet_write_string(sheet, 0, column, name.data, bold));
    }
    km_text_free(&name);
  }
}

static void write_rows(book *b, lxw_worksheet *sheet) {
  for (size_t r = 0; r < km_table_rows(b->table) && !b->failure; ++r)
    for (size_t c = 0; c < km_table_columns(b->table); ++c) {
      const double value = km_table_row(b->table, r)[c];
      if (isfinite(value))
        note(b, b->lib->worksheet_write_number(sheet, (lxw_row_t)r + 1, (lxw_col_t)c, value, NULL));
    }
}

/* The columns that are drawn: of those with the prefix, at most eight that share the first one's unit. */
static int choose_curves(const km_table *table, const char *prefix, size_t out[MOST_CURVES]) {
  const km_span span = km_table_span(table, prefix);
  int count = 0;
  for (size_t c = span.first; c < span.first + span.count && count < MOST_CURVES; ++c)
    if (count == 0 || strcmp(km_table_unit(table, c), km_table_unit(table, out[0])) == 0)
      out[count++] = c;
  return count;
}

static void add_curve(book *b, lxw_chart *chart, size_t x, size_t y) {
  const lxw_row_t last = (lxw_row_t)km_table_rows(b->table);
  lxw_chart_series *series = b->lib->chart_add_series(chart, NULL, NULL);
  if (!series) {
    note(b, LXW_ERROR_MEMORY_MALLOC_FAILED);
    return;
  }
  b->lib->chart_series_set_categories(series, b->sheet, 1, (lxw_col_t)x, last, (lxw_col_t)x);
  b->lib->chart_series_set_values(series, b->sheet, 1, (lxw_col_t)y, last, (lxw_col_t)y);
  b->lib->chart_series_set_name_range(series, b->sheet, 0, (lxw_col_t)y);
}

/* "s (deg)", "m/s". */
static void name_axes(book *b, lxw_chart *chart, size_t x, size_t y) {
  const char *unit = km_table_unit(b->table, x);
  km_text name = {0};
  km_text_format(&name, unit[0] ? "%s (%s)" : "%s", km_table_name(b->table, x), unit);
  if (name.failed)
    note(b, LXW_ERROR_MEMORY_MALLOC_FAILED);
  else
    b->lib->chart_axis_set_name(chart->x_axis, name.data);
  if (km_table_unit(b->table, y)[0])
    b->lib->chart_axis_set_name(chart->y_axis, km_table_unit(b->table, y));
  km_text_free(&name);
}

static void add_chart(book *b) {
  const int x = km_table_variable(b->table);
  size_t curves[MOST_CURVES];
  const int count = choose_curves(b->table, b->curves, curves);
  if (x < 0 || count == 0 || km_table_rows(b->table) == 0)
    return;
  lxw_chartsheet *sheet = b->lib->workbook_add_chartsheet(b->workbook, "chart");
  lxw_chart *chart = b->lib->workbook_add_chart(b->workbook, LXW_CHART_SCATTER_STRAIGHT);
  if (!sheet || !chart) {
    note(b, LXW_ERROR_MEMORY_MALLOC_FAILED);
    return;
  }
  for (int i = 0; i < count; ++i)
    add_curve(b, chart, (size_t)x, curves[i]);
  name_axes(b, chart, (size_t)x, curves[0]);
  b->lib->chart_title_set_name(chart, b->sheet);
  note(b, b->lib->chartsheet_set_chart(sheet, chart));
}

static void fill(book *b) {
  lxw_doc_properties properties = {.created = created};
  const int variable = km_table_variable(b->table);
  lxw_worksheet *sheet = b->lib->workbook_add_worksheet(b->workbook, b->sheet);
  lxw_format *bold = b->lib->workbook_add_format(b->workbook);
  if (!sheet || !bold) {
    note(b, LXW_ERROR_MEMORY_MALLOC_FAILED);
    return;
  }
  note(b, b->lib->workbook_set_properties(b->workbook, &properties));
  b->lib->format_set_bold(bold);
  write_header(b, sheet, bold);
  write_rows(b, sheet);
  b->lib->worksheet_freeze_panes(sheet, 1, (lxw_col_t)(variable + 1));
  add_chart(b);
}

static const char *folder_of_temporaries(void) {
  const char *folder = getenv("TMPDIR");
  return folder && folder[0] ? folder : "/tmp";
}

/* Writes the workbook to a file, since the library can't write to memory. */
static km_status write_file(book *b, const char *path, km_error *error) {
  lxw_workbook_options options = {.tmpdir = (char *)(uintptr_t)folder_of_temporaries()};
  b->workbook = b->lib->workbook_new_opt(path, &options);
  if (!b->workbook)
    return km_fail(error, KM_MEMORY, "out of memory for a workbook");
  fill(b);
  note(b, b->lib->workbook_close(b->workbook));
  if (b->failure == LXW_ERROR_MEMORY_MALLOC_FAILED)
    return km_fail(error, KM_MEMORY, "out of memory for a workbook");
  if (b->failure)
    return km_fail(error, KM_IO, "a workbook can't be written in the folder for temporary files: %s",
                   b->lib->lxw_strerror(b->failure));
  return KM_OK;
}

/* Sheets' names have rules: 1 to 31 characters, none of []:*?/\\ and no apostrophe; the other sheet is called chart. */
static km_status check_name(const char *sheet, km_error *error) {
  const size_t length = strlen(sheet);
  if (length >= 1 && length <= 31 && !strpbrk(sheet, "[]:*?/\\'") && strcasecmp(sheet, "chart") != 0)
    return KM_OK;
  return km_fail(error, KM_USAGE,
                 "\"%.60s\" is not a sheet's name; expected at most 31 bytes without []:*?/\\', and not \"chart\"",
                 sheet);
}

static km_status check_size(const km_table *table, km_error *error) {
  const size_t rows = km_table_rows(table), columns = km_table_columns(table);
  if (rows < LXW_ROW_MAX && columns <= LXW_COL_MAX)
    return KM_OK;
  return km_fail(
      error, KM_USAGE,
      "the table has %zu rows and %zu columns; expected at most %d and %d, which a sheet of a workbook holds, "
      "or csv",
      rows, columns, LXW_ROW_MAX - 1, LXW_COL_MAX);
}

km_status km_xlsx_write(const km_table *table, const char *sheet, const char *curves, km_text *out, km_error *error) {
  km_status status = km_check_given(table && sheet && curves && out, "table, sheet, curves or text", error);
  if (!status)
    status = check_name(sheet, error);
  if (!status)
    status = check_size(table, error);
  book b = {.lib = status ? NULL : km_xlsx_load(error), .table = table, .sheet = sheet, .curves = curves};
  if (!b.lib)
    return status ? status : KM_IO;
  const char *folder = folder_of_temporaries();
  km_text path = {0};
  km_text_format(&path, "%s/kmech-XXXXXX", folder);
  const int file = path.failed ? -1 : mkstemp(path.data);
  if (file < 0) {
    status = path.failed ? km_fail(error, KM_MEMORY, "out of memory for a workbook")
                         : km_fail(error, KM_IO,
                                   "%.300s: no temporary file can be created; expected TMPDIR to name a "
                                   "folder that can be written",
                                   folder);
  } else {
    close(file);
    status = write_file(&b, path.data, error);
    if (!status)
      status = km_file_read(path.data, out, error);
    unlink(path.data);
  }
  km_text_free(&path);
  return status;
}
