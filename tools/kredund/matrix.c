/* kredund matrix: a Jacobian with its path column in, path-control and pose-control columns out. */
#include "kredund/kredund.h"

#include "kmech/arm.h"
#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/version.h"

#include <string.h>

enum { MOST_SIDE = 2000 };

typedef struct options {
  kt_common common;
  const char *file, *base;
  int json;
} options;

/* Numbers row by row, in the order of the file. */
typedef struct sheet {
  double *items;
  size_t capacity, count;
  int rows, columns;
} sheet;

static kt_exit complain(const options *o, int line, int column, const char *found, const char *expected) {
  kt_print_message(&o->common, KM_ERROR, "%s: line %d, column %d: found \"%.40s\"; expected %s", o->file, line, column,
                   found, expected);
  return KT_USAGE;
}

/* A row; `line` ends with a NUL. */
static kt_exit read_row(const options *o, char *line, int number, sheet *out) {
  int columns = 0;
  for (char *field = line, *next; field; field = next) {
    next = strchr(field, ',');
    if (next)
      *next++ = '\0';
    field += strspn(field, " \t");
    for (size_t n = strlen(field); n > 0 && strchr(" \t\r", field[n - 1]);)
      field[--n] = '\0';
    double value;
    ++columns;
    if (!kt_number(field, &value))
      return complain(o, number, columns, field, "a finite number");
    if (!km_reserve((void **)&out->items, &out->capacity, out->count + 1, sizeof *out->items))
      return KT_NO_MEMORY;
    out->items[out->count++] = value;
  }
  if (out->rows > 0 && columns != out->columns) {
    kt_print_message(&o->common, KM_ERROR, "%s: line %d: found %d columns; expected %d as in the lines before", o->file,
                     number, columns, out->columns);
    return KT_USAGE;
  }
  out->columns = columns;
  ++out->rows;
  return KT_DONE;
}

static kt_exit read_sheet(const options *o, sheet *out) {
  km_text text = {0};
  km_error error;
  kt_exit result = KT_DONE;
  km_status status = km_file_read(o->file, &text, &error);
  if (status) {
    kt_print_message(&o->common, KM_ERROR, "%s", error.text);
    result = kt_exit_of(status);
  }
  char *line = text.data;
  if (line && strncmp(line, "\xEF\xBB\xBF", 3) == 0)
    line += 3;
  for (int number = 1; line && *line && result == KT_DONE; ++number) {
    char *next = strchr(line, '\n');
    if (next)
      *next++ = '\0';
    if (line[strspn(line, " \t\r")] != '\0')
      result = read_row(o, line, number, out);
    line = next;
  }
  km_text_free(&text);
  if (result == KT_DONE && (out->rows < 1 || out->columns < 2 || out->rows > MOST_SIDE || out->columns > MOST_SIDE)) {
    kt_print_message(&o->common, KM_ERROR,
                     "%s: found %d rows of %d columns; expected 1 to %d rows of 2 to %d: a Jacobian and its "
                     "path column",
                     o->file, out->rows, out->columns, MOST_SIDE, MOST_SIDE);
    result = KT_USAGE;
  }
  return result;
}

static void write_csv(const double *Z, int rows, int columns, km_text *out) {
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      km_text_number(out, Z[c * rows + r]);
      km_text_add(out, c + 1 < columns ? "," : "\r\n");
    }
}

static void add_columns(km_value *record, const double *Z, const sheet *in, const km_control *control,
                        km_arena *arena) {
  km_value_number(arena, record, "rank", control->rank);
  km_value_number(arena, record, "last_pivot", control->last_pivot);
  km_value_number(arena, record, "first_dropped", control->first_dropped);
  km_value_number(arena, record, "path_entry", control->path_entry);
  km_value *rows = km_value_add(arena, record, "Z", KM_LIST);
  for (int r = 0; r < in->columns && !arena->failed; ++r) {
    km_value *row = km_value_add(arena, rows, NULL, KM_LIST);
    for (int c = 0; c < control->freedom; ++c)
      km_value_number(arena, row, NULL, Z[c * in->columns + r]);
  }
}

/* Without a control the columns are null, and `why` says so. */
static void write_json(const options *o, const double *Z, const sheet *in, const km_control *control, const char *why,
                       km_text *out) {
  km_arena arena = {0};
  km_value *record = km_value_add(&arena, NULL, NULL, KM_OBJECT);
  km_value_string(&arena, record, "kmech", KM_VERSION);
  km_value_string(&arena, record, "tool", "kredund");
  km_value_string(&arena, record, "matrix", o->file);
  if (control) {
    add_columns(record, Z, in, control, &arena);
  } else {
    km_value_add(&arena, record, "Z", KM_NULL);
    km_value_string(&arena, record, "why", why);
  }
  if (arena.failed)
    out->failed = true;
  else
    km_json_write(record, out);
  km_arena_free(&arena);
}

static kt_exit deliver(const options *o, const km_text *out) {
  return o->base ? kt_write(&o->common, o->base, "matrix", o->json ? "json" : "csv", out) : kt_print(&o->common, out);
}

static kt_exit solve(const options *o, const sheet *in) {
  km_error error;
  km_control control;
  km_text out = {0};
  size_t rows = (size_t)in->rows, columns = (size_t)in->columns;
  double *matrix = KM_NEW(double, rows *columns), *Z = KM_NEW(double, columns *columns);
  for (size_t r = 0; r < rows && matrix; ++r)
    for (size_t c = 0; c < columns; ++c)
      matrix[c * rows + r] = in->items[r * columns + c];
  km_status status = matrix && Z ? km_control_of_matrix(matrix, in->rows, in->columns, Z, &control, &error)
                                 : km_fail(&error, KM_MEMORY, "out of memory");
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->file, error.text);
  if (o->json && (!status || status == KM_NO_RESULT))
    write_json(o, Z, in, status ? NULL : &control, error.text, &out);
  else if (!status)
    write_csv(Z, in->columns, control.freedom, &out);
  if (out.size)
    result = kt_worse(result, deliver(o, &out));
  km_text_free(&out);
  km_free(matrix);
  km_free(Z);
  return result;
}

kt_exit kredund_matrix(int argc, char **argv) {
  options o = {.common = KT_COMMON("kredund")};
  kt_options all = {.operand = {"file", "FILE.csv", true, &o.file, NULL}};
  const kt_option table[] = {
      {"format", 0, "FORMAT", "csv (default) or json", KT_WORD("csv or json"), &o.json, KT_ABOUT_FILES},
      KT_BASE(&o.base, "Write BASE.matrix.csv or .json instead of the standard output"),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, 0);
  kt_options_read(&all,
                  "Path-control and pose-control columns of the null space of a Jacobian, whose last column is the "
                  "path's: a CSV file without a header in, the same out.",
                  argc, argv);
  sheet in = {0};
  kt_exit result = read_sheet(&o, &in);
  if (result == KT_DONE)
    result = solve(&o, &in);
  km_free(in.items);
  return result;
}
